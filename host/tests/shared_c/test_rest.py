# SPDX-License-Identifier: MIT
"""rest.c: golden vectors, laws for all inputs, and parity with the float64 model."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from terazi.cshared import REST_RATES, Mahony, Rest
from terazi.cshared._cshared import lib
from terazi.design import rest as design
from terazi.models import exact_imu
from terazi.models import rest as model
from terazi.models.vectors import golden

AT_REST, BIAS_KNOWN = exact_imu.AT_REST, exact_imu.BIAS_KNOWN
HIGH = exact_imu.INT16_MAX
int16 = st.integers(exact_imu.INT16_MIN, HIGH)
vectors = st.tuples(int16, int16, int16)
RATE_HZ = 100.0
CONFIG = design.config_at(RATE_HZ)
GYRO = model.design.spec()["sensor"]["gyro_counts_per_deg_s"]
ACC = model.design.spec()["sensor"]["acc_counts_per_g"]


@st.composite
def lawful_configs(draw):
    """Any configuration that rest.h allows."""
    bias_max = draw(st.integers(0, lib.REST_GYRO_LIMIT_MAX))
    leave_gyro = draw(st.integers(0, lib.REST_GYRO_LIMIT_MAX - bias_max))
    leave_acc = draw(st.integers(0, lib.REST_ACC_LIMIT_MAX))
    gravity2_max = draw(st.integers(0, 2**16 - 1))
    return {
        "enter_acc_counts": draw(st.integers(0, leave_acc)),
        "leave_acc_counts": leave_acc,
        "enter_gyro_counts": draw(st.integers(0, leave_gyro)),
        "leave_gyro_counts": leave_gyro,
        "bias_max_counts": bias_max,
        "lowpass_q16": draw(st.integers(1, 32767)),
        "still_rounds": draw(st.sampled_from([1, 2, 3, 7, 8, 15, 16, 24])),
        "gain_len": draw(st.integers(1, 255)),
        "gravity2_min": draw(st.integers(0, gravity2_max)),
        "gravity2_max": gravity2_max,
    }


def lying(count, *, bias=(10, -7, 4), noise=2.0, seed=1):
    """(gyro, acc) of a board at rest, (count, 3) int16 each."""
    rng = np.random.default_rng(seed)
    gyro = np.rint(bias + rng.normal(0, noise, (count, 3)))
    acc = np.rint(rng.normal((300, -200, 2010), 2 * noise, (count, 3)))
    return gyro.astype(np.int16), acc.astype(np.int16)


@pytest.mark.parametrize("vector", golden("rest_"), ids=str)
def test_rest_reproduces_vector_bit_for_bit(vector):
    gyro, acc, bias = (
        np.column_stack([vector[f"{name}_{axis}_{unit}"] for axis in "xyz"])
        for name, unit in (("gyro", "counts"), ("acc", "counts"), ("bias", "q16"))
    )
    rest = Rest({field: vector.parameter(field) for field in CONFIG})
    bias_q16, flags = rest.block(gyro, acc)
    assert flags.tolist() == vector["flags"]
    assert bias_q16.tolist() == bias.tolist()
    assert rest.rejected == vector.parameter("rejected")
    assert rest.implausible == vector.parameter("implausible")


def test_rest_vectors_reach_every_counter_and_every_flag():
    found = golden("rest_")
    assert {flag for vector in found for flag in vector["flags"]} == {0, 1, 2, 3}
    assert max(vector.parameter("rejected") for vector in found) > 0
    assert max(vector.parameter("implausible") for vector in found) > 0


@given(config=lawful_configs(), samples=st.lists(st.tuples(vectors, vectors), min_size=1))
def test_rest_is_its_exact_twin_on_any_samples(config, samples):
    rest = Rest(config)
    twin = exact_imu.Rest(config)
    for gyro, acc in samples:
        assert rest.update(gyro, acc) == twin.update(gyro, acc)
        assert rest.bias_q16 == tuple(twin.bias_q16)
    assert (rest.rejected, rest.implausible) == (twin.rejected, twin.implausible)


@given(
    config=lawful_configs(),
    level=st.tuples(*[st.integers(-1023, 1023)] * 3),
    seed=st.integers(0, 99),
)
def test_rest_is_its_exact_twin_while_it_learns(config, level, seed):
    """Nearly constant samples, so that blocks end under most configurations."""
    config = {**config, "gravity2_min": 0, "gravity2_max": 2**16 - 1}
    gyro, acc = lying(280, bias=level, noise=0.6, seed=seed)
    rest = Rest(config)
    twin = exact_imu.Rest(config)
    pairs = list(zip(gyro.tolist(), acc.tolist(), strict=True))
    flags = [twin.update(*pair) for pair in pairs]
    bias_q16, ours = rest.block(gyro, acc)
    assert ours.tolist() == flags
    assert bias_q16[-1].tolist() == twin.bias_q16


@given(config=lawful_configs(), samples=st.lists(st.tuples(vectors, vectors), min_size=1))
def test_rest_bias_never_leaves_what_a_sample_at_rest_can_be(config, samples):
    rest = Rest(config)
    limit_q16 = (config["bias_max_counts"] + config["leave_gyro_counts"] + 1) << 16
    for gyro, acc in samples * 3:
        rest.update(gyro, acc)
        assert max(map(abs, rest.bias_q16)) <= limit_q16


@pytest.mark.parametrize("rate", REST_RATES)
def test_rest_configuration_in_rom_is_that_of_the_spec(rate):
    (entry,) = (each for each in design.spec()["rate"] if each["name"] == rate)
    built = getattr(lib, f"rest_{rate}")
    wanted = design.config_at(entry["rate_hz"])
    limits = [list(row) for row in built.limit_counts]
    built = {field: getattr(built, field) for field in dir(built)} | {"limit_counts": limits}
    assert built == design.as_c(wanted)


@pytest.mark.parametrize("rate", REST_RATES)
def test_rest_begins_after_the_time_of_the_spec_and_learns_the_mean(rate):
    """At first an eighth of it, in whole rounds, and one more, in which gravity comes."""
    (entry,) = (each for each in design.spec()["rate"] if each["name"] == rate)
    times, rate_hz = design.spec()["times"], entry["rate_hz"]
    gyro, acc = lying(round(4 * rate_hz))
    rest = Rest(rate)
    bias_q16, flags = rest.block(gyro, acc)
    first_s = np.argmax(flags & AT_REST) / rate_hz
    assert abs(first_s - times["still_s"] / 8) <= 12 / rate_hz
    assert flags[-1] == AT_REST | BIAS_KNOWN
    assert np.abs(bias_q16[-1] / 65536 - (10, -7, 4)).max() < 1.0
    assert rest.rejected == rest.implausible == 0
    rest.interrupt()
    _, flags = rest.block(gyro, acc)
    again_s = np.argmax(flags & AT_REST) / rate_hz
    assert abs(again_s - times["still_s"]) <= 13 / rate_hz


def test_rest_short_stillness_lasts_until_a_block_was_learnt_and_is_the_designs():
    assert lib.REST_FIRST_SHIFT == design.FIRST_SHIFT
    assert 1 << design.FIRST_SHIFT == exact_imu.FIRST_DIVISOR
    assert design.timing(RATE_HZ, design.spec()["times"])["first_rounds"] == 3
    gyro, acc = lying(1200)
    rest = Rest(CONFIG)
    for _ in range(3):  # broken off in the first block: a short one again
        _, flags = rest.block(gyro[:60], acc[:60])
        assert flags[-1] == AT_REST
        rest.interrupt()
    _, flags = rest.block(gyro[:150], acc[:150])
    assert flags[-1] == AT_REST | BIAS_KNOWN
    rest.interrupt()
    _, flags = rest.block(gyro[:60], acc[:60])
    assert flags[-1] == BIAS_KNOWN


@pytest.mark.parametrize("rate", ["500hz", "1000hz"])
@pytest.mark.parametrize("seed", range(8))
def test_rest_knows_the_bias_in_time_for_an_attitude_within_one_degree(rate, seed):
    """From any attitude, with a bias near the most that is learnt, half a second after the start
    and from then on."""
    rate_hz = int(rate.removesuffix("hz"))
    rng = np.random.default_rng(seed)
    up = rng.normal(size=3)
    up /= np.linalg.norm(up)
    gyro, _ = lying(8 * rate_hz, bias=np.array([1.9, -1.5, 1.0]) * GYRO, noise=1.0, seed=seed)
    acc = np.rint(rng.normal(ACC * up, 4.0, gyro.shape)).astype(np.int16)
    quats = Mahony(rate).block(gyro, acc, rest=Rest(rate)) / 2.0**30
    w, x, y, z = quats[rate_hz // 2 :].T
    felt = np.column_stack(
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z]
    )
    off_deg = np.degrees(np.arctan2(np.linalg.norm(np.cross(felt, up), axis=1), felt @ up))
    assert off_deg.max() < 1.0
    assert off_deg[-1] < 0.1


def test_rest_ends_with_the_first_visit_that_sees_motion():
    gyro, acc = lying(600)
    rest = Rest(CONFIG)
    rest.block(gyro, acc)
    moved = np.full((6, 3), 400, dtype=np.int16)
    _, flags = rest.block(moved, acc[:6])
    assert flags[0] & AT_REST  # samples 600, 601 and 602 visit the accelerometer
    assert not (flags[3:] & AT_REST).any()


def test_rest_has_hysteresis():
    """A gyroscope that trembles between both limits is no rest, but does not end one."""
    between = (CONFIG["enter_gyro_counts"] + CONFIG["leave_gyro_counts"]) // 2
    tremble = np.zeros((600, 3), dtype=np.int16)
    tremble[::12] = between
    tremble[6::12] = -between
    # Every visit of every axis sees the one or the other, so that no low-pass moves far.
    tremble = np.repeat(tremble[::6], 6, axis=0)
    calm, acc = lying(600, bias=(0, 0, 0), noise=0.0)
    _, flags = Rest(CONFIG).block(tremble, acc)
    assert not (flags & AT_REST).any()
    rest = Rest(CONFIG)
    rest.block(calm, acc)
    _, flags = rest.block(tremble, acc)
    assert (flags & AT_REST).all()


def test_rest_does_not_take_a_slow_turn_for_a_bias():
    gyro, acc = lying(2000, bias=(0, CONFIG["bias_max_counts"] + 5, 0), noise=0.0)
    bias_q16, flags = Rest(CONFIG).block(gyro, acc)
    assert not flags.any()
    assert not bias_q16.any()


def test_rest_learns_nothing_of_a_dead_sensor():
    dead = np.zeros((2000, 3), dtype=np.int16)
    rest = Rest(CONFIG)
    _, flags = rest.block(dead, dead)
    assert not (flags & BIAS_KNOWN).any()
    assert rest.implausible > 10


@pytest.mark.parametrize("stuck", exact_imu.RAILS)
def test_rest_is_never_found_in_a_sensor_that_stands_on_a_rail(stuck):
    gyro, acc = lying(1200)
    gyro[:, 1] = stuck
    rest = Rest(CONFIG)
    _, flags = rest.block(gyro, acc)
    assert not flags.any()
    assert rest.rejected == 200


def test_rest_follows_a_bias_that_drifts_with_its_time_constant():
    """A step of the bias, at rest: after the time constant, 1/e of it is left. It is a power of two
    of blocks, the one that is nearest to the spec's."""
    config = design.config_at(RATE_HZ, enter_gyro_deg_s=4.0, leave_gyro_deg_s=4.0)
    gyro, acc = lying(6000, bias=(0, 0, 0), noise=0.0)
    rest = Rest(config)
    rest.block(gyro, acc)
    gyro[:, 2] = 20
    bias_q16, flags = rest.block(gyro, acc)
    assert flags.all()
    follows_s = config["gain_len"] * design.block_s(RATE_HZ)
    assert abs(np.log2(follows_s / design.spec()["times"]["bias_s"])) <= 0.5
    after = bias_q16[round(follows_s * RATE_HZ), 2] / 65536 / 20
    assert abs(after - (1 - np.exp(-1))) < 0.05


