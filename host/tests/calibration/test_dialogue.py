# SPDX-License-Identifier: MIT
"""The calibration's conversation, in lock step with the test double."""

import pytest

from host.tests.fake_bench import Bench, Script
from terazi.calibration import Plan, calibrate
from terazi.control import Balance
from terazi.errors import Aborted, CalibrationRefused, CannotWrite, CommandRefused, UsageError


def puts(bench, load_g, text=""):
    """A person who puts a load on and says something."""

    def act():
        bench.load_g = load_g
        return text

    return act


def held(bench):
    return [(one.counts_q7, one.mass_mg) for one in bench.chain.points]


def converse(bench, *answers, **plan):
    script = Script(*answers)
    outcome = calibrate(Balance(bench.link), script, Plan(**plan))
    assert not script.answers, "the conversation ended before the script"
    return outcome, script


def weighs_mg(bench, load_g):
    """What the board says after a reset, when it stands."""
    bench.reset()
    bench.link.hello()
    bench.load_g = load_g
    balance = Balance(bench.link)
    balance.follow(1.0)
    return balance.wait_stable(5.0).net_mg


def test_a_person_calibrates_with_two_points_and_the_board_keeps_it():
    bench = Bench(counts_per_g=612.0)
    outcome, script = converse(
        bench, "", "", "", puts(bench, 0), "", puts(bench, 5000), "save", "2kg", puts(bench, 2000)
    )
    assert [one.mass_mg for one in outcome.points] == [0, 5_000_000]
    assert outcome.check_off_mg == pytest.approx(0, abs=300)
    assert outcome.settings_saved == 1
    assert bench.chain.staged is None
    assert "within class III's 1 e" in script.text
    assert script.asked[3] == "Take everything off, then press Enter."
    assert script.asked[5] == "Put 5 000.0 g on, then press Enter."
    assert any("stable" in live for live in script.lives)
    assert weighs_mg(bench, 1000) == pytest.approx(1_000_000, abs=300)


def test_max_and_e_are_asked_for_and_what_makes_no_scale_is_refused():
    bench = Bench()
    factory = bench.chain.config
    _outcome, script = converse(
        bench, "2kg", "1kg", "3g", "0.2g", "2", puts(bench, 0), "2kg", puts(bench, 2000), "save", ""
    )
    assert "too coarse" in script.text
    assert "1, 2 or 5 times a power of ten" in script.text
    bench.reset()
    config = bench.chain.config
    assert (config["max_mg"], config["interval_mg"]) == (2_000_000, 200)
    assert config["stable_band_mg"] * 5 == factory["stable_band_mg"]
    assert (config["decimals"], config["digit"]) == (1, 2)


def test_five_points_take_the_bend_off_and_residuals_are_shown():
    bench = Bench(cell=lambda g: g + 0.001 * g * (5000 - g) / 5000, noise_counts=4.0)
    masses = [0, 1250, 2500, 3750, 5000]
    answers = ["", "", "5"]
    for number, mass_g in enumerate(masses):
        answers += [puts(bench, mass_g)] if number == 0 else ["", puts(bench, mass_g)]
    _outcome, script = converse(bench, *answers, "save", "")
    rows = [line.split("  ") for line in script.said if line.endswith("%")]
    off_e = [float(row[3].removesuffix(" e")) for row in rows]
    assert len(off_e) == 5
    assert off_e[2] < -0.3 < 0.3 < off_e[0]  # the middle weighs too much by a straight line
    assert "The cell bends by 0.01" in script.text
    assert weighs_mg(bench, 1250) == pytest.approx(1_250_000, abs=100)


def test_a_mass_that_contradicts_is_refused_and_put_right():
    bench = Bench()
    _outcome, script = converse(
        bench,
        *("", "", "3"),
        puts(bench, 0),
        *("2500", puts(bench, 2500)),
        *("500", puts(bench, 50), "again", puts(bench, 500)),
        *("save", ""),
    )
    assert "You entered 500.0 g, by the points so far the cell says about 50.0 g" in script.text
    assert [one.mass_mg for one in bench.chain.points] == [0, 500_000, 2_500_000]


def test_a_mass_that_was_mistyped_is_entered_anew_without_lifting_it():
    bench = Bench()
    converse(
        bench,
        *("", "", "3"),
        puts(bench, 0),
        *("5kg", puts(bench, 5000)),
        *("2kg", puts(bench, 1000), "mass", "1kg", ""),
        *("save", ""),
    )
    assert [one.mass_mg for one in bench.chain.points] == [0, 1_000_000, 5_000_000]


