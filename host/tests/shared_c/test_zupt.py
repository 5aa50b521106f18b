# SPDX-License-Identifier: MIT
"""zupt.c: golden vectors, laws for all inputs, and parity with the float64 model."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from terazi.cshared import ZUPT_DETECTORS, ZUPT_RATES, Zupt
from terazi.cshared._cshared import lib
from terazi.design import zupt as design
from terazi.models import exact_zupt
from terazi.models import zupt as model
from terazi.models.vectors import golden

NAMES = tuple(ZUPT_DETECTORS)
RATE_HZ = 500.0
GYRO = np.degrees(design.spec()["sensor"]["gyro_counts_per_deg_s"])
ACC = design.spec()["sensor"]["acc_counts_per_g"] / model.STANDARD_GRAVITY_M_S2
FIELDS = ("detector", "acc_weight", "gyro_weight", "still_blocks", "stride")
edge = st.sampled_from((-32768, -4097, -4096, -2048, -1, 0, 2048, 4095, 4096, 32767))
value = st.one_of(edge, st.integers(-4096, 4095), st.integers(-32768, 32767))
small = st.integers(-60, 60)
vectors = st.tuples(value, value, value)
lying_vectors = st.tuples(small, small, st.integers(1990, 2110))


@st.composite
def lawful_configs(draw):
    """Any configuration that zupt.h allows."""
    name = draw(st.sampled_from(NAMES))
    enter = draw(st.integers(0, 31).flatmap(lambda bits: st.integers(1, 1 << bits)))
    return {
        "begin_squares": [-enter, -draw(st.integers(enter, 1 << 31))],
        "detector": ZUPT_DETECTORS[name],
        "acc_weight": design.ACC_WEIGHT[name],
        "gyro_weight": draw(st.integers(1, lib.ZUPT_WEIGHT_MAX)) if design.turns(name) else 0,
        "still_blocks": draw(st.integers(1, 3)),
        "stride": draw(st.integers(1, 3)),
    }


def lying(count, *, noise=2.0, seed=1, acc=(300, -200, 2016)):
    """(gyro, acc) of a board at rest, (count, 3) int16 each."""
    rng = np.random.default_rng(seed)
    gyro = np.rint(rng.normal((4, -3, 2), noise, (count, 3)))
    return gyro.astype(np.int16), np.rint(rng.normal(acc, 2 * noise, (count, 3))).astype(np.int16)


def shaken(count, rate, accel, seed=2):
    """The same with noise of (rate, accel) counts as a root mean square of three axes."""
    rng = np.random.default_rng(seed)
    gyro = rng.normal(0, rate / np.sqrt(3), (count, 3))
    acc = rng.normal((0, 0, 2048), accel / np.sqrt(3), (count, 3))
    return np.rint(gyro).astype(np.int16), np.rint(acc).astype(np.int16)


def columns(vector, sensor):
    return np.column_stack([vector[f"{sensor}_{axis}_counts"] for axis in "xyz"])


def config_of(vector):
    limits = [vector.parameter(f"begin_{side}_squares") for side in ("enter", "leave")]
    return {field: vector.parameter(field) for field in FIELDS} | {"begin_squares": limits}


@pytest.mark.parametrize("vector", golden("zupt_[!g]"), ids=str)
def test_zupt_reproduces_vector_bit_for_bit(vector):
    zupt = Zupt(config_of(vector))
    still = zupt.block(columns(vector, "gyro"), columns(vector, "acc"))
    assert still.astype(int).tolist() == vector["still"]
    assert zupt.rejected == vector.parameter("rejected")


def test_zupt_vectors_hold_every_detector_still_and_moving_and_rails():
    found = golden("zupt_[!g]")
    for number in ZUPT_DETECTORS.values():
        flags = {f for v in found if v.parameter("detector") == number for f in v["still"]}
        assert flags == {0, 1}
    assert max(vector.parameter("rejected") for vector in found) > 0


@given(
    config=lawful_configs(),
    lead=st.integers(0, 60),
    samples=st.lists(
        st.one_of(st.tuples(lying_vectors, lying_vectors), st.tuples(vectors, vectors)),
        max_size=90,
    ),
)
def test_zupt_is_its_exact_twin_on_any_samples(config, lead, samples):
    zupt, twin = Zupt(config), exact_zupt.Zupt(config)
    for gyro, acc in [((0, 0, 0), (0, 0, 2048))] * lead + samples:
        assert zupt.update(gyro, acc) == bool(twin.update(gyro, acc))
    assert zupt.rejected == twin.rejected


@given(config=lawful_configs(), seed=st.integers(0, 999), size=st.floats(0.2, 3.0))
def test_zupt_is_its_exact_twin_around_its_limits(config, seed, size):
    """Noise whose squares are near the limit, so that blocks fall on both sides."""
    counts = min((-config["begin_squares"][0] / 24) ** 0.5 * size, 1200)
    gyro, acc = shaken(160, counts, counts, seed)
    zupt, twin = Zupt(config), exact_zupt.Zupt(config)
    expected = [bool(twin.update(*p)) for p in zip(gyro.tolist(), acc.tolist(), strict=True)]
    assert zupt.block(gyro, acc).tolist() == expected


@pytest.mark.parametrize("corner", [-4096, 4095])
@pytest.mark.parametrize("name", NAMES)
def test_zupt_sums_hold_the_largest_values_under_the_widest_limits(name, corner):
    """The bound of the notes: nothing overflows (UBSan), and nothing is below the widest limit
    that would not be so in unbounded integers."""
    config = {**design.config_at(name), "begin_squares": [-1, -1], "still_blocks": 1, "stride": 1}
    config["gyro_weight"] = lib.ZUPT_WEIGHT_MAX if design.turns(name) else 0
    extreme = np.full((45, 3), corner, dtype=np.int16)
    alternating = extreme.copy()
    alternating[::4] = -4096
    for acc in (extreme, alternating):
        twin = exact_zupt.Zupt(config)
        expected = [bool(twin.update(g, a)) for g, a in zip(extreme.tolist(), acc.tolist(),
                                                            strict=True)]  # fmt: skip
        assert Zupt(config).block(extreme, acc).tolist() == expected


@pytest.mark.parametrize("rate", ZUPT_RATES)
@pytest.mark.parametrize("name", NAMES)
def test_zupt_configuration_in_rom_is_that_of_the_spec(name, rate):
    (entry,) = (each for each in design.spec()["rate"] if each["name"] == rate)
    built = Zupt(name, rate)._c.config
    wanted = design.config(design.entry_of(name), design.spec()["sensor"], entry["stride"])
    assert list(built.begin_squares) == wanted.pop("begin_squares")
    assert {field: getattr(built, field) for field in wanted} == wanted


@pytest.mark.parametrize("rate", ZUPT_RATES)
@pytest.mark.parametrize("name", NAMES)
def test_zupt_is_still_after_as_many_quiet_blocks_and_not_before(name, rate):
    entry, stride = design.entry_of(name), ZUPT_RATES[rate]
    visits = design.VISITS * entry["still_blocks"]
    first = (visits - 1) * stride  # sample whose visit judges
    still = Zupt(name, rate).block(*lying(first + 200))
    assert not still[:first].any()
    assert still[first:].all()


@pytest.mark.parametrize(
    ("name", "rate", "accel"),
    [
        ("shoe", 1.0, 0.0),
        ("shoe", 0.0, 1.0),
        ("are", 1.0, 0.0),
        ("moving_variance", 0.0, 1.155),  # of n samples about their own mean: (n - 1) / n
        ("magnitude", 0.0, 1.732),  # only what lies along gravity changes the magnitude
    ],
)
def test_zupt_limits_are_those_of_the_spec_in_their_units(name, rate, accel):
    """Noise of 0.7 and of 1.4 times the limit: as good as always and never quiet."""
    entry, sensor = design.entry_of(name), design.spec()["sensor"]
    limit = entry["enter_rad_s" if design.turns(name) else "enter_m_s2"]
    counts = limit * design.counts_per_unit(name, sensor)
    if name == "shoe":
        accel *= np.sqrt(design.gyro_weight(entry, sensor))
    shares = [
        Zupt(name).block(*shaken(9000, rate * counts * size, accel * counts * size)).mean()
        for size in (0.7, 1.6)
    ]
    assert shares[0] > 0.75
    assert shares[1] < 0.1


@pytest.mark.parametrize("name", NAMES)
def test_zupt_has_hysteresis(name):
    """A motion between both limits is not still, but does not end stillness."""
    entry, sensor = design.entry_of(name), design.spec()["sensor"]
    unit = "rad_s" if design.turns(name) else "m_s2"
    between = (entry[f"enter_{unit}"] + entry[f"leave_{unit}"]) / 2
    between *= design.counts_per_unit(name, sensor)
    # The weight's own rounding stays inside: 11 m/s^2 a rad/s is a weight of 5.99.
    count = 2 * design.VISITS * 4
    gyro, acc = np.zeros((count, 3), np.int16), np.full((count, 3), (0, 0, 2048), np.int16)
    calm = gyro.copy(), acc.copy()
    if design.turns(name):
        gyro[:, 0] = between
    elif name == "moving_variance":
        late = np.arange(count) % design.VISITS >= design.BLOCK
        acc[:, 0] = np.where(late, -between, between)  # two of a block's four on either side
    else:
        acc[:, 2] += round(between)
    assert not Zupt(name).block(gyro, acc).any()
    zupt = Zupt(name)
    assert zupt.block(*calm)[-1]
    assert zupt.block(gyro, acc).all()


@pytest.mark.parametrize("name", NAMES)
def test_zupt_ends_with_the_first_block_that_moves(name):
    zupt = Zupt(name)
    assert zupt.block(*lying(4 * design.VISITS))[-1]
    still = zupt.block(*shaken(design.VISITS, 2500, 2500))
    assert not still[-1]


@pytest.mark.parametrize("name", NAMES)
def test_zupt_takes_a_value_beyond_for_motion_at_once_and_counts_those_on_a_rail(name):
    sensor = "gyro" if name == "are" else "acc"
    for value, counted in ((4095, 0), (4096, 0), (-4097, 0), (32767, 1), (-32768, 1)):
        zupt = Zupt(name)
        gyro, acc = lying(72)
        assert zupt.block(gyro, acc)[-1]
        beyond = np.array((0, value, 2048), dtype=np.int16)
        for n in range(4):  # one of them is a visit to the sensor
            pair = {"gyro": gyro[n], "acc": acc[n], sensor: beyond}
            zupt.update(pair["gyro"], pair["acc"])
        assert zupt.still == (value == 4095)
        assert bool(zupt.rejected) == bool(counted)


def test_zupt_looks_only_at_the_sensors_that_a_detector_needs():
    gyro, acc = lying(180)
    dead = np.full_like(acc, 32767)
    assert Zupt("are").block(gyro, dead)[-1]
    assert Zupt("moving_variance").block(dead, acc)[-1]
    assert Zupt("magnitude").block(dead, acc)[-1]
    assert not Zupt("shoe").block(dead, acc).any()
    assert not Zupt("shoe").block(gyro, dead).any()


def test_zupt_sees_a_steady_turn_and_a_steady_push_where_its_detector_can():
    """What each detector is blind to: variance to a steady turn, rate to a push."""
    gyro, acc = lying(360)
    turning = gyro.copy()
    turning[:, 2] = round(1.5 * GYRO)
    pushed = acc.copy()
    pushed[:, 2] += round(2.5 * ACC)
    assert [name for name in NAMES if not Zupt(name).block(turning, acc).any()] == ["shoe", "are"]
    assert [name for name in NAMES if not Zupt(name).block(gyro, pushed).any()] == ["magnitude"]
    falling = np.zeros_like(acc)
    assert "magnitude" in [name for name in NAMES if not Zupt(name).block(gyro, falling).any()]


@pytest.mark.parametrize("name", NAMES)
def test_zupt_after_a_gap_begins_anew(name):
    gyro, acc = lying(200)
    zupt = Zupt(name)
    assert zupt.block(gyro, acc)[-1]
    zupt.interrupt()
    assert not zupt.still
    assert not zupt.update(gyro[0], acc[0])
    assert zupt.block(gyro, acc)[-1]


def test_zupt_switched_off_is_never_still():
    zupt = Zupt("shoe")
    gyro, acc = lying(100)
    assert zupt.block(gyro, acc)[-1]
    for number in (lib.ZUPT_OFF, 5, 255):
        lib.zupt_choose(zupt._c, number, 1)
        assert not zupt.block(gyro, acc).any()
    lib.zupt_choose(zupt._c, lib.ZUPT_ARE, 1)
    assert not zupt.still
    assert zupt.block(gyro, acc)[-1]


@given(config=lawful_configs(), cut=st.integers(0, 120), seed=st.integers(0, 9))
def test_zupt_saved_restored_or_copied_continues_identically(config, cut, seed):
    counts = min((-config["begin_squares"][0] / 24) ** 0.5, 1000)
    gyro, acc = shaken(120, counts, counts, seed)
    zupt = Zupt(config)
    zupt.block(gyro[:cut], acc[:cut])
    copy, restored = zupt.copy(), Zupt("magnitude")
    restored.restore(zupt.save())
    expected = zupt.block(gyro[cut:], acc[cut:]).tolist()
    for other in (copy, restored):
        assert other.block(gyro[cut:], acc[cut:]).tolist() == expected


def physical(gyro, acc):
    return gyro / GYRO, acc / ACC


@pytest.mark.parametrize("rate_hz", [200.0, 500.0, 1000.0])
@pytest.mark.parametrize("name", NAMES)
def test_zupt_decides_as_the_model_wherever_rounding_cannot_matter(name, rate_hz):
    """Whole counts go in, so that only the C's own rounding is between them: the model says by
    `margin` whether any block of the run comes so near to its limit."""
    told, compared = 0, 0
    config = design.config_at(name, rate_hz)
    size = (-config["begin_squares"][0] / design.squares_per_count2(
        design.entry_of(name), design.spec()["sensor"])) ** 0.5  # fmt: skip
    for seed in range(12):
        parts = [lying(90, seed=seed)]
        parts += [shaken(120, size * scale, 1.5 * size * scale, seed) for scale in (0.6, 0.9, 1.2)]
        gyro, acc = (np.vstack(each) for each in zip(*parts, strict=True))
        truth = model.zupt(*physical(gyro, acc), detector=name, rate_hz=rate_hz)
        still = Zupt(config).block(gyro, acc)
        compared += 1
        if truth.margin > 0:
            told += 1
            assert still.tolist() == truth.still.tolist()
    assert told >= compared / 2


@pytest.mark.parametrize("off_m_s2", [-1.3, -1.0, 0.4, 1.0, 1.3])
def test_zupt_bracket_is_within_the_notes_of_the_classical_magnitude(off_m_s2):
    """|a| - g to first order: too large by the share (|a| - g) / 2g of itself, no more."""
    acc = np.tile((0.0, 0.0, model.STANDARD_GRAVITY_M_S2 + off_m_s2), (90, 1))
    gyro = np.zeros_like(acc)
    runs = [
        model.zupt(gyro, acc, detector="magnitude", rate_hz=500.0, classical=classical)
        for classical in (False, True)
    ]
    first, exact = (run.motion[0] for run in runs)
    assert exact == pytest.approx(abs(off_m_s2))
    assert first / exact == pytest.approx(1 + off_m_s2 / (2 * model.STANDARD_GRAVITY_M_S2))


def test_zupt_model_rejects_what_is_no_number():
    gyro, acc = (each.astype(float) for each in physical(*lying(180)))
    calm = model.zupt(gyro, acc, detector="shoe", rate_hz=RATE_HZ)
    gyro[100:103, 0], acc[110:113, 1], acc[120:123, 2] = np.nan, np.inf, 1e9
    truth = model.zupt(gyro, acc, detector="shoe", rate_hz=RATE_HZ)
    assert calm.rejected == 0
    assert calm.still[60:].all()
    assert truth.rejected >= 3  # three in a row hold a visit to either sensor
    assert not truth.still[102:135].any()
    assert truth.still[-1]


def test_zupt_refuses_what_breaks_the_contract():
    shoe = design.config_at("shoe")
    with pytest.raises(ValueError, match="no detector 'learnt'"):
        Zupt("learnt")
    with pytest.raises(ValueError, match="no rate '50hz'"):
        Zupt("shoe", "50hz")
    for broken in (
        {"detector": 0},
        {"detector": 5},
        {"acc_weight": 2},
        {"gyro_weight": 0},
        {"gyro_weight": lib.ZUPT_WEIGHT_MAX + 1},
        {"still_blocks": 0},
        {"stride": 0},
        {"stride": 256},
        {"begin_squares": [0, -5]},
        {"begin_squares": [-5, -4]},
        {"begin_squares": [-5, -(1 << 31) - 1]},
    ):
        with pytest.raises(ValueError, match="zupt"):
            Zupt({**shoe, **broken})
    for name, changed in (("are", {"acc_weight": 1}), ("magnitude", {"acc_weight": 1}),
                          ("moving_variance", {"gyro_weight": 1})):  # fmt: skip
        with pytest.raises(ValueError, match="beyond"):
            Zupt({**design.config_at(name), **changed})
    with pytest.raises(ValueError, match="gyro_weight"):
        design.config_at("shoe", m_s2_per_rad_s=20.0)
    with pytest.raises(ValueError, match="begin_squares"):
        design.config_at("are", leave_rad_s=0.5)
    with pytest.raises(ValueError, match="no enter_m_s2"):
        design.config_at("are", enter_m_s2=0.5)
    with pytest.raises(ValueError, match="no detector"):
        design.config_at("learnt")
    zupt = Zupt("shoe")
    with pytest.raises(ValueError, match="not the state"):
        zupt.restore(b"")
    with pytest.raises(ValueError, match="2 gyroscope and 1"):
        zupt.block([[0, 0, 0]] * 2, [[0, 0, 0]])
