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
    "settle_us": 60_000,
    "tail_us": 60_000,
    "gap_us": 50_000,
    "classes": 3,
    "samples_min": 5,
}
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
        "settle_us": draw(st.sampled_from((0, 1, 30_000, exact.TIME_MAX_US))),
        "tail_us": draw(st.sampled_from((0, 255, 30_000, exact.TIME_MAX_US))),
        "gap_us": draw(st.sampled_from((1, 20_000, exact.GAP_MAX_US))),
        "classes": classes,
        "samples_min": draw(st.integers(1, 5)),
    }


def passing(weight_mg, *, stay_s=0.3, gap_s=0.2, swing=0.0, tone_hz=10.0, phase=0.0):
    """Masses at 80 SPS of one product: ramp of 30 ms, damped oscillation, ramp, empty belt."""
    t_s = np.arange(round((stay_s + gap_s) * 80)) / 80
    share = np.clip(np.minimum(t_s, stay_s - t_s) / 0.03, 0, 1)
    ring = swing * np.exp(-t_s / 0.15) * np.cos(2 * np.pi * tone_hz * t_s + phase)
    return np.rint(weight_mg * share + ring * share).astype(int)


def run(checkweigher, masses, start_us=None):
    start_us = checkweigher.last_us if start_us is None else start_us
    return checkweigher.block(masses, times_us(len(masses), start_us=start_us))


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
    counts = [int(word) for word in vector.parameters["final_counts"].split()]
    assert checkweigher.counts == counts[: config["classes"]]
    for field in ("unweighed", "entered_us", "left_us", "per_minute_q8"):
        assert getattr(checkweigher, field) == vector.parameter(f"final_{field}")


def test_checkweigher_vectors_hold_products_weighed_and_unweighed():
    (vector,) = golden("checkweigher_unweighed")
    assert {VERDICT, UNWEIGHED} <= set(vector["event"])


@given(
    config=lawful_configs(),
    rows=st.lists(
        st.tuples(
            st.one_of(int32, st.integers(-2, 1_100_000), st.just(0)),
            st.sampled_from((1, 12_500, 400_000, 1 << 31)),
        ),
        min_size=1,
        max_size=80,
    ),
    start_us=st.integers(0, (1 << 32) - 1),
)
def test_checkweigher_is_its_exact_twin_and_counts_each_product_once(config, rows, start_us):
    checkweigher, twin = Checkweigher(config), exact.Checkweigher(config)
    us, left = start_us, 0
    for mass_mg, elapsed_us in rows:
        us = (us + elapsed_us) % (1 << 32)
        event = checkweigher.update(mass_mg, us)
        assert event == twin.update(mass_mg, us)
        left += event in (VERDICT, UNWEIGHED)
        assert checkweigher.mass_mg == twin.mass_mg
    assert checkweigher.counts == twin.counts[: config["classes"]]
    assert sum(checkweigher.counts) == checkweigher.weighed
    assert checkweigher.weighed + checkweigher.unweighed == left
    assert checkweigher.per_minute_q8 == twin.per_minute_q8


@given(base=st.integers(60_000, 1 << 29), seed=st.integers(0, 99), count=st.integers(1, 40))
def test_checkweigher_is_its_exact_twin_over_stretches_of_any_length(base, seed, count):
    rng = np.random.default_rng(seed)
    spread = rng.choice([10, 100_000, exact.SPREAD_MG, exact.SPREAD_MG + 1])
    masses = [base, *rng.choice([0, spread], count) + base, 0]
    config = USUAL | {"settle_us": 0, "tail_us": 0, "samples_min": 1}
    checkweigher, twin = Checkweigher(config), exact.Checkweigher(config)
    for mass_mg, us in zip(map(int, masses), times_us(len(masses)).tolist(), strict=True):
        assert checkweigher.update(mass_mg, us) == twin.update(mass_mg, us)
    assert checkweigher.mass_mg == twin.mass_mg


@pytest.mark.parametrize("seed", range(8))
def test_checkweigher_is_the_model_within_its_budget(seed):
    rng = np.random.default_rng(seed)
    parts = [
        passing(rng.uniform(100_000, 1_000_000), stay_s=rng.uniform(0.1, 0.6), swing=20_000)
        for _ in range(30)
    ]
    masses = np.concatenate(parts)
    # At odd times, so that no age is near the begin of the tail.
    us = times_us(len(masses), PERIOD_US)
    config = USUAL | {"tail_us": 58_000, "settle_us": 58_000}
    checkweigher, found = Checkweigher(config), []
    for mass_mg, now in zip(masses.tolist(), us.tolist(), strict=True):
        if checkweigher.update(mass_mg, now) in (VERDICT, UNWEIGHED):
            found.append(checkweigher.left_us)
    products = model.checkweigher(masses, us * 1e-6, config)
    assert len(found) == len(products) == 30
    assert found == [round(p.left_s * 1e6) for p in products]
    weighed = [p for p in products if p.mass_mg is not None]
    assert checkweigher.weighed == len(weighed) > 0
    assert checkweigher.samples == weighed[-1].samples
    assert abs(checkweigher.mass_mg - weighed[-1].mass_mg) <= model.MASS_BUDGET_MG
    classes = [p.class_at for p in weighed]
    assert checkweigher.counts == [classes.count(at) for at in range(3)]


