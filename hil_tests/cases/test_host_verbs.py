# SPDX-License-Identifier: MIT
"""What `terazi tare|calibrate|set|info|watch` do, against the firmware: the whole road of each."""

import numpy as np
import pytest

from host.tests.fake_bench import Script
from terazi.calibration import Plan, calibrate
from terazi.calibration import temperature as temperature_run
from terazi.control import Balance
from terazi.control.display import Watch
from terazi.control.settings import apply_settings, read_settings
from terazi.errors import CalibrationRefused, CommandRefused
from terazi.link.generated.messages import Result, SaveSettings, WeightFlag
from terazi.settings import apply_file, parse_settings, read_device, render_settings

NOISE_COUNTS = 38.7
E_MG = 1000
COUNTS_PER_G = 612.0  # no cell that the factory thought of
ZERO_COUNTS = -31_000.0
BEND = 2e-4  # of the range, at its middle
MAX_G = 5000.0
SETTLED_S = 2.0


class Cell:
    """A load cell with a bend; what lies on it is put there by a person."""

    def __init__(self, uno, *, turned=1.0):
        self._uno, self._turned = uno, turned
        self.put(0.0)

    def put(self, load_g):
        bend_g = 4 * BEND * load_g * (MAX_G - load_g) / MAX_G
        counts = ZERO_COUNTS + self._turned * COUNTS_PER_G * (load_g + bend_g)
        self._uno.load(counts=counts)

    def person(self, load_g, says=""):
        """A person who puts a load on and says something."""

        def act():
            self.put(load_g)
            return says

        return act


def started(uno):
    """The scale, with what it said since it started."""
    uno.link.stream.hello = None
    uno.link.hello()
    return Balance(uno.link)


def weighed_mg(uno, cell, load_g):
    cell.put(load_g)
    balance = Balance(uno.link)
    balance.follow(SETTLED_S)
    return balance.wait_stable(5.0).net_mg


@pytest.mark.board(noise_counts=NOISE_COUNTS)
@pytest.mark.parametrize("turned", [1.0, -1.0], ids=["rising", "turned"])
def test_a_person_calibrates_a_cell_and_the_scale_is_right_after_a_reset(uno, turned):
    cell = Cell(uno, turned=turned)
    masses_g = (0.0, 1250.0, 2500.0, 3750.0, 5000.0)
    answers = ["5kg", "1g", "5", cell.person(0.0)]
    for mass_g in masses_g[1:]:
        answers += ["", cell.person(mass_g)]
    script = Script(*answers, "save", "3kg", cell.person(3000.0))
    outcome = calibrate(started(uno), script, Plan())
    assert [point.mass_mg for point in outcome.points] == [round(g * 1000) for g in masses_g]
    assert abs(outcome.check_off_mg) < 0.3 * E_MG
    assert "saved, and read back" in script.text
    cell.put(0.0)
    uno.reset("external")
    assert [(p.counts_q7, p.mass_mg) for p in started(uno).points()] == [
        (p.counts_q7, p.mass_mg) for p in outcome.points
    ]
    for load_g in (600.0, 2000.0, 4300.0):
        assert abs(weighed_mg(uno, cell, load_g) - load_g * 1000) < 0.3 * E_MG, load_g


@pytest.mark.board(noise_counts=NOISE_COUNTS)
def test_two_points_leave_the_bend_and_the_residuals_of_five_show_it(uno):
    cell = Cell(uno)
    answers = ["5kg", "1g", "3", cell.person(0.0), "", cell.person(2500.0), "", cell.person(5000.0)]
    script = Script(*answers, "save", "")
    calibrate(started(uno), script, Plan())
    (bends,) = [line for line in script.said if line.startswith("The cell bends by")]
    # A bow of BEND at the middle: least squares through three points leaves two thirds there.
    assert float(bends.split()[4].rstrip("%;")) / 100 == pytest.approx(2 / 3 * BEND, rel=0.15)