def test_rest_after_a_gap_begins_anew_and_keeps_the_bias():
    gyro, acc = lying(600)
    rest = Rest(CONFIG)
    rest.block(gyro, acc)
    bias_q16 = rest.bias_q16
    rest.interrupt()
    assert rest.update(gyro[0], acc[0]) == BIAS_KNOWN
    assert rest.bias_q16 == bias_q16


@given(config=lawful_configs(), cut=st.integers(0, 279), seed=st.integers(0, 9))
def test_rest_saved_restored_or_copied_continues_identically(config, cut, seed):
    gyro, acc = lying(280, noise=1.0, seed=seed)
    rest = Rest(config)
    rest.block(gyro[:cut], acc[:cut])
    copy, restored = rest.copy(), Rest(config)
    restored.restore(rest.save())
    expected = [each.tolist() for each in rest.block(gyro[cut:], acc[cut:])]
    for other in (copy, restored):
        assert [each.tolist() for each in other.block(gyro[cut:], acc[cut:])] == expected


def phases(seed):
    """A board that lies, is swung, lies otherwise, in physical units of whole counts."""
    rng = np.random.default_rng(seed)
    parts = []
    for length in (700, 130, 600, 50, 900):
        gyro, acc = lying(length, bias=rng.integers(-15, 15, 3), seed=rng.integers(1 << 30))
        if length < 200:
            swing = 1500 * np.sin(np.arange(length) * rng.uniform(0.1, 0.9))
            gyro = gyro + np.rint(np.outer(swing, (1, 0.5, -0.7))).astype(np.int16)
            acc = acc + np.rint(np.outer(swing, (-0.4, 0.5, 1))).astype(np.int16)
        parts.append((gyro, acc))
    return tuple(np.vstack(each) for each in zip(*parts, strict=True))


