# SPDX-License-Identifier: MIT
"""scale.c: what makes a scale one that can be trusted, each a law of weighing."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from host.tests.shared_c.scales import (
    COUNTS_PER_G,
    E_MG,
    PERIOD_US,
    Q7,
    counts_q7_of,
    lying,
    times_us,
    weigh,
)
from terazi.cshared import Fir, Scale, ScaleFlag, ScaleRefusedError, ScaleShow, ScaleStatus
from terazi.design import scale as design
from terazi.models import scale as model

STABLE, STEPPED = ScaleFlag.STABLE, ScaleFlag.STEPPED
USUAL = design.config()
BAND_MG, STABLE_US = USUAL["stable_band_mg"], USUAL["stable_us"]
CONVERTER_NOISE_COUNTS = 38.7  # HX711 datasheet: 90 nV rms at 80 SPS


def refusal(function, *arguments) -> ScaleStatus:
    with pytest.raises(ScaleRefusedError) as refused:
        function(*arguments)
    return refused.value.status


def class_iii_mpe_e(load_e: float) -> float:
    """Greatest permitted error of class III in e: 0.5 to 500 e, 1 to 2000 e, 1.5 to 10 000 e."""
    return 0.5 if load_e <= 500 else 1.0 if load_e <= 2000 else 1.5


def bowed_counts(mass_g, bow=2e-4, max_g=5000.0):
    """A cell whose counts bow by so much of Max above the straight line between zero and Max."""
    share = np.asarray(mass_g) / max_g
    return COUNTS_PER_G * max_g * (share + 4 * bow * share * (1 - share))


def calibrated_errors_e(points: int) -> tuple[np.ndarray, np.ndarray]:
    """Loads and errors in e of a scale calibrated with as many points, before rounding to d."""
    masses = np.linspace(0, 5000, points)
    scale = Scale(design.config(list(zip(bowed_counts(masses), masses, strict=True))))
    loads_g = np.linspace(0, 5000, 501)
    counts = np.rint(bowed_counts(loads_g) * Q7).astype(int)
    _, net_mg, _ = scale.block(counts, times_us(len(counts)))
    return loads_g, (net_mg - loads_g * 1000) / E_MG


def test_two_points_keep_a_bowed_cell_within_class_iii_and_five_leave_a_fifth_of_the_error():
    loads_e, two = calibrated_errors_e(2)  # e is 1 g
    assert np.abs(two).max() == pytest.approx(1.0, abs=0.01)  # 0.02 % of 5000 e
    assert all(
        abs(error) <= class_iii_mpe_e(load) for load, error in zip(loads_e, two, strict=True)
    )
    _, five = calibrated_errors_e(5)
    assert np.abs(five).max() <= np.abs(two).max() / 5
    _, eight = calibrated_errors_e(8)
    assert np.abs(eight).max() < np.abs(five).max()


@pytest.mark.parametrize("rate_sps", [10.8, 80.0, 92.0])
def test_scale_is_stable_its_time_after_a_step_at_any_rate(rate_sps):
    period_us = round(1e6 / rate_sps)
    scale = Scale()
    grams = np.concatenate([lying(0.0), lying(1000.0)])
    flags, *_ = scale.block(counts_q7_of(grams), times_us(120, period_us))
    assert flags[59] & STABLE
    late = np.flatnonzero(flags[60:] & STABLE)[0] * period_us
    assert STABLE_US <= late < STABLE_US + period_us


def test_scale_is_stable_within_a_second_after_a_step_through_the_fir_in_the_converters_noise():
    rng = np.random.default_rng(5)
    for step_g in (5.0, 500.0, 4900.0):
        grams = np.concatenate([lying(0.0, 120), lying(step_g, 160)])
        noise = rng.normal(0, CONVERTER_NOISE_COUNTS, len(grams))
        raw = np.rint(grams * COUNTS_PER_G + noise).astype(int)
        fir, scale = Fir("lowpass32", raw[0]), Scale()
        filtered = np.array([fir.update(each) for each in raw.tolist()]) * Q7
        flags, *_ = scale.block(filtered, times_us(len(raw)))
        assert flags[119] & STABLE
        lies_g = filtered / Q7 / COUNTS_PER_G
        moving = (np.abs(lies_g) > 1) & (np.abs(lies_g - step_g) > 1)
        assert moving.any()
        assert not (flags[moving] & STABLE).any()
        assert np.flatnonzero(flags[130:] & STABLE)[0] + 10 <= 80  # samples at 80 SPS
        assert scale.steps == 1


@given(
    seed=st.integers(0, 1 << 16),
    rate_e_s=st.floats(-20, 20),
    swing_e=st.floats(0, 3),
    noise_e=st.floats(0, 0.3),
)
def test_scale_never_stays_stable_while_the_load_moves_by_more_than_e(
    seed, rate_e_s, swing_e, noise_e
):
    """All masses from stable_us before the flag rose to where it fell lie within the band."""
    rng = np.random.default_rng(seed)
    t_s = np.arange(400) * PERIOD_US * 1e-6
    grams = 700 + rate_e_s * t_s + swing_e * np.sin(t_s * rng.uniform(0.1, 9))
    grams += noise_e * rng.standard_normal(len(t_s))
    config = design.config(options=[])
    flags, net_mg, _ = weigh(Scale(config), grams)
    stable = (flags & STABLE) != 0
    before = STABLE_US // PERIOD_US
    for rose in np.flatnonzero(stable & ~np.roll(stable, 1)):
        fell = rose + np.argmin(np.append(stable[rose:], False))
        assert np.ptp(net_mg[rose - before : rose + 1]) <= BAND_MG
        assert np.ptp(net_mg[rose - before : fell]) <= BAND_MG * 3 // 2 < E_MG


@pytest.mark.parametrize("rate_e_s", [1.1, -1.1, 3.0, 100.0])
def test_scale_is_never_stable_while_more_than_e_a_second_comes_or_goes(rate_e_s):
    grams = 900 + rate_e_s * np.arange(400) * PERIOD_US * 1e-6
    flags, *_ = weigh(Scale(), grams)
    assert not (flags & STABLE).any()


def test_scale_is_not_stable_across_a_gap_and_the_clock_may_wrap():
    scale = Scale()
    flags, *_ = weigh(scale, lying(0.0), start_us=(1 << 32) - 300_000)
    assert np.flatnonzero(flags & STABLE)[0] == STABLE_US // PERIOD_US
    flags, *_ = weigh(scale, lying(0.0), start_us=scale.last_us + 237_500)
    assert flags[0] & STABLE
    flags, *_ = weigh(scale, lying(0.0), start_us=scale.last_us + 250_000)
    assert not flags[0] & STABLE
    assert flags[-1] & STABLE
    scale.interrupt()
    assert not scale.flags & STABLE
    assert not scale.update(0, scale.last_us + PERIOD_US) & STABLE


@pytest.mark.parametrize(("lies_g", "zeroed"), [(499.9, True), (-499.9, True), (501.0, False)])
def test_scale_sets_its_first_zero_within_a_tenth_of_max_on_either_side(lies_g, zeroed):
    scale = Scale(design.config(under_e=600.0))
    flags, net_mg, _ = weigh(scale, lying(lies_g))
    assert bool(flags[-1] & ScaleFlag.ZEROED) == zeroed
    assert abs(net_mg[-1]) <= 1 if zeroed else net_mg[-1] == pytest.approx(lies_g * 1000, abs=2)
    weigh(scale, lying(0.0))
    assert bool(scale.flags & ScaleFlag.ZEROED) == zeroed  # it is not tried again


def test_scale_zero_command_reaches_two_hundredths_of_max_on_either_side_of_the_first():
    scale = Scale(design.config(options=["initial_zero"]))
    assert refusal(scale.zero) == ScaleStatus.NOT_STABLE
    weigh(scale, lying(300.0))
    weigh(scale, lying(399.9))
    scale.zero()
    weigh(scale, lying(400.1))
    assert scale.net_mg == pytest.approx(200, abs=2)
    before = scale.save()
    assert refusal(scale.zero) == ScaleStatus.OUT_OF_RANGE
    assert scale.save() == before


def zero_moves_mg(scale: Scale, grams) -> np.ndarray:
    """Zero after each sample, by what the load is less than the curve says."""
    zeros = []
    for counts in counts_q7_of(grams).tolist():
        scale.update(counts, scale.last_us + PERIOD_US)
        zeros.append(scale.mass_mg - scale.load_mg)
    return np.array(zeros)


def test_scale_tracks_a_creeping_zero_and_not_a_weight():
    scale = Scale()
    weigh(scale, lying(0.0))
    creep = 3.0 * np.arange(4000) / 4000  # 3 e in 50 s
    zeros = zero_moves_mg(scale, creep)
    assert abs(scale.load_mg) <= E_MG // 4
    assert np.abs(zeros - creep * 1000).max() <= E_MG // 2
    zeros = zero_moves_mg(scale, lying(3.0 + 0.6, 1600))  # beyond e/2: a weight
    assert np.ptp(zeros) == 0
    assert scale.load_mg >= E_MG // 2


def test_scale_tracks_by_at_most_half_a_division_a_second():
    scale = Scale()
    weigh(scale, lying(0.0))
    zeros = zero_moves_mg(scale, np.tile(np.repeat([0.45, -0.02], 80), 5))
    second = round(1e6 / PERIOD_US)
    assert np.ptp(zeros) > 0
    assert max(np.ptp(zeros[at : at + second]) for at in range(len(zeros))) <= E_MG / 2


def test_scale_tracks_within_two_hundredths_of_max_and_not_at_all_if_told_so():
    config = design.config(max_g=50.0, interval_g=1.0)
    scale = Scale(config)
    weigh(scale, lying(0.0))
    zeros = zero_moves_mg(scale, 4.0 * np.arange(8000) / 8000)
    assert 50_000 // 50 - E_MG // 8 < zeros.max() <= 50_000 // 50
    scale = Scale(config)
    weigh(scale, lying(0.0))
    zeros = zero_moves_mg(scale, -4.0 * np.arange(8000) / 8000)
    assert -50_000 // 50 <= zeros.min() < E_MG // 8 - 50_000 // 50
    scale = Scale(config | {"options": design.OPTIONS["initial_zero"]})
    weigh(scale, lying(0.0))
    assert np.ptp(zero_moves_mg(scale, 0.4 * np.arange(800) / 800)) == 0


def test_scale_is_blank_above_max_plus_9_e_and_below_its_underload_and_then_never_stable():
    scale = Scale()
    weigh(scale, lying(0.0))
    for load_g, flag in (
        (5008.9, 0),
        (5009.1, ScaleFlag.OVER),
        (-19.9, 0),
        (-20.1, ScaleFlag.UNDER),
        (35_000.0, ScaleFlag.OVER),
        (-35_000.0, ScaleFlag.UNDER),
    ):
        flags, *_ = weigh(scale, lying(load_g))
        assert flags[-1] & (ScaleFlag.OVER | ScaleFlag.UNDER) == flag
        assert bool(flags[-1] & STABLE) == (flag == 0)
        if flag:
            assert refusal(scale.tare) == refusal(scale.zero) == ScaleStatus.NOT_STABLE


def test_scale_tares_and_clears_and_refuses_to_tare_nothing():
    scale = Scale()
    weigh(scale, lying(0.0))
    before = scale.save()
    assert refusal(scale.tare) == ScaleStatus.OUT_OF_RANGE
    assert scale.save() == before
    weigh(scale, lying(5005.0))  # more than Max, less than what is blanked
    assert refusal(scale.tare) == ScaleStatus.OUT_OF_RANGE
    weigh(scale, lying(250.0))
    scale.tare()
    weigh(scale, lying(750.0))
    assert scale.net_mg == pytest.approx(500_000, abs=2)
    assert scale.flags & ScaleFlag.TARED
    assert scale.shown == 500
    flags, net_mg, shown = weigh(scale, lying(0.0))
    assert (net_mg[-1], shown[-1]) == (pytest.approx(-250_000, abs=2), -250)
    assert flags[-1] & ScaleFlag.AT_ZERO  # of the load, so that zero is tracked under a tare
    scale.tare_clear()
    _, net_mg, _ = weigh(scale, lying(0.0, 1))
    assert abs(net_mg[0]) <= 1
    assert not scale.flags & ScaleFlag.TARED


@given(offset=st.floats(-0.5, 0.5), seed=st.integers(0, 99))
def test_scale_display_does_not_flicker_in_noise_below_its_hysteresis(offset, seed):
    rng = np.random.default_rng(seed)
    scale = Scale(design.config(options=[]))
    grams = 1234.0 + offset + rng.uniform(-0.049, 0.049, 300)
    _, net_mg, shown = weigh(scale, grams)
    assert (np.diff(shown) != 0).sum() <= 1  # where the first sample lay at the very edge
    assert np.abs(shown * 1000 - net_mg).max() <= (0.5 + 26 / 256 + 1 / 256) * 1000 + 1


def test_scale_display_shows_the_nearest_after_any_step():
    scale = Scale(design.config(options=[]))
    for load_g in np.random.default_rng(3).uniform(-10, 5000, 300):
        _, _, shown = weigh(scale, lying(load_g, 2))
        if abs(abs(load_g - np.floor(load_g)) - 0.5) > 0.01:
            assert abs(shown[-1] - load_g) <= 0.61


@pytest.mark.parametrize(
    ("unit", "decimals", "digit", "mass_g", "shown"),
    [
        ("g", 0, 5, 1001.0, 1000),
        ("kg", 3, 2, 1001.1, 1002),
        ("lb", 3, 1, 453.59237, 1000),  # 1 lb = 0.45359237 kg exactly (1959)
        ("oz", 2, 5, 453.59237, 1600),
        ("N", 2, 1, 1000 / 9.80665, 100),  # standard gravity (1901)
        ("N", 2, 2, 5000.0, 4904),
    ],
)
def test_scale_shows_published_relations_of_units(unit, decimals, digit, mass_g, shown):
    scale = Scale(design.config(unit=unit, decimals=decimals, digit=digit, options=[]))
    weigh(scale, lying(mass_g, 2))
    assert scale.shown == shown
    division = model.division_mg(USUAL | {
        "unit": design.units().index(unit), "decimals": decimals, "digit": digit
    })  # fmt: skip
    assert abs(shown / digit * division - mass_g * 1000) <= division / 2


def test_scale_reports_a_step_with_its_time_and_both_loads():
    scale = Scale()
    weigh(scale, lying(0.0))
    weigh(scale, lying(120.0))
    began_us = scale.last_us + PERIOD_US
    swing = 120 + 300 * np.exp(-np.arange(60) / 10) * np.cos(np.arange(60))
    flags, *_ = weigh(scale, np.concatenate([swing, lying(350.0, 80)]))
    assert (flags & STEPPED != 0).sum() == 1
    assert scale.steps == 2
    assert scale.step_us == began_us
    assert scale.step_from_mg == pytest.approx(120_000, abs=2)
    assert scale.step_to_mg == pytest.approx(350_000, abs=2)
    weigh(scale, lying(351.5))  # below step_mg: no event, though it was unstable meanwhile
    assert scale.steps == 2


def test_scale_holds_and_keeps_the_peak():
    scale = Scale()
    weigh(scale, lying(300.0))
    weigh(scale, lying(800.0))
    scale.show(ScaleShow.HELD)
    assert weigh(scale, lying(100.0 + 300.0))[2].tolist() == [500] * 60
    assert scale.flags & ScaleFlag.FROZEN
    scale.show(ScaleShow.PEAK)
    *_, shown = weigh(scale, np.concatenate([lying(900.0, 1), lying(650.0, 5)]))
    assert shown.tolist() == [600] * 6
    scale.show(ScaleShow.LIVE)
    assert weigh(scale, lying(650.0, 5))[2].tolist() == [350] * 5
    assert refusal(scale.show, 3) == ScaleStatus.UNKNOWN


@given(piece_g=st.floats(0.5, 40.0), reference=st.integers(40, 100))
def test_scale_counts_pieces_right_as_far_as_its_reference_allows(piece_g, reference):
    """Half a piece is reached only beyond n = reference * piece / (2 * error): error 2 mg."""
    scale = Scale()
    weigh(scale, lying(0.0))
    weigh(scale, lying(piece_g * reference))
    scale.count_out(reference)
    for pieces in (0, 1, reference, 7, int(4900 / piece_g)):
        weigh(scale, lying(piece_g * pieces, 2))
        assert scale.pieces == pieces


def test_scale_refuses_a_reference_that_cannot_count():
    scale = Scale()
    assert scale.pieces == 0
    assert refusal(scale.count_out, 10) == ScaleStatus.NOT_STABLE
    weigh(scale, lying(0.0))
    weigh(scale, lying(19.9))
    assert refusal(scale.count_out, 10) == ScaleStatus.TOO_LIGHT
    weigh(scale, lying(60.0))
    before = scale.save()
    assert refusal(scale.count_out, 0) == ScaleStatus.UNKNOWN
    assert refusal(scale.count_out, 40_000) == ScaleStatus.TOO_LIGHT
    assert scale.save() == before
    scale.count_out(10)
    weigh(scale, lying(40.0))
    scale.tare()
    weigh(scale, lying(22.0))
    assert scale.pieces == -3
