# SPDX-License-Identifier: MIT
"""zupt_gru.c: golden vectors, laws for all inputs, and parity with the network in floats."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from terazi.applications.walks import networks, simulator
from terazi.cshared import ZuptGru
from terazi.cshared._cshared import ffi, lib
from terazi.design import zupt as sensors
from terazi.design import zupt_gru as design
from terazi.models import exact_zupt_gru
from terazi.models import zupt_gru as model
from terazi.models.vectors import golden
from tools.gen.zupt_gru_weights import floats, gate, weights

GYRO = sensors.counts_per_unit("are", sensors.spec()["sensor"])
ACC = sensors.counts_per_unit("magnitude", sensors.spec()["sensor"])
TEN = exact_zupt_gru.TEN
edge = st.sampled_from((-32768, -32767, -8193, -8192, -1, 0, 1, 2048, 8191, 8192, 32766, 32767))
sized = st.integers(0, 13).flatmap(lambda bits: st.integers(-(1 << bits), 1 << bits))
value = st.one_of(edge, sized, st.integers(-32768, 32767))
vectors = st.tuples(value, value, value)
small = st.integers(-40, 40)
lying_acc = st.tuples(small, small, st.integers(2000, 2100))
rates = st.sampled_from((1, 2))


def lying(count, *, noise=2.0, seed=1):
    """(gyro, acc) of a foot at rest, (count, 3) int16 each."""
    rng = np.random.default_rng(seed)
    gyro = np.rint(rng.normal((4, -3, 2), noise, (count, 3)))
    acc = np.rint(rng.normal((300, -200, 2016), 2 * noise, (count, 3)))
    return gyro.astype(np.int16), acc.astype(np.int16)


def shaken(count, seed=2):
    """A foot that swings: large rates and accelerations."""
    rng = np.random.default_rng(seed)
    gyro, acc = rng.normal(0, 3000, (count, 3)), rng.normal((0, 0, 2048), 1200, (count, 3))
    return tuple(np.rint(each).clip(-8192, 8191).astype(np.int16) for each in (gyro, acc))


def walked(seed, sample_ms):
    """(gyro, acc) in counts of a simulated walk at the device's rate."""
    pieces = [*simulator.stand(1.0), *simulator.strides(6), *simulator.staircase(4)]
    walk = simulator.simulate(pieces, seed=seed, rate_hz=1000.0 / sample_ms)
    values = walk.gyro_b_rad_s * GYRO, walk.acc_b_m_s2 * ACC
    return tuple(np.rint(each).clip(-32768, 32767).astype(np.int16) for each in values)


def physical(gyro, acc):
    return gyro / GYRO, acc / ACC


def columns(vector, sensor):
    return np.column_stack([vector[f"{sensor}_{axis}_counts"] for axis in "xyz"])


@pytest.mark.parametrize("vector", golden("zupt_gru_"), ids=str)
def test_zupt_gru_reproduces_vector_bit_for_bit(vector):
    gru, gap = ZuptGru(vector.parameter("sample_ms")), vector.parameter("gap")
    names = [*(f"input_{n}" for n in range(2)), *(f"state_{n}" for n in range(8))]
    seen = list(zip(*(vector[name] for name in names), strict=True))
    samples = zip(columns(vector, "gyro"), columns(vector, "acc"), strict=True)
    for at, (gyro, acc) in enumerate(samples):
        if gap and at == gap:
            gru.interrupt()
        assert gru.update(gyro, acc) == bool(vector["still"][at])
        assert gru.seen == list(seen[at])
    assert gru.rejected == vector.parameter("rejected")


def test_zupt_gru_vectors_hold_both_rates_both_answers_gaps_and_rails():
    found = golden("zupt_gru_")
    for sample_ms in (1, 2):
        of = [vector for vector in found if vector.parameter("sample_ms") == sample_ms]
        assert {flag for vector in of for flag in vector["still"]} == {0, 1}
        assert max(max(vector["input_0"]) for vector in of) == TEN
    assert max(vector.parameter("rejected") for vector in found) > 0
    assert sum(vector.parameter("gap") > 0 for vector in found) == 2


@settings(max_examples=60)
@given(
    sample_ms=rates,
    lead=st.integers(0, 60),
    samples=st.lists(
        st.one_of(
            st.tuples(st.tuples(small, small, small), lying_acc), st.tuples(vectors, vectors)
        ),
        max_size=80,
    ),
    gap=st.integers(0, 140),
)
def test_zupt_gru_is_its_exact_twin_on_any_samples(sample_ms, lead, samples, gap):
    gru, twin = ZuptGru(sample_ms), exact_zupt_gru.ZuptGru(weights(), sample_ms)
    for at, (gyro, acc) in enumerate([((0, 0, 0), (0, 0, 2048))] * lead + samples):
        if at == gap:
            gru.interrupt()
            twin.interrupt()
        assert gru.update(gyro, acc) == bool(twin.update(gyro, acc))
        assert gru.seen == twin.seen
        assert gru.best == twin.best
    assert gru.rejected == twin.rejected