def changes(flags):
    """Samples at which rest begins or ends."""
    return np.flatnonzero(np.diff(np.asarray(flags, dtype=int)))


def both(gyro, acc):
    """The model's result, the C's flags of rest, |difference| of the bias in counts."""
    truth = model.rest(
        np.radians(gyro / GYRO), acc / ACC * model.STANDARD_GRAVITY_M_S2, rate_hz=RATE_HZ
    )
    bias_q16, flags = Rest(CONFIG).block(gyro, acc)
    error = np.abs(bias_q16 / 65536 - np.degrees(truth.bias_rad_s) * GYRO)
    return truth, (flags & AT_REST) != 0, error


@pytest.mark.parametrize("seed", range(12))
def test_rest_decides_as_the_model_but_for_two_rounds_where_a_low_pass_comes_back(seed):
    """A low-pass on its way back crosses its limit somewhere: there a count of rounding may decide
    a visit or two earlier or later, hence as many rounds. Blocks then hold other samples of the
    same mean."""
    truth, at_rest, error = both(*phases(seed))
    assert np.abs(changes(at_rest) - changes(truth.at_rest)).max() <= 12
    if at_rest.tolist() == truth.at_rest.tolist():
        assert error.max() <= np.degrees(truth.budget_rad_s) * GYRO
    assert error[-1].max() <= 0.1  # other samples of the same noise