def test_a_doubtful_point_may_be_kept():
    bench = Bench(cell=lambda g: g * (1.05 if g > 3000 else 1.0))  # a poor cell
    converse(
        bench,
        *("", "", "3", puts(bench, 0), "2500", puts(bench, 2500)),
        *("5000", puts(bench, 5000), "keep", "save", ""),
    )
    assert len(bench.chain.points) == 3


def test_enter_before_the_mass_lies_there_does_not_take_the_empty_pan_twice():
    bench = Bench()
    script = Script("", "", "", puts(bench, 0), "", "", "again", puts(bench, 5000), "save", "")
    calibrate(Balance(bench.link), script, Plan())
    assert "differ by 0 counts only" in script.text or "counts only" in script.text
    assert weighs_mg(bench, 5000) == pytest.approx(5_000_000, abs=300)


def test_a_load_that_never_stands_still_is_named_and_tried_again():
    bench = Bench()

    def hold_still():
        bench.moves_g = 0.0
        return "again"

    bench.moves_g = 20.0
    _outcome, script = converse(
        bench,
        *("", "", "", puts(bench, 0), hold_still, puts(bench, 0), "", puts(bench, 5000)),
        *("save", ""),
        wait_s=3.0,
    )
    assert "Not stable after 3 s: the load moves by" in script.text


def test_a_point_is_repeated_and_one_is_added_at_the_end():
    bench = Bench()
    _outcome, script = converse(
        bench,
        *("", "", "", puts(bench, 0), "", puts(bench, 4990)),  # 5 kg, said to lie there
        *("again", "2", puts(bench, 5000)),
        *("add", "", puts(bench, 2500)),
        *("save", ""),
    )
    assert [one.mass_mg for one in bench.chain.points] == [0, 2_500_000, 5_000_000]
    assert weighs_mg(bench, 2500) == pytest.approx(2_500_000, abs=300)
    assert script.asked[-2].startswith("What now? save")


def interrupt():
    raise KeyboardInterrupt


@pytest.mark.parametrize("end", ["abort", "ctrl-C", "port vanished"])
@pytest.mark.parametrize("at", [5, 6, 7])
def test_whatever_ends_it_early_leaves_the_board_as_it_was(end, at):
    bench = Bench()
    before = (held(bench), dict(bench.chain.config))
    answers = ["3kg", "0.5g", "2", puts(bench, 0), "", puts(bench, 3000), "save", ""]
    answers[at - 1 :] = [interrupt]
    raises = KeyboardInterrupt
    if end == "abort":
        answers = ["3kg", "0.5g", "2", puts(bench, 0), "", puts(bench, 3000), "abort"]
        raises = Aborted
    if end == "port vanished":
        raises = Vanished

        def vanish():
            raise Vanished

        answers[at - 1 :] = [vanish]
    script = Script(*answers)
    with pytest.raises(raises):
        calibrate(Balance(bench.link), script, Plan())
    assert (held(bench), bench.chain.config) == before
    assert bench.chain.staged is None
    assert bench.eeprom.sequence == 0


class Vanished(Exception):
    pass


def test_a_half_done_calibration_of_another_program_does_not_stand_in_the_way():
    bench = Bench()
    from terazi.link.generated.messages import CalibrateBegin, CalibrateKnown

    bench.link.command(CalibrateBegin())
    bench.link.command(CalibrateKnown(1, 777))
    converse(bench, "", "", "", puts(bench, 0), "", puts(bench, 5000), "save", "")
    assert [one.mass_mg for one in bench.chain.points] == [0, 5_000_000]


def losing(*names, times=1):
    """A line that loses so many answers to each of these commands."""
    left = dict.fromkeys(names, times)

    def lose(name):
        left[name] = left.get(name, 0) - 1
        return left[name] >= 0

    return lose


EVERY_COMMAND = (
    "SetStream",
    "GetSetting",
    "SetSetting",
    "GetPoint",
    "CalibrateBegin",
    "CalibratePoint",
    "CalibrateEnd",
    "SaveSettings",
    "GetInfo",
)


@pytest.mark.parametrize("fault", ["lose", "deaf"])
@pytest.mark.parametrize("name", EVERY_COMMAND)
def test_a_command_or_its_answer_may_be_lost_at_every_step(fault, name):
    bench = Bench()
    setattr(bench, fault, losing(name, times=2))
    converse(
        bench,
        *("3kg", "0.5g", "2", puts(bench, 0), "", puts(bench, 3000), "save", "1500"),
        puts(bench, 1500),
    )
    assert bench.commands.count(name) > 2
    assert [one.mass_mg for one in bench.chain.points] == [0, 3_000_000]
    assert bench.chain.config["interval_mg"] == 500


