# SPDX-License-Identifier: MIT
"""A scale followed and commanded over a line that loses things, in lock step with the double."""

import pytest

from host.tests.fake_bench import Bench
from terazi.control import Balance, faults
from terazi.control.display import Watch, marks, shown
from terazi.control.settings import apply_settings, read_settings
from terazi.errors import CommandRefused, NoAnswer
from terazi.link.generated import messages
from terazi.link.generated.messages import (
    CalibrateAbort,
    CalibrateBegin,
    FaultFlag,
    GetSetting,
    Point,
    Result,
    SaveSettings,
    Setting,
    Status,
    Tare,
)
from terazi.link.refusals import SPECIAL, WORDS, refusal


def twice(name):
    """The first two of these are lost."""
    left = [2]

    def lose(what):
        if what != name:
            return False
        left[0] -= 1
        return left[0] >= 0

    return lose


def standing(load_g=0.0, **more):
    """A scale that has found its zero and then a load."""
    bench = Bench(**more)
    balance = Balance(bench.link)
    balance.follow(2.0)
    bench.load_g = load_g
    balance.follow(2.0)
    return bench, balance


@pytest.mark.parametrize("fault", ["lose", "deaf"])
def test_a_tare_whose_answer_is_lost_is_done_once_in_effect(fault):
    bench, balance = standing(300.0)
    setattr(bench, fault, twice("Tare"))
    weight = balance.tare(2.0)
    assert bench.commands.count("Tare") == 3
    assert weight.tare_mg == pytest.approx(300_000, abs=100)
    assert abs(weight.net_mg) < 100


def test_a_third_loss_is_no_answer():
    bench, balance = standing(300.0)
    bench.lose = lambda name: name == "Tare"
    with pytest.raises(NoAnswer, match="does not acknowledge Tare after 3 attempts"):
        balance.tare(2.0)


def test_done_before_counts_only_for_a_repetition():
    bench = Bench()
    with pytest.raises(CommandRefused, match="no calibration is under way"):
        bench.link.command(CalibrateAbort(), done_before=Result.NOT_CALIBRATING)
    bench.link.command(CalibrateBegin())
    bench.lose = twice("CalibrateAbort")
    bench.link.command(CalibrateAbort(), done_before=Result.NOT_CALIBRATING)
    assert bench.chain.staged is None


def test_an_answer_that_is_lost_behind_its_ack_is_asked_for_anew():
    bench = Bench()
    answer = bench.chain.answer
    calls = []

    def without_message(frame, **more):
        calls.append(frame.id)
        wire = answer(frame, **more)
        return wire[: wire.index(0) + 1] if len(calls) < 3 else wire

    bench.chain.answer = without_message
    assert bench.link.ask(GetSetting(0), Setting, key=0).value == 5_000_000
    assert calls == [GetSetting.ID] * 3
    calls.clear()
    bench.chain.answer = lambda _frame: b""
    with pytest.raises(NoAnswer):
        bench.link.ask(GetSetting(0), Setting, key=0)


def test_an_answer_to_another_key_is_not_taken_for_it():
    bench = Bench()
    bench.link.ask(GetSetting(0), Setting, key=0)
    assert bench.link.ask(GetSetting(1), Setting, key=1).value == 1000


def test_a_command_waits_while_the_eeprom_is_written():
    bench, balance = standing()
    balance.obey(SaveSettings())
    balance.obey(SaveSettings())  # the double refuses it with BUSY until the first is done
    assert bench.commands.count("SaveSettings") > 2
    assert balance.wait_saved() == 2


def test_weights_from_before_a_tare_are_not_taken_for_those_after_it():
    bench, balance = standing(300.0)
    bench.link._waiting.clear()
    bench.link.request(messages.GetInfo())  # weights pile up behind it
    for _turn in range(30):
        bench.link._read(0.05)
    assert abs(balance.tare(0.0).net_mg) < 100


def test_a_reset_in_between_forgets_the_spread_of_before():
    bench, balance = standing(300.0)
    bench.load_g = 0.0
    balance.follow(0.3)
    assert balance.spread_mg > 100_000
    bench.reset()
    balance.follow(1.5)
    assert balance.spread_mg < 1000


def test_a_fault_is_what_keeps_a_weight_from_being_stable():
    bench, balance = standing()
    bench.chain.faults = FaultFlag.AT_RAIL
    bench.moves_g = 5.0
    with pytest.raises(CommandRefused, match="no weight to be trusted: at rail") as caught:
        balance.wait_stable(1.0)
    assert "E+, E-, A+, A-" in caught.value.remedy


@pytest.mark.parametrize(("load_g", "words"), [(5100.0, "more than Max"), (-400.0, "below zero")])
def test_a_load_beyond_the_limits_is_told_as_that(load_g, words):
    _bench, balance = standing(load_g)
    with pytest.raises(CommandRefused, match=words):
        balance.wait_stable(0.5)
    assert shown(balance.weight).startswith("-----")


def test_settings_that_contradict_are_put_back_whatever_was_set_before():
    bench = Bench()
    names = ["scale.max_mg", "scale.unit", "scale.stable_band_mg"]
    before = read_settings(bench.link, names)
    with pytest.raises(CommandRefused, match=r"scale\.stable_band_mg = 5000"):
        apply_settings(
            bench.link, {"scale.unit": 1, "scale.max_mg": 9_000_000, "scale.stable_band_mg": 5000}
        )
    assert read_settings(bench.link, names) == before


def test_settings_are_taken_in_whatever_order_suits_the_device():
    bench = Bench()
    wanted = {"scale.interval_mg": 10, "scale.stable_band_mg": 4, "scale.decimals": 2}
    apply_settings(bench.link, wanted)  # e first would contradict the band
    back = {"scale.stable_band_mg": 400, "scale.interval_mg": 1000, "scale.decimals": 0}
    apply_settings(bench.link, back)  # the band first would contradict e
    assert read_settings(bench.link, back) == back


def test_points_are_read_until_there_are_no_more():
    bench = Bench()
    assert Balance(bench.link).points() == [Point(0, 0, 0), Point(1, 274_914_089, 5_000_000)]


def test_a_watch_tells_steps_restarts_and_faults_once():
    bench = Bench()
    state = Watch(bench.link)
    told = []
    state.on_told = lambda _received, events: told.extend(
        line.split("s  ", 1)[1] for line in events
    )
    state.balance.follow(2.0)
    bench.load_g = 500.0
    state.balance.follow(2.0)
    bench.chain.faults = FaultFlag.NOISE_HIGH
    state.balance.follow(1.0)
    bench.chain.faults = FaultFlag(0)
    state.balance.follow(1.0)
    bench.reset()
    state.balance.follow(1.0)
    assert [line.split(":")[0] for line in told] == [
        "step 1",
        "fault",
        "over",
        "the board has started anew",
    ]
    assert "stable" in marks(state.balance.weight)


def test_every_result_and_every_fault_has_words_and_every_word_a_result():
    assert set(WORDS) == set(Result) - {Result.OK}
    assert set(faults.WORDS) == set(FaultFlag)
    for (command, result), (words, _remedy) in SPECIAL.items():
        assert words in str(refusal("the board", command.__new__(command), result))
    assert "result 99" in str(refusal("the board", Tare(), 99))


def test_unknown_faults_of_a_newer_board_are_told_as_such():
    assert faults.names(FaultFlag(0x8001)) == ["cable out", "unknown fault 0x8000"]


def test_status_is_asked_for_anew_when_it_is_lost():
    bench = Bench(lose=twice("GetInfo"))
    assert isinstance(bench.link.status(), Status)
