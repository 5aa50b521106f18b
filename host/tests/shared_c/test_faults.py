# SPDX-License-Identifier: MIT
"""faults.c: golden vectors, laws for all inputs, and the noise it hears against the model."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from terazi.cshared import Fault, Faults, FaultsAnswer, FaultsEvent
from terazi.models import exact, exact_faults
from terazi.models import faults as model
from terazi.models.vectors import golden

LOW, HIGH = exact.COUNTS_MIN, exact.COUNTS_MAX
PAUSE = 255
LOAD, SIGMA = 429_550, 38.7  # 1 kg; HX711, 80 SPS
SPOILT, RESTART, CHANGED = FaultsAnswer.SPOILT, FaultsAnswer.RESTART, FaultsAnswer.CHANGED
CONVERSION = FaultsEvent.CONVERSION
TAKEN = {  # conversions until a fault that ends a run is named
    FaultsEvent.BAD_FRAME: Fault.FRAMES_LOST,
    FaultsEvent.TIMED_OUT: Fault.CABLE_OUT,
    FaultsEvent.STUCK_LOW: Fault.DOUT_STUCK,
    FaultsEvent.OFF_BEAT: Fault.FRAMES_LOST,
    FaultsEvent.DROPPED: Fault.FRAMES_LOST,
}

counts_24 = st.one_of(
    st.integers(LOW, HIGH),
    st.integers(LOAD - 60, LOAD + 60),
    st.sampled_from([LOW, HIGH, LOW + 1, HIGH - 1, 0, -1, LOAD, LOAD + 1024, LOAD + 60_000]),
)
rows = st.lists(
    st.one_of(
        st.tuples(st.just(int(CONVERSION)), counts_24),
        st.tuples(st.sampled_from([*map(int, FaultsEvent), PAUSE]), counts_24),
    ),
    max_size=120,
)
noise_counts = st.sampled_from([0, 399, 400, 420, 4000, 65_535])


def rng(seed=3):
    return np.random.default_rng(seed)


def noisy(count, load=LOAD, sigma=SIGMA, seed=3):
    return np.round(rng(seed).normal(load, sigma, count)).astype(int).tolist()


def play(faults, story):
    """What is answered to each row, and what is held after it."""
    told = []
    for event, counts in story:
        answer = 0
        if event == PAUSE:
            faults.pause()
        else:
            answer = faults.update(event, counts)
        told.append((int(answer), int(faults.held)))
    return told


def at_work(**how):
    """One that has seen a converter at work."""
    faults = Faults(**how)
    assert play(faults, [(CONVERSION, value) for value in noisy(40)]) == [(0, 0)] * 40
    return faults


@pytest.mark.parametrize("vector", golden("faults_"), ids=str)
def test_faults_reproduces_vector_bit_for_bit(vector):
    faults = Faults(vector.parameter("noise_counts"))
    told = play(faults, zip(vector["event"], vector["counts"], strict=True))
    assert told == list(zip(vector["answer"], vector["held"], strict=True))
    assert faults.seen == vector.parameter("final_seen")


@given(story=rows, limit=noise_counts)
def test_faults_is_its_exact_twin_for_any_events(story, limit):
    faults, twin = Faults(limit), exact_faults.Faults()
    twin.limit_noise(limit)
    assert play(faults, story) == play(twin, story)
    assert (faults.seen, faults.noisy) == (twin.seen, twin.noisy)


@given(before=rows, after=rows)
def test_faults_saved_restored_or_copied_continues_identically(before, after):
    faults = Faults()
    play(faults, before)
    kept, twin = faults.save(), faults.copy()
    told = play(faults, after)
    assert play(twin, after) == told
    other = Faults()
    other.restore(kept)
    assert play(other, after) == told


def test_faults_refuses_a_state_that_is_none():
    with pytest.raises(ValueError, match="state"):
        Faults().restore(b"\0")


@given(story=rows)
def test_faults_answers_what_it_holds_and_restarts_once_where_trust_comes_back(story):
    faults, before = Faults(), Fault(0)
    for event, counts in story:
        if event == PAUSE:
            continue
        answer = faults.update(event, counts)
        assert bool(answer & SPOILT) == bool(faults.held)
        assert bool(answer & CHANGED) == (faults.held != before)
        assert bool(answer & RESTART) == (bool(before) and not faults.held)
        assert not answer & RESTART or event == CONVERSION, "a sample to start the filters with"
        assert faults.held & ~faults.seen == 0
        before = faults.held


@pytest.mark.parametrize(("event", "named"), TAKEN.items(), ids=lambda value: value.name)
def test_faults_names_what_ends_a_run_at_once_and_forgets_it_after_three(event, named):
    faults = at_work()
    assert faults.update(event) == CHANGED | SPOILT
    assert faults.held == named
    settling = [(FaultsEvent.DROPPED, 0)] * 4
    assert play(faults, settling) == [(SPOILT, named)] * 4
    good = [(CONVERSION, value) for value in noisy(4)]
    assert play(faults, good) == [(SPOILT, named)] * 2 + [(CHANGED | RESTART, 0), (0, 0)]
    assert faults.seen == named


def test_faults_names_a_rate_where_the_second_conversion_in_a_row_is_off():
    faults = at_work()
    faults.update(FaultsEvent.OFF_BEAT)
    assert faults.held == Fault.FRAMES_LOST
    faults.update(FaultsEvent.OFF_BEAT)
    assert faults.held == Fault.FRAMES_LOST | Fault.RATE


def test_faults_takes_conversions_that_settle_from_the_start_or_after_a_pause_for_no_fault():
    faults = Faults()
    story = [(FaultsEvent.DROPPED, 1 << 22)] * 4 + [(CONVERSION, value) for value in noisy(9)]
    story += [(PAUSE, 0), *story]
    assert play(faults, story) == [(0, 0)] * len(story)


@pytest.mark.parametrize("rail", [LOW, HIGH])
def test_faults_names_a_rail_at_once_and_not_what_is_beside_it(rail):
    faults = at_work()
    inside = rail - 1 if rail > 0 else rail + 1
    faults.update(CONVERSION, rail)
    assert faults.held == Fault.AT_RAIL
    for value in (inside, inside - np.sign(rail), inside):
        faults.update(CONVERSION, int(value))
    assert faults.held == Fault(0)


@pytest.mark.parametrize("value", [0, -1, LOAD])
def test_faults_names_a_converter_that_stands_still_with_the_sixth_equal_count(value):
    faults = at_work()
    held = [told[1] for told in play(faults, [(CONVERSION, value)] * 9)]
    assert [bit & Fault.DOUT_STUCK for bit in held] == [0] * 5 + [Fault.DOUT_STUCK] * 4
    play(faults, [(CONVERSION, count) for count in noisy(12, seed=9)])
    assert faults.held == Fault(0)


@pytest.mark.parametrize("sigma", [15.0, 21.5, 38.7, 150.0])
def test_faults_holds_nothing_against_a_converter_at_work(sigma):
    faults = Faults()
    told = play(faults, [(CONVERSION, value) for value in noisy(20_000, sigma=sigma)])
    assert set(told) == {(0, 0)}
    assert model.repeat_chance(sigma, 5) * 20_000 < 1e-3


def test_the_chance_of_repeats_is_what_is_counted():
    """Where it is large enough to be counted."""
    values = np.round(rng().normal(0, 3.0, 400_000))
    equal = np.diff(values) == 0
    thrice = equal[:-2] & equal[1:-1] & equal[2:]
    assert thrice.mean() == pytest.approx(model.repeat_chance(3.0, 3), rel=0.1)


@pytest.mark.parametrize("width", [1, 2])
@pytest.mark.parametrize("height", [2400, -2400, 6000, 60_000, (1 << 22) - 1])
def test_faults_names_a_spike_where_it_ends(width, height):
    faults = at_work()
    story = [(CONVERSION, value) for value in noisy(width, LOAD + height, 4.0)]
    assert [bit for _, bit in play(faults, story)] == [0] * width
    faults.update(CONVERSION, LOAD)
    assert faults.held == Fault.NOISE
    play(faults, [(CONVERSION, value) for value in noisy(14)])
    assert faults.held == Fault(0)


@pytest.mark.parametrize("step", [500, -1100, 40_000, 2_000_000, -4_000_000])
def test_faults_takes_a_load_step_for_what_it_is(step):
    faults = at_work()
    story = [(CONVERSION, value) for value in noisy(40, LOAD + step)]
    assert set(play(faults, story)) == {(0, 0)}


@pytest.mark.parametrize("swing_hz", [0.5, 2.0, 5.0, 10.0, 16.0, 20.0])
def test_faults_takes_a_load_that_swings_by_100_g_for_what_it_is(swing_hz):
    at_s = np.arange(800) / 80.0
    for phase in np.linspace(0, np.pi, 7):
        swing = 43_000 * np.sin(2 * np.pi * swing_hz * at_s + phase) * np.minimum(at_s, 1.0)
        story = [(CONVERSION, round(value)) for value in noisy(800) + swing]
        assert {held for _, held in play(Faults(), story)} == {0}


@pytest.mark.parametrize("ringing_hz", [5.0, 8.0, 12.0, 16.0, 20.0])
def test_faults_takes_a_product_that_rings_by_a_tenth_for_what_it_is(ringing_hz):
    at_s = np.arange(-40, 60) / 80.0
    for phase in np.linspace(0, np.pi, 7):
        ringing = np.exp(-at_s / 0.15) * np.cos(2 * np.pi * ringing_hz * at_s + phase)
        product = np.where(at_s < 0, 0.0, LOAD * (1 + 0.1 * ringing))
        story = [(CONVERSION, round(value)) for value in noisy(100, 0) + product]
        assert {held for _, held in play(Faults(), story)} == {0}


def test_faults_takes_a_hand_that_presses_by_a_kilogram_for_what_it_is():
    at_s = np.arange(800) / 80.0
    hand = LOAD * (1 - np.cos(2 * np.pi * 3.0 * at_s)) / 2 * (at_s % 2 < 1)
    story = [(CONVERSION, round(value)) for value in noisy(800) + hand]
    assert {held for _, held in play(Faults(), story)} == {0}


@pytest.mark.parametrize(("times", "late_share"), [(8, 0.1), (20, 0.01), (100, 0.0)])
def test_faults_names_noise_within_eleven_conversions(times, late_share):
    """150 ms at 78 SPS; 13 more would be 150 ms at 92."""
    late = []
    for seed in range(400):
        faults = at_work()
        burst = np.clip(noisy(11, sigma=4000 * times, seed=seed), LOW + 1, HIGH - 1)
        play(faults, [(CONVERSION, int(value)) for value in burst])
        late.append(not faults.seen & Fault.NOISE)
    assert np.mean(late) <= late_share


def test_faults_forgets_noise_within_ten_conversions_of_its_end():
    for seed in range(100):
        faults = at_work()
        play(faults, [(CONVERSION, value) for value in noisy(40, sigma=60_000, seed=seed)])
        assert faults.seen & Fault.NOISE
        play(faults, [(CONVERSION, value) for value in noisy(10, seed=seed)])
        assert faults.held == Fault(0)


def surely(values, threshold, doubt):
    """True above, False below, None where rounding may tell otherwise."""
    return None if abs(values - threshold) <= doubt else bool(values > threshold)


@given(
    loads=st.lists(st.integers(-250_000, 250_000), min_size=1, max_size=40),
    limit=st.sampled_from([1600, 4000, 16_000]),
)
def test_faults_hears_what_the_model_hears(loads, limit):
    """As long as no conversion is so near to a limit that rounding might decide."""
    faults, score = Faults(limit), 0
    rests = np.abs(model.rest(loads))
    moves = np.abs(np.diff(loads, prepend=loads[0]))
    for at, counts in enumerate(loads):
        faults.update(CONVERSION, counts)
        recent = moves[max(0, at - 5) : at + 1]
        large = [surely(move, model.STIR_COUNTS, model.MOVE_COUNTS) for move in recent]
        beyond = surely(rests[at], 14 * limit, model.BUDGET_COUNTS + 256)
        if None in (*large, beyond) or faults.held or recent.max() > model.MOVE_MOST_COUNTS:
            return
        score = max(score + (1 if beyond and sum(large) >= 3 else -1), 0)
        assert faults.noisy == score


def test_the_model_s_filter_passes_what_its_gain_says():
    at = np.arange(400)
    for frequency in (0.05, 0.2, 0.25, 0.4, 0.5):
        left = model.rest(np.cos(2 * np.pi * frequency * at))[20:]
        assert np.abs(left).max() == pytest.approx(model.passes(frequency), abs=0.02)
    assert pytest.approx(14.0) == model.NOISE_PASSES
    assert model.rest(rng().normal(0, 100.0, 100_000)).std() == pytest.approx(1400, rel=0.02)
    assert model.rest([]).size == 0
