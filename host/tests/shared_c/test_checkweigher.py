# SPDX-License-Identifier: MIT
"""checkweigher.c: golden vectors, its exact twin, parity, and one verdict a product."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from host.tests.shared_c.scales import int32, times_us
from terazi.cshared import Checkweigher, CheckweigherEvent
from terazi.models import checkweigher as model
from terazi.models import exact_checkweigher as exact
from terazi.models.vectors import golden

EMPTY, LOADED, VERDICT, UNWEIGHED = CheckweigherEvent
PERIOD_US = 12_500
USUAL = {
    "limit_mg": [240_000, 260_000, 0, 0, 0, 0, 0],
    "enter_mg": 50_000,
    "leave_mg": 30_000,
    "settle_us": 65_000,
    "tail_us": 60_000,
    "gap_us": 20_000,
    "classes": 3,
    "samples_min": 12,
}
AT_ONCE = USUAL | {"settle_us": 0, "tail_us": 0}
E_MG = 1000


@st.composite
def lawful_configs(draw):
    """Any configuration that checkweigher.h allows."""
    classes = draw(st.integers(1, 8))
    limits = draw(
        st.sets(st.integers(-(1 << 30), 1 << 30), min_size=classes - 1, max_size=classes - 1)
    )
    enter_mg = draw(st.integers(2, 1_000_000))
    return {
        "limit_mg": sorted(limits) + [0] * (8 - classes),
        "enter_mg": enter_mg,
        "leave_mg": draw(st.integers(1, enter_mg - 1)),
        "settle_us": draw(st.sampled_from((0, 1, 30_000, 1 << 22))),
        "tail_us": draw(st.sampled_from((0, 255, 30_000, 1 << 22))),
        "gap_us": draw(st.sampled_from((1, 20_000, 500_000))),
        "classes": classes,
        "samples_min": draw(st.integers(12, 14)),
    }


def passing(weight_mg, *, stay_s=0.3, gap_s=0.2, swing=0.0, tone_hz=10.0, phase=0.0):
    """Masses at 80 SPS of one product: ramp of 30 ms, damped oscillation, ramp, empty belt."""
    t_s = np.arange(round((stay_s + gap_s) * 80)) / 80
    share = np.clip(np.minimum(t_s, stay_s - t_s) / 0.03, 0, 1)
    ring = swing * np.exp(-t_s / 0.15) * np.cos(2 * np.pi * tone_hz * t_s + phase)
    return np.rint(weight_mg * share + ring * share).astype(int)


def run(checkweigher, masses):
    return checkweigher.block(masses, times_us(len(masses), start_us=checkweigher.last_us))


def tone(count, *, weight_mg, swing_mg, tone_hz, damping=0.04, phase=0.0, rate_hz=80.0):
    """(n,) int masses of a platform that rings, nothing else; the first at any phase."""
    t_s = np.arange(count) / rate_hz
    omega = 2 * np.pi * tone_hz
    return weight_mg + swing_mg * np.exp(-damping * omega * t_s) * np.cos(omega * t_s + phase)


def weigh(stretch):
    """The weight of a product whose stretch is `stretch` alone, by the C."""
    checkweigher = Checkweigher(AT_ONCE)
    events, weighed_mg = run(checkweigher, np.rint([*stretch, 0, 0, 0, 0]).astype(int))
    assert events.tolist() == [LOADED] * len(stretch) + [EMPTY, EMPTY, EMPTY, VERDICT]
    return int(weighed_mg[-1])


@pytest.mark.parametrize("vector", golden("checkweigher_"), ids=str)
def test_checkweigher_reproduces_vector_bit_for_bit(vector):
    config = {field: vector.parameters[field] for field in USUAL}
    config = {
        field: [int(word) for word in text.split()] if field == "limit_mg" else int(text)
        for field, text in config.items()
    }
    checkweigher = Checkweigher(config)
    events, weighed_mg = checkweigher.block(vector["mass_mg"], vector["device_us"])
    assert events.tolist() == vector["event"]
    assert weighed_mg.tolist() == vector["weighed_mg"]
    for field in ("weighed", "unweighed", "entered_us", "left_us", "per_minute_q8"):
        assert getattr(checkweigher, field) == vector.parameter(f"final_{field}")


def test_checkweigher_vectors_hold_products_weighed_and_unweighed():
    (vector,) = golden("checkweigher_unweighed")
    assert {VERDICT, UNWEIGHED} <= set(vector["event"])


@st.composite
def passages(draw):
    """(mass, us since the one before) of products that come, ring and go, sanely or not."""
    rows = []
    for _ in range(draw(st.integers(1, 4))):
        weight = draw(st.sampled_from((2, 900_000, 1 << 29, 1 << 30)) | st.integers(1, 1_100_000))
        swing, omega = draw(st.floats(0, 0.7)) * weight, draw(st.floats(0.01, 3.1))
        fade, phase = draw(st.floats(0, 0.2)), draw(st.floats(0, 6.3))
        for n in range(draw(st.integers(1, 40))):
            mass = weight + swing * np.exp(-fade * n) * np.cos(omega * n + phase)
            rows.append((int(min(mass, (1 << 31) - 1)), draw(st.sampled_from((12_500, 12_500, 1)))))
        for _ in range(draw(st.integers(1, 3))):
            empty = draw(st.sampled_from((0, -(1 << 31))))
            rows.append((empty, draw(st.sampled_from((12_500, 400_000, 1 << 31)))))
    return rows


@given(
    config=lawful_configs(),
    rows=st.one_of(
        passages(),
        st.lists(
            st.tuples(
                st.one_of(int32, st.integers(-2, 1_100_000), st.just(0)),
                st.sampled_from((1, 12_500, 400_000, 1 << 31)),
            ),
            min_size=1,
            max_size=80,
        ),
    ),
    start_us=st.integers(0, (1 << 32) - 1),
    interrupted=st.sets(st.integers(0, 80), max_size=2),
)
def test_checkweigher_is_its_exact_twin_and_counts_each_product_once(
    config, rows, start_us, interrupted
):
    checkweigher, twin = Checkweigher(config), exact.Checkweigher(config)
    us, left = start_us, 0
    for at, (mass_mg, elapsed_us) in enumerate([*rows, *[(0, 12_500)] * 4]):
        if at in interrupted:
            checkweigher.interrupt()
            twin.interrupt()
        us = (us + elapsed_us) % (1 << 32)
        event = checkweigher.update(mass_mg, us)
        assert event == twin.update(mass_mg, us)
        left += event in (VERDICT, UNWEIGHED)
        assert checkweigher.mass_mg == twin.mass_mg
        assert checkweigher.samples == twin.samples
        assert checkweigher.class_at == twin.class_at
    assert (checkweigher.weighed, checkweigher.unweighed) == (twin.weighed, twin.unweighed)
    assert checkweigher.weighed + checkweigher.unweighed == left
    assert checkweigher.per_minute_q8 == twin.per_minute_q8


@given(
    weight=st.integers(100, 1 << 29),
    share=st.floats(0, 0.15),
    omega=st.floats(0.01, 3.1),
    fade=st.floats(0, 0.3),
    noise=st.sampled_from((0.0, 1e-4, 0.01)),
    count=st.integers(12, 40),
    seed=st.integers(0, 99),
)
def test_checkweigher_solves_as_its_exact_twin_for_any_tone(
    weight, share, omega, fade, noise, count, seed
):
    rng, n = np.random.default_rng(seed), np.arange(count)
    ringing = share * np.exp(-fade * n) * np.cos(omega * n + seed) + rng.normal(0, noise, count)
    masses = [*np.rint(weight * (1 + ringing)).astype(int).tolist(), 0, 0, 0, 0]
    config = AT_ONCE | {"enter_mg": 2, "leave_mg": 1}
    checkweigher, twin = Checkweigher(config), exact.Checkweigher(config)
    for mass_mg, us in zip(masses, times_us(len(masses)).tolist(), strict=True):
        assert checkweigher.update(mass_mg, us) == twin.update(mass_mg, us)
    assert checkweigher.mass_mg == twin.mass_mg
    assert checkweigher.class_at == twin.class_at


@given(
    weight_mg=st.integers(100_000, 2_000_000),
    share=st.floats(0.0, 0.1),
    tone_hz=st.floats(5.0, 20.0),
    damping=st.floats(0.02, 0.06),
    phase=st.floats(0.0, 6.28),
    rate_hz=st.sampled_from((78.0, 80.0, 92.0)),
    seed=st.integers(0, 99),
)
def test_checkweigher_is_the_model_within_its_budget(
    weight_mg, share, tone_hz, damping, phase, rate_hz, seed
):
    """Over at least one period, in the converter's noise."""
    count = int(np.ceil(max(14.0, 0.95 * rate_hz / tone_hz + 4)))
    masses = tone(
        count,
        weight_mg=weight_mg,
        swing_mg=share * weight_mg,
        tone_hz=tone_hz,
        damping=damping,
        phase=phase,
        rate_hz=rate_hz,
    )
    masses = np.rint(masses + np.random.default_rng(seed).normal(0, 90, count))
    off_mg = abs(weigh(masses) - model.weight_mg(masses))
    assert off_mg <= model.budget_mg(masses, masses[0])