def stepped(states, gyro, acc):
    """Inputs of a step from any states, and what the C and the twin make of them."""
    gru = ZuptGru(1)
    gru._c.seen[2:10] = states
    gru.update(gyro, acc)
    seen = gru.seen
    assert seen[2:] == list(states)
    gru.update(gyro, acc)
    wanted = [
        exact_zupt_gru.next_state(unit, weights().sigmoid_q16, seen, state)
        for unit, state in zip(weights().units, states, strict=True)
    ]
    return seen[:2], gru.seen[2:], wanted


@given(
    states=st.lists(
        st.one_of(st.sampled_from((-8192, 8192)), st.integers(-8192, 8192)), min_size=8, max_size=8
    ),
    gyro=vectors,
    acc=vectors,
)
def test_zupt_gru_units_hold_every_state_and_input_there_can_be(states, gyro, acc):
    """Beyond what a walk leads to: the bound that the weights are made for."""
    _, found, wanted = stepped(states, gyro, acc)
    assert found == wanted
    assert all(-8192 <= state <= 8192 for state in found)


def test_zupt_gru_holds_the_worst_corner_of_each_gate():
    """Sums in unbounded integers against what 16 bits hold, and the C with the same (UBSan)."""
    nothing, most = ((0, 0, 0), (0, 0, 2048)), ((8191, 8191, 8191), (8191, 8191, 8191))
    largest = 0
    for unit in weights().units:
        by_gate = zip(zip(*unit.inputs, strict=True), zip(*unit.states, strict=True), strict=True)
        for which, (inputs, states) in enumerate(by_gate):
            for sign in (-1, 1):
                seen = [TEN * (w * sign > 0) for w in inputs]
                corner = [8192 * sign * ((w > 0) - (w < 0)) for w in states]
                if which == 2:
                    total = abs(exact_zupt_gru.total(unit.bias[2], inputs, seen))
                    total += abs(exact_zupt_gru.total(unit.bias_u, states, corner))
                else:
                    total = exact_zupt_gru.total(unit.bias[which], inputs + states, seen + corner)
                largest = max(largest, abs(total))
                gyro, acc = (most[1] if seen[1] else nothing[0]), (most if seen[0] else nothing)[1]
                taken, found, wanted = stepped(corner, gyro, acc)
                assert taken == seen
                assert found == wanted
    assert 8192 < largest // 2 < 1 << 14  # beyond the sigmoid's table, and within 16 bits


@pytest.mark.parametrize("sample_ms", [1, 2])
def test_zupt_gru_takes_the_newest_sample_at_each_step(sample_ms):
    """Each sample has a size of its own: which of them were seen is seen in the input."""
    acc = np.zeros((40, 3), np.int16)
    acc[:, 2] = 2060 + 40 * np.arange(40)
    gru, taken, before = ZuptGru(sample_ms), [], 0
    for at in range(40):
        gru.update((0, 0, 0), acc[at])
        if gru.seen[0] != before:
            taken.append(at)
        before = gru.seen[0]
    times = np.arange(0, 40 * sample_ms, 5) // sample_ms
    assert taken == times[times < 40].tolist()
    if sample_ms == 2:
        assert taken[:5] == [0, 2, 5, 7, 10]


@pytest.mark.parametrize("sample_ms", [1, 2])
def test_zupt_gru_tells_stillness_with_the_sample_after_a_step(sample_ms):
    gyro, acc = walked(5, sample_ms)
    gru, changes = ZuptGru(sample_ms), []
    still = gru.block(gyro, acc)
    changes = np.flatnonzero(np.diff(still.astype(int))) + 1
    steps = np.arange(0, len(still) * sample_ms, 5) // sample_ms
    assert len(changes) > 6
    assert set(changes) <= set((steps + 1).tolist())


@pytest.mark.parametrize("sample_ms", [1, 2])
def test_zupt_gru_decides_as_the_network_on_whole_counts(sample_ms):
    """The budget of the notes. Decisions differ only where the network is that near its limit."""
    gyro, acc = walked(11, sample_ms)
    at, scores, asked = model.zupt_gru(
        *physical(gyro, acc), network=floats(), gate=gate(), sample_ms=sample_ms
    )
    gru, flags, seen = ZuptGru(sample_ms), [], []
    for pair in zip(gyro, acc, strict=True):
        flags.append(gru.update(*pair))
        seen.append(gru.seen[2:])
    told = at + 1 < len(flags)
    flags, states = np.array(flags)[at[told] + 1], np.array(seen)[at[told] + 1] / 8192
    inputs = model.zupt_gru_inputs(*(each[at] for each in physical(gyro, acc)), floats())
    error = states - design.states(floats(), inputs)[told]
    assert np.sqrt(np.mean(error**2)) < 0.005
    bias = weights().out_bias - 4  # half a sum for each product that is rounded down
    score = states @ np.array(weights().out) / 51.2 + bias / 51.2 / 32
    apart = score - scores[told]
    assert np.sqrt(np.mean(apart**2)) < 0.025
    assert np.abs(apart).max() < 0.1
    differ = flags != (scores >= asked)[told]
    assert np.abs((scores - asked)[told][differ]).max(initial=0) < 0.15
    assert differ.mean() <= 0.005