@pytest.mark.board(noise_counts=NOISE_COUNTS)
def test_an_interrupted_calibration_leaves_the_firmware_as_it_was(uno):
    cell = Cell(uno)
    balance = started(uno)
    before = read_device(uno.link)

    def interrupt():
        raise KeyboardInterrupt

    script = Script("3kg", "0.5g", "3", cell.person(0.0), "", cell.person(3000.0), interrupt)
    with pytest.raises(KeyboardInterrupt):
        calibrate(balance, script, Plan())
    assert read_device(uno.link) == before
    balance.fresh()
    balance.follow(0.5)
    assert balance.weight.calibrating == 0


@pytest.mark.board(noise_counts=NOISE_COUNTS)
def test_a_contradiction_is_refused_and_nothing_has_changed(uno):
    cell = Cell(uno)
    balance = started(uno)
    before = read_device(uno.link)
    loads = iter((0.0, 2500.0, 50.0))

    class Hand(Script):
        def tell(self, text, *, tone=""):
            super().tell(text, tone=tone)
            if text.startswith(("Put ", "Take ")):
                cell.put(next(loads))

    plan = Plan(masses_mg=(0, 2_500_000, 500_000), asks=False, wait_s=5.0)
    with pytest.raises(CalibrationRefused, match=r"the cell says about 5\d\.\d g"):
        calibrate(balance, Hand(), plan)
    assert read_device(uno.link) == before


@pytest.mark.board(noise_counts=NOISE_COUNTS)
def test_tare_and_zero_wait_for_the_load_and_outlive_a_reset(uno):
    balance = started(uno)
    balance.quiet_stream()
    balance.follow(SETTLED_S)
    assert balance.is_stable
    uno.load(grams=750.0)  # it moves while the command is on its way
    weight = balance.tare(5.0)
    assert weight.tare_mg == pytest.approx(750_000, abs=0.3 * E_MG)
    assert abs(weight.net_mg) < 0.25 * E_MG
    balance.wait_saved()
    uno.reset("external")
    balance = started(uno)
    balance.follow(SETTLED_S)
    assert balance.weight.weight_flags & WeightFlag.TARED
    assert abs(balance.weight.net_mg) < 0.3 * E_MG
    assert balance.clear().net_mg == pytest.approx(750_000, abs=0.3 * E_MG)
    with pytest.raises(CommandRefused, match="further than 2 % of Max"):
        balance.zero(5.0)


@pytest.mark.board(noise_counts=NOISE_COUNTS)
def test_a_load_that_moves_is_refused_with_by_how_much(uno):
    balance = started(uno)
    balance.quiet_stream()
    uno.load(grams=lambda t_s: 500.0 + 10.0 * np.sin(2 * np.pi * 1.3 * t_s))
    balance.follow(SETTLED_S)
    with pytest.raises(CommandRefused, match="not stable after 2 s: the load moves by") as caught:
        balance.tare(2.0)
    moved_g = float(str(caught.value).rsplit(" ", 2)[-2])
    assert 5.0 < moved_g < 21.0
    assert caught.value.result == Result.NOT_STABLE


@pytest.mark.parametrize(
    ("fault", "words"),
    [("cable_out", "cable out"), ("dout_low", "dout stuck")],
)
def test_a_fault_is_named_where_a_weight_was_waited_for(uno, fault, words):
    balance = started(uno)
    balance.follow(SETTLED_S)
    uno.fault(fault)
    balance.follow(1.0)
    with pytest.raises(CommandRefused, match=f"no weight to be trusted: {words}") as caught:
        balance.wait_stable(0.5)
    assert "D2" in caught.value.remedy
    uno.clear_faults()
    balance.follow(SETTLED_S)
    assert balance.wait_stable(2.0).faults == 0


def test_settings_are_set_all_or_none_and_kept_when_saved(uno):
    balance = started(uno)
    wanted = {"scale.max_mg": 2_000_000, "scale.interval_mg": 200, "scale.stable_band_mg": 80}
    before = apply_settings(uno.link, wanted | {"scale.under_mg": 4000, "scale.decimals": 1})
    assert before["scale.interval_mg"] == E_MG
    with pytest.raises(CommandRefused, match=r"scale\.stable_band_mg = 101: .* at most"):
        raise_with_remedy(uno.link, {"scale.step_mg": 3000, "scale.stable_band_mg": 101})
    assert read_settings(uno.link, ["scale.step_mg"])["scale.step_mg"] != 3000
    balance.obey(SaveSettings())
    assert balance.wait_saved() == 1
    uno.reset("power_on" if uno.simulated else "external")
    started(uno)
    assert read_settings(uno.link, wanted) == wanted