@pytest.mark.parametrize("seed", range(4))
def test_checkweigher_finds_the_products_that_the_model_finds(seed):
    rng = np.random.default_rng(seed)
    parts = [
        passing(rng.uniform(100_000, 1_000_000), stay_s=rng.uniform(0.1, 0.6), swing=20_000)
        for _ in range(30)
    ]
    masses = np.concatenate(parts)
    us = times_us(len(masses), PERIOD_US)
    checkweigher, found = Checkweigher(USUAL), []
    for mass_mg, now in zip(masses.tolist(), us.tolist(), strict=True):
        event = checkweigher.update(mass_mg, now)
        if event in (VERDICT, UNWEIGHED):
            class_at = checkweigher.class_at if event == VERDICT else None
            found.append((checkweigher.left_us, class_at, checkweigher.samples))
    products = model.checkweigher(masses, us * 1e-6, USUAL)
    assert len(found) == len(products) == 30
    told = [(round(p.left_s * 1e6), p.class_at, p.samples) for p in products]
    assert found == told
    weighed = [p for p in products if p.mass_mg is not None]
    assert checkweigher.weighed == len(weighed) > 12


@given(
    weight_mg=st.integers(200_000, 1_000_000),
    tone_hz=st.floats(5.0, 20.0),
    damping=st.floats(0.0, 0.1),
    phase=st.floats(0.0, 6.28),
)
def test_checkweigher_sees_through_a_tone_without_noise(weight_mg, tone_hz, damping, phase):
    masses = tone(
        20, weight_mg=weight_mg, swing_mg=30_000, tone_hz=tone_hz, damping=damping, phase=phase
    )
    assert abs(weigh(masses) - weight_mg) <= 0.12 * E_MG  # the units of 2^5 mg, 3.3 at 20 samples
    assert abs(model.weight_mg(masses) - weight_mg) < 1e-3