@pytest.mark.parametrize("sample_ms", [1, 2])
def test_zupt_gru_asks_less_where_nothing_near_comes_up_to_accept(sample_ms):
    """A foot that never stands as still as those that were learnt from: shaken in every stance."""
    gyro, acc = walked(5, sample_ms)
    rng = np.random.default_rng(8)
    gyro = (gyro + rng.normal(0, 350, gyro.shape)).clip(-32768, 32767).astype(np.int16)
    _at, scores, asked = model.zupt_gru(
        *physical(gyro, acc), network=floats(), gate=gate(), sample_ms=sample_ms
    )
    still = ZuptGru(sample_ms).block(gyro, acc)
    assert np.mean(scores >= 0) < 0.02
    assert 0.1 < np.mean(still) < 0.6
    assert asked.min() >= gate().least
    assert asked.max() <= 0.0


@given(scores=st.lists(st.floats(-9, 9), min_size=1, max_size=400))
def test_zupt_gru_asks_for_a_margin_below_the_best_of_the_newest_blocks(scores):
    """Block by block, against the definition."""
    scores, by = np.array(scores), gate()
    found = design.asked(scores, by)
    for at in range(len(scores)):
        first = max(0, (at // 64 - 2) * 64)
        newest = list(scores[first : at + 1]) + [0.0] * (at < 3 * 64)
        if at < 64:  # the newest block begins with what accept asks for
            assert found[at] == np.clip(max(newest) - by.margin, by.least, 0.0)
        else:
            assert by.least <= found[at] <= 0.0
            if max(newest) > by.margin:
                assert found[at] == 0.0


def test_zupt_gru_logarithm_is_within_the_notes_for_every_number():
    numbers = np.arange(1, 65536)
    found = np.array([exact_zupt_gru.log2_q8(int(each)) for each in numbers])
    assert np.abs(found / 256 - np.log2(numbers)).max() <= 0.02


@given(sum_=st.integers(-(1 << 15) + 1, (1 << 15) - 1))
def test_zupt_gru_sigmoid_is_within_the_notes_and_odd_about_a_half(sum_):
    table = weights().sigmoid_q16
    found = exact_zupt_gru.sigmoid(table, sum_)
    units_per_one = 51.2 * 8192 / 256 / 2
    assert abs(found / 65536 - design.sigmoid(sum_ / units_per_one)) < 0.0008
    assert found + exact_zupt_gru.sigmoid(table, -sum_) == 65536
    assert 0 < found < 65536


@given(gyro=vectors, acc=vectors, sample_ms=rates)
def test_zupt_gru_magnitudes_are_those_of_the_network(gyro, acc, sample_ms):
    """Within a half count of the root and the logarithm's error, where nothing is beyond."""
    gru = ZuptGru(sample_ms)
    gru.update(gyro, acc)
    pair = np.array([gyro], float), np.array([acc], float)
    wanted = model.zupt_gru_inputs(*physical(*pair), floats())[0] * 10
    starts = (9.81 * ACC * 2, 0.0)
    for n, (vector, floor) in enumerate(((acc, 0.02 * ACC), (gyro, 0.01 * GYRO))):
        found = gru.seen[n] / 1024
        if any(abs(each + 0.5) > 8192 for each in vector):
            assert found == 10
            continue
        halves = abs(2 * float(np.linalg.norm(vector)) - starts[n])
        slack = np.log2((halves + 1.5) / max(halves - 1.5, 2 * floor)) if halves > 1.5 else 1.0
        assert abs(found - wanted[n]) <= max(slack, 0) + 0.02


def test_zupt_gru_is_still_at_rest_and_not_in_motion():
    for sample_ms in (1, 2):
        gru = ZuptGru(sample_ms)
        assert not gru.still
        assert gru.block(*lying(600 // sample_ms))[-1]
        assert not gru.block(*shaken(200 // sample_ms))[-1]
        assert gru.block(*lying(600 // sample_ms))[-1]


@pytest.mark.parametrize("sensor", ["gyro", "acc"])
def test_zupt_gru_takes_a_value_beyond_for_motion_in_its_step_and_counts_those_on_a_rail(sensor):
    for value, counted in ((8191, 0), (8192, 0), (-8193, 0), (32767, 1), (-32768, 1)):
        gru = ZuptGru(1)
        gyro, acc = lying(601)
        assert gru.block(gyro[:600], acc[:600])[-1]
        pair = {"gyro": gyro[600], "acc": acc[600]}
        pair[sensor] = np.array((0, value, 2048), dtype=np.int16)
        gru.update(pair["gyro"], pair["acc"])
        assert gru.still  # of the step before
        gru.update(gyro[0], acc[0])
        if value != 8191 or sensor == "acc":  # 500 deg/s are 9.8 octaves: the network's to say
            assert not gru.still
        assert gru.rejected == counted
        assert (gru.seen[0] if sensor == "acc" else gru.seen[1]) >= 0.95 * TEN


def test_zupt_gru_with_a_dead_sensor_is_never_still():
    gyro, acc = lying(1000)
    for rail in (-32768, 32767):
        dead = np.full_like(acc, rail)
        assert not ZuptGru(1).block(gyro, dead).any()
        assert not ZuptGru(1).block(dead, acc).any()
    gru = ZuptGru(1)
    gru.block(np.full_like(gyro, 32767), np.full_like(acc, 32767))
    assert gru.rejected == 2 * 200  # both vectors of each step


def test_zupt_gru_counts_rejected_vectors_to_the_top_and_keeps_them_over_a_choice():
    gru = ZuptGru(1)
    gru._c.rejected = 65534
    dead = np.full((20, 3), 32767, np.int16)
    gru.block(dead, dead)
    assert gru.rejected == 65535
    lib.zupt_gru_init(gru._c, 2)
    assert gru.rejected == 65535
    assert not gru.still


@pytest.mark.parametrize("cut", range(5))
def test_zupt_gru_after_a_gap_begins_anew(cut):
    gyro, acc = lying(400)
    gru = ZuptGru(1)
    assert gru.block(gyro, acc)[-1]
    gru.block(gyro[:cut], acc[:cut])
    gru.interrupt()
    assert not gru.still
    assert gru.seen == [0] * 10
    assert gru.best == [0] * 3
    assert gru.block(gyro, acc).tolist() == ZuptGru(1).block(gyro, acc).tolist()


@given(sample_ms=rates, cut=st.integers(0, 120), seed=st.integers(0, 9))
def test_zupt_gru_saved_restored_or_copied_continues_identically(sample_ms, cut, seed):
    gyro, acc = shaken(160, seed)
    acc[40:100], gyro[40:100] = lying(60)[1], lying(60)[0]
    gru = ZuptGru(sample_ms)
    gru.block(gyro[:cut], acc[:cut])
    copy, restored = gru.copy(), ZuptGru(3 - sample_ms)
    restored.restore(gru.save())
    expected = gru.block(gyro[cut:], acc[cut:]).tolist()
    for other in (copy, restored):
        assert other.block(gyro[cut:], acc[cut:]).tolist() == expected
        assert other.seen == gru.seen


def test_zupt_gru_refuses_what_breaks_the_contract():
    for sample_ms in (0, 3, 5):
        with pytest.raises(ValueError, match="there are 1 and 2"):
            ZuptGru(sample_ms)
    gru = ZuptGru(1)
    with pytest.raises(ValueError, match="not the state"):
        gru.restore(b"")
    with pytest.raises(ValueError, match="2 gyroscope and 1"):
        gru.block([[0, 0, 0]] * 2, [[0, 0, 0]])
    assert ffi.sizeof("zupt_gru_t") <= 40  # 38 without padding, as the chip has it


def test_zupt_gru_model_is_the_network_that_the_walks_have():
    walk = simulator.simulate([*simulator.stand(1.0), *simulator.strides(4)], seed=6)
    network = networks.load_network(networks.SHIPPED)
    shares = network.probability(walk)
    inputs = model.zupt_gru_inputs(walk.gyro_b_rad_s, walk.acc_b_m_s2, floats())
    np.testing.assert_allclose(inputs, networks.features(walk, "magnitudes", 200.0), atol=1e-6)
    states = design.states(floats(), inputs)
    logits = states @ floats().w_out + floats().b_out
    np.testing.assert_allclose(design.sigmoid(logits), shares, atol=2e-5)
    five = [np.repeat(each, 5, axis=0) for each in (walk.gyro_b_rad_s, walk.acc_b_m_s2)]
    at, found, asked = model.zupt_gru(*five, network=floats(), gate=gate(), sample_ms=1)
    assert at.tolist() == list(range(0, len(five[0]), 5))
    np.testing.assert_allclose(found, logits - design.logit(network.accept), atol=1e-9)
    np.testing.assert_array_equal(asked, design.asked(found, gate()))