@pytest.mark.parametrize("seed", range(4))
def test_rest_bias_of_a_resting_board_stays_within_the_budget(seed):
    truth, at_rest, error = both(*lying(4000, seed=seed))
    assert truth.margin > 2
    assert at_rest.tolist() == truth.at_rest.tolist()
    assert error.max() <= np.degrees(truth.budget_rad_s) * GYRO < 1e-3


def test_rest_model_rejects_what_is_no_number():
    gyro, acc = (each.astype(float) for each in lying(900))
    gyro, acc = np.radians(gyro / GYRO), acc / ACC * model.STANDARD_GRAVITY_M_S2
    calm = model.rest(gyro, acc, rate_hz=RATE_HZ)
    gyro[303, 0], acc[450, 0], acc[451, 1] = np.nan, np.inf, 1e9
    truth = model.rest(gyro, acc, rate_hz=RATE_HZ)
    assert calm.rejected == 0
    assert calm.at_rest[303]
    assert truth.rejected == 3
    assert not truth.at_rest[303]
    assert np.isfinite(truth.bias_rad_s).all()


def test_rest_refuses_what_breaks_the_contract():
    with pytest.raises(ValueError, match="no rate '50hz'"):
        Rest("50hz")
    for field, value in {
        "enter_gyro_counts": CONFIG["leave_gyro_counts"] + 1,
        "bias_max_counts": lib.REST_GYRO_LIMIT_MAX,
        "lowpass_q16": 0,
        "still_rounds": 0,
        "gain_len": 256,
        "leave_acc_counts": lib.REST_ACC_LIMIT_MAX + 1,
        "gravity2_max": 1 << 16,
    }.items():
        with pytest.raises(ValueError, match="rest"):
            Rest({**CONFIG, field: value})
    with pytest.raises(ValueError, match="no enter_m_s"):
        design.config_at(RATE_HZ, enter_m_s=1.0)
    with pytest.raises(ValueError, match="still_rounds"):
        design.config_at(2000.0)
    rest = Rest(CONFIG)
    with pytest.raises(ValueError, match="not the state"):
        rest.restore(b"")
    with pytest.raises(ValueError, match="shape"):
        rest.block([1, 2, 3], [1, 2, 3])
    with pytest.raises(ValueError, match="16 bits"):
        rest.block([[0, 0, 32768]], [[0, 0, 0]])
    with pytest.raises(TypeError, match="integers"):
        rest.block([[0.5, 0, 0]], [[0, 0, 0]])
    with pytest.raises(ValueError, match="2 gyroscope and 1"):
        rest.block([[0, 0, 0]] * 2, [[0, 0, 0]])