@given(
    base=st.integers(100_000, 1 << 29),
    values=st.lists(st.integers(-150, 150), min_size=12, max_size=32),
)
def test_checkweigher_weight_of_what_is_no_tone_stays_near_its_masses(base, values):
    masses = np.array([base + value * (base >> 10) for value in values])
    spread, inner = np.ptp(masses), len(masses) - 6
    bound = spread + 32 / inner * spread  # 2^16 steps in the sum, the spread >= 2^11 of them
    assert abs(weigh(masses) - masses.mean()) <= bound + (base >> 13)


def test_checkweigher_classes_hold_their_lower_limit_and_not_their_upper():
    checkweigher = Checkweigher(USUAL)
    for weight, class_at in ((239_999, 0), (240_000, 1), (259_999, 1), (260_000, 2)):
        events, weighed_mg = run(checkweigher, passing(weight))
        assert (events == VERDICT).sum() == 1
        assert weighed_mg[-1] == weight
        assert checkweigher.class_at == class_at
    assert checkweigher.weighed == 4


def test_checkweigher_takes_no_part_of_the_weight_from_before_or_after_the_platform():
    checkweigher = Checkweigher(USUAL)
    for around in (-20_000, 0, 29_000):  # below leave_mg
        masses = passing(500_000)
        masses[masses == 0] = around
        assert run(checkweigher, masses)[1][-1] == 500_000


def test_checkweigher_noise_at_a_threshold_makes_no_second_product():
    checkweigher = Checkweigher(USUAL)
    edge = [0, 31_000, 51_000, 49_000, 31_000, 51_000, *[500_000] * 20, 49_000, 31_000, 45_000, 0]
    events, _ = run(checkweigher, [*edge, 0, 0, 0])
    assert (events >= VERDICT).sum() == 1


def test_checkweigher_does_not_weigh_through_a_gap_nor_what_is_gone_too_soon():
    checkweigher = Checkweigher(USUAL)
    masses, us = passing(500_000), times_us(40)
    keep = np.r_[0:10, 11:40]  # one is missing
    events, _ = checkweigher.block(masses[keep], us[keep])
    assert (events == UNWEIGHED).sum() == 1
    events, _ = run(checkweigher, passing(500_000, stay_s=0.2))
    assert (events == UNWEIGHED).sum() == 1
    assert (checkweigher.weighed, checkweigher.unweighed) == (0, 2)
    assert (run(checkweigher, passing(500_000))[0] == VERDICT).sum() == 1