def test_checkweigher_classes_hold_their_lower_limit_and_not_their_upper():
    checkweigher = Checkweigher(USUAL)
    for weight, class_at in ((239_999, 0), (240_000, 1), (259_999, 1), (260_000, 2)):
        events, weighed_mg = run(checkweigher, passing(weight))
        assert (events == VERDICT).sum() == 1
        assert weighed_mg[-1] == weight
        assert checkweigher.class_at == class_at
    assert checkweigher.counts == [1, 2, 1]


def test_checkweigher_takes_no_part_of_the_weight_from_before_or_after_the_platform():
    checkweigher = Checkweigher(USUAL)
    for around in (-20_000, 0, 29_000):  # below leave_mg
        masses = passing(500_000)
        masses[masses == 0] = around
        assert run(checkweigher, masses)[1][-1] == 500_000


def test_checkweigher_noise_at_a_threshold_makes_no_second_product():
    checkweigher = Checkweigher(USUAL)
    edge = [0, 31_000, 51_000, 49_000, 31_000, 51_000, *[500_000] * 20, 49_000, 31_000, 45_000, 0]
    events, _ = run(checkweigher, edge)
    assert (events >= VERDICT).sum() == 1


def test_checkweigher_mean_of_ringing_products_is_three_times_as_sure_as_the_plain_one():
    """120 a minute of 200..1000 g, 300 ms on the platform, 8..20 Hz, noise as of the converter."""
    rng = np.random.default_rng(11)
    checkweigher, errors, plain = Checkweigher(USUAL | {"tail_us": 40_000}), [], []
    for _ in range(300):
        weight = rng.uniform(200_000, 1_000_000)
        masses = passing(
            weight, swing=0.02 * weight, tone_hz=rng.uniform(8, 20), phase=rng.uniform(0, 2 * np.pi)
        )
        masses = masses + np.rint(rng.normal(0, 90, len(masses))).astype(int)  # 38.7 counts
        events, weighed_mg = run(checkweigher, masses)
        assert (events == VERDICT).sum() == 1
        errors.append(weighed_mg[-1] - weight)
        plain.append(masses[6 : 6 + checkweigher.samples].mean() - weight)  # after settle_us
    assert abs(np.mean(errors)) <= 0.05 * E_MG
    assert np.std(errors) <= 0.2 * E_MG
    assert np.std(errors) < np.std(plain) / 3
    assert checkweigher.per_minute_q8 / 256 == pytest.approx(120, abs=0.5)


def test_checkweigher_does_not_weigh_through_a_gap_nor_what_is_gone_too_soon():
    checkweigher = Checkweigher(USUAL)
    masses, us = passing(500_000), times_us(40)
    keep = np.r_[0:10, 15:40]  # 75 ms are missing
    events, _ = checkweigher.block(masses[keep], us[keep])
    assert (events == UNWEIGHED).sum() == 1
    events, _ = run(checkweigher, passing(500_000, stay_s=0.12))
    assert (events == UNWEIGHED).sum() == 1
    assert (checkweigher.weighed, checkweigher.unweighed) == (0, 2)
    assert (run(checkweigher, passing(500_000))[0] == VERDICT).sum() == 1


def test_checkweigher_knows_no_pace_before_the_second_product_and_limits_it():
    checkweigher = Checkweigher(USUAL | {"settle_us": 0, "tail_us": 0, "samples_min": 1})
    run(checkweigher, passing(500_000))
    assert checkweigher.per_minute_q8 == 0
    run(checkweigher, [90_000, 0])
    run(checkweigher, [90_000, 0] * 40)
    assert checkweigher.per_minute_q8 == 65_535
    checkweigher.update(90_000, checkweigher.last_us + PERIOD_US)
    for _ in range(8):
        checkweigher.update(0, (checkweigher.last_us + (1 << 31) + (1 << 30)) % (1 << 32))
        checkweigher.update(90_000, (checkweigher.last_us + 1) % (1 << 32))
        checkweigher.update(0, (checkweigher.last_us + (1 << 31) + (1 << 30)) % (1 << 32))
        checkweigher.update(90_000, (checkweigher.last_us + 1) % (1 << 32))
    assert checkweigher.interval_us > 1 << 31
    assert checkweigher.per_minute_q8 == 0


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
        assert other.counts == checkweigher.counts


@pytest.mark.parametrize(
    "changed",
    [
        {"classes": 0},
        {"classes": 9},
        {"limit_mg": [5, 5, *[0] * 5]},
        {"limit_mg": [0, (1 << 30) + 1, *[0] * 5]},
        {"limit_mg": [-(1 << 30) - 1, 0, *[0] * 5]},
        {"leave_mg": 0},
        {"leave_mg": 50_000},
        {"enter_mg": (1 << 30) + 1},
        {"samples_min": 0},
        {"samples_min": 33},
        {"settle_us": exact.TIME_MAX_US + 1},
        {"tail_us": exact.TIME_MAX_US + 1},
        {"gap_us": 0},
        {"gap_us": exact.GAP_MAX_US + 1},
        {"classes": 256},
    ],
)
def test_checkweigher_refuses_what_lies_beyond_its_contract(changed):
    assert not exact.is_lawful(USUAL | changed)
    with pytest.raises(ValueError, match="checkweigher"):
        Checkweigher(USUAL | changed)
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