def test_an_abort_whose_answer_is_lost_is_done_all_the_same():
    bench = Bench(lose=losing("CalibrateAbort", times=2))
    with pytest.raises(Aborted):
        converse(bench, "", "", "", puts(bench, 0), "", puts(bench, 5000), "abort")
    assert bench.chain.staged is None


# Without anybody to ask.


class Hand(Script):
    """Puts on what is asked for, a moment later."""

    def __init__(self, bench, *loads_g):
        super().__init__()
        self._bench, self._loads = bench, list(loads_g)

    def tell(self, text, *, tone=""):
        super().tell(text, tone=tone)
        if (text.startswith("Put ") or text.startswith("Take ")) and self._loads:
            self._bench.load_g = self._loads.pop(0)


def scripted(bench, masses_g, loads_g=None, **plan):
    masses_mg = tuple(round(g * 1000) for g in masses_g)
    hand = Hand(bench, *(masses_g if loads_g is None else loads_g))
    plan = Plan(masses_mg=masses_mg, asks=False, wait_s=5.0, **plan)
    return calibrate(Balance(bench.link), hand, plan), hand


def test_a_list_of_masses_calibrates_without_a_question():
    bench = Bench()
    outcome, hand = scripted(bench, (0, 2000, 5000))
    assert not hand.asked
    assert [one.mass_mg for one in outcome.points] == [0, 2_000_000, 5_000_000]
    assert "best about 3 500.0 g" in hand.text
    assert weighs_mg(bench, 3500) == pytest.approx(3_500_000, abs=300)


def test_a_list_waits_for_each_load_and_says_when_none_comes():
    bench = Bench()
    before = held(bench)
    with pytest.raises(CalibrationRefused, match="nothing was put on or taken off within 5 s"):
        scripted(bench, (0, 2000), (0, 0))
    assert held(bench) == before


def test_a_list_with_a_doubtful_point_is_refused_unless_it_is_meant():
    with pytest.raises(CalibrationRefused, match=r"the cell says about 50\.\d g") as caught:
        scripted(Bench(), (0, 2000, 500), (0, 2000, 50))
    assert caught.value.exit_code == 13
    bench = Bench()
    scripted(bench, (0, 2000, 500), (0, 2000, 50), takes_doubtful=True)
    assert len(bench.chain.points) == 3


def test_a_list_that_contradicts_is_refused_also_if_it_is_meant():
    bench = Bench()
    before = held(bench)
    with pytest.raises(CalibrationRefused, match="the other way"):
        scripted(bench, (0, 2000, 1000), (0, 2000, 3000), takes_doubtful=True)
    assert held(bench) == before


def test_a_range_that_makes_no_scale_is_refused_before_anything_is_touched():
    bench = Bench()
    with pytest.raises(UsageError, match="too coarse"):
        scripted(bench, (0, 500), interval_mg=1_000_000)
    assert "CalibrateBegin" not in bench.commands


def test_a_load_that_moves_ends_a_list_with_how_much():
    bench = Bench()
    bench.moves_g = 20.0
    with pytest.raises(CommandRefused, match="not stable after 5 s: the load moves by"):
        scripted(bench, (0, 2000))
    assert bench.chain.staged is None


def test_an_eeprom_that_does_not_take_it_is_named():
    bench = Bench()
    bench.eeprom.is_worn = True
    with pytest.raises(CannotWrite, match="could not write its settings"):
        scripted(bench, (0, 2000))


def test_a_digit_too_much_is_noticed_by_the_calibration_of_before():
    bench = Bench()
    scripted(bench, (0, 5000))
    bench.load_g = 0.0
    with pytest.raises(CalibrationRefused, match=r"by its calibration until now .* 50\d\.\d g"):
        scripted(bench, (0, 5000), (0, 500))


def test_a_load_beyond_the_old_max_can_be_taken():
    bench = Bench(counts_per_g=612.0 * 10)  # by the factory's curve 14 times as heavy
    outcome, _hand = scripted(bench, (0, 1200), max_mg=1_500_000, interval_mg=500)
    assert len(outcome.points) == 2
    assert weighs_mg(bench, 600) == pytest.approx(600_000, abs=200)