def test_checkweigher_does_not_weigh_what_was_interrupted_and_weighs_the_next():
    checkweigher = Checkweigher(USUAL)
    masses = passing(500_000)
    run(checkweigher, masses[:12])
    checkweigher.interrupt()
    assert (run(checkweigher, masses[12:])[0] == UNWEIGHED).sum() == 1
    checkweigher.interrupt()  # on an empty belt: nothing
    assert (run(checkweigher, masses)[0] == VERDICT).sum() == 1


def test_checkweigher_does_not_weigh_what_swings_by_its_weight():
    checkweigher = Checkweigher(AT_ONCE)
    events, _ = run(checkweigher, [*[600_000] * 20, 1_660_000, *[600_000] * 5, 0])
    assert events[-1] == UNWEIGHED
    events, _ = run(checkweigher, [*[600_000] * 20, 1_195_000, *[600_000] * 5, 0, 0, 0, 0])
    assert events[-1] == VERDICT


def test_checkweigher_that_is_followed_at_once_gives_both_verdicts():
    checkweigher = Checkweigher(AT_ONCE)
    product = [500_000] * 20
    events, weighed_mg = run(checkweigher, [*product, 0, *[700_000] * 20, 0, 0, 0, 0])
    assert events.tolist().count(VERDICT) == 2
    assert weighed_mg[23:25].tolist() == [500_000] * 2
    assert weighed_mg[-1] == 700_000
    # gone again before the verdict on the former: both are counted, one after the other
    events, _ = run(checkweigher, [*product, 0, 700_000, 0, 0, 0])
    assert events[-4:].tolist() == [LOADED, LOADED, VERDICT, UNWEIGHED]


def test_checkweigher_knows_no_pace_before_the_second_product_and_limits_it():
    checkweigher = Checkweigher(AT_ONCE)
    run(checkweigher, passing(500_000))
    assert checkweigher.per_minute_q8 == 0
    run(checkweigher, [90_000, 0])
    run(checkweigher, [90_000, 0] * 40)
    assert checkweigher.per_minute_q8 == 65_535
    for _ in range(60):
        checkweigher.update(90_000, (checkweigher.last_us + 1) % (1 << 32))
        checkweigher.update(0, (checkweigher.last_us + (1 << 32) - 2) % (1 << 32))
    assert checkweigher.per_minute_q8 == 3  # 60e6 / 2^32 of one, Q8


@given(config=lawful_configs(), cut=st.integers(0, 199), seed=st.integers(0, 9))
def test_checkweigher_saved_restored_or_copied_continues_identically(config, cut, seed):
    rng = np.random.default_rng(seed)
    masses = np.concatenate([passing(rng.integers(1, 2_000_000), stay_s=0.3) for _ in range(5)])
    us = times_us(200)
    checkweigher = Checkweigher(config)
    checkweigher.block(masses[:cut], us[:cut])
    copy, restored = checkweigher.copy(), Checkweigher(config)
    restored.restore(checkweigher.save())
    expected = [each.tolist() for each in checkweigher.block(masses[cut:], us[cut:])]
    for other in (copy, restored):
        assert [each.tolist() for each in other.block(masses[cut:], us[cut:])] == expected
        assert other.weighed == checkweigher.weighed


@pytest.mark.parametrize(
    "changed",
    [
        {"classes": 0},
        {"classes": 9},
        {"limit_mg": [5, 5, *[0] * 5]},
        {"leave_mg": 50_000},
        {"samples_min": 11},
        {"samples_min": 33},
        {"classes": 256},
    ],
)
def test_checkweigher_refuses_what_lies_beyond_its_contract(changed):
    with pytest.raises(ValueError, match="checkweigher"):
        Checkweigher(USUAL | changed)


@pytest.mark.parametrize("changed", [{"limit_mg": [5, 5, *[0] * 5]}, {"leave_mg": 50_000}])
def test_checkweigher_twin_refuses_what_contradicts_itself(changed):
    with pytest.raises(ValueError, match="refuses"):
        exact.Checkweigher(USUAL | changed)


def test_checkweigher_refuses_arrays_that_do_not_fit():
    checkweigher = Checkweigher(USUAL)
    with pytest.raises(ValueError, match="2 masses and 1 times"):
        checkweigher.block([1, 2], [3])
    with pytest.raises(ValueError, match="not the state"):
        checkweigher.restore(b"")
    with pytest.raises(AttributeError):
        _ = checkweigher._unknown