def raise_with_remedy(link, wanted):
    """As the command line shows it: the error and what to do."""
    try:
        apply_settings(link, wanted)
    except CommandRefused as error:
        raise CommandRefused(f"{error} {error.remedy}", result=error.result) from error


def test_settings_go_out_as_toml_and_come_back_after_a_reset_to_the_factorys(uno):
    balance = started(uno)
    apply_settings(uno.link, {"scale.unit": 1, "scale.decimals": 3, "checkweigher.on": 1})
    changed = read_device(uno.link)
    text = render_settings(changed)
    apply_settings(uno.link, {"scale.unit": 0, "scale.decimals": 0, "checkweigher.on": 0})
    changes = apply_file(balance, parse_settings(text, "the text"))
    assert {change.name for change in changes} == {
        "scale.unit",
        "scale.decimals",
        "checkweigher.on",
    }
    assert read_device(uno.link) == changed


@pytest.mark.board(noise_counts=NOISE_COUNTS)
def test_a_watch_tells_weight_steps_and_faults_as_they_come(uno):
    started(uno)
    state = Watch(uno.link)
    told = []
    state.on_told = lambda _received, events: told.extend(events)
    state.balance.follow(SETTLED_S)
    uno.load(grams=500.0)
    state.balance.follow(SETTLED_S)
    assert state.balance.is_stable
    uno.fault("cable_out")
    state.balance.follow(1.0)
    uno.clear_faults()
    state.balance.follow(SETTLED_S)
    words = [line.split("s  ", 1)[1] for line in told]
    (step,) = [line for line in words if line.startswith("step 1: ")]
    assert float(step.split(" to ")[1].removesuffix(" g")) == pytest.approx(500.0, abs=0.3)
    assert any(line.startswith("fault: cable out: no conversion comes") for line in words)
    assert "over: cable out" in words
    assert state.rate_hz == pytest.approx(80.0, rel=0.01)


@pytest.mark.board(noise_counts=5.0)
def test_a_temperature_run_holds_a_cell_where_it_was(uno):
    board = uno.truth("warm a scale")
    zero, span, load_g = 25.0, 60.0, [0.0]  # counts/K, ppm/K

    def warmth(t_s):  # up by 20 K in 250 s and down again: each series is of one direction
        return 20.0 + 20.0 * np.abs((t_s / 250.0 + 1) % 2 - 1)

    def counts(t_s):
        above_k = warmth(t_s) - 20.0
        drift = zero * above_k + span * 1e-6 * above_k * 429.55 * load_g[0]
        return 9000.0 + 429.55 * load_g[0] + drift

    def put(grams):
        load_g[0] = grams
        board.load(counts=counts)

    class Hand(Script):
        def tell(self, text, *, tone=""):
            super().tell(text, tone=tone)
            if text.startswith("Put one mass on"):
                put(2000.0)

    board.imu.fit()
    board.imu.feel(temperature_c=warmth)
    put(0.0)
    plan = temperature_run.Plan(asks=False, span_k=4.0)
    balance = started(uno)
    balance.follow(60.0)  # the thermometer's smoothing lags by 16 s; then it does so evenly
    fit = temperature_run.calibrate_temperature(balance, Hand(), plan)
    assert fit.zero_counts_per_k == pytest.approx(zero, abs=1.0)
    assert fit.span_ppm_per_k == pytest.approx(span, abs=3.0)
    uno.reset("power_on")
    assert read_settings(uno.link, ["temperature.on"]) == {"temperature.on": 1}
    balance = started(uno)
    masses_mg = []
    for _turn in range(20):
        balance.follow(2.0)
        masses_mg.append(balance.weight.net_mg)
    assert np.ptp(masses_mg) < 0.5 * E_MG  # 3 K would be 0.5 g of zero and span
