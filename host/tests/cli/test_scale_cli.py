# SPDX-License-Identifier: MIT
"""tare, set, calibrate, watch and info, as people and scripts meet them."""

import json
import re

import pytest
from typer.testing import CliRunner

from host.tests.captures import CaptureMaker
from host.tests.fake_chain import COUNTS_PER_G, EMPTY_COUNTS
from host.tests.fake_commands import Eeprom
from host.tests.fake_device import FakeDevice
from terazi.cli import app
from terazi.link.generated.messages import FaultFlag, Point, Setting
from terazi.link.generated.settings import SETTINGS
from terazi.recorder import load_recording
from terazi.settings import parse_settings

FACTORY_BAND_MG = 400


def constant(load_g):
    """A load that lies there; the scale has begun without it."""
    return lambda t_s: round(EMPTY_COUNTS + COUNTS_PER_G * (load_g if t_s > 1.5 else 0.0))


def shaken(t_s):
    return round(EMPTY_COUNTS + COUNTS_PER_G * 10 * (1 if int(t_s * 8) % 2 else -1))


def terazi(*words, **more):
    return CliRunner().invoke(app, [str(word) for word in words], env={"COLUMNS": "100"}, **more)


def assert_fails(done, code, words):
    """The exit code and one clear line."""
    assert done.exit_code == code, done.output
    assert "Traceback" not in done.output
    (line,) = [line for line in done.stderr.splitlines() if line.startswith("error: ")]
    assert words in line


# tare


def test_tare_takes_the_container_off_and_keeps_it():
    eeprom = Eeprom()
    with FakeDevice(load=constant(300.0), eeprom=eeprom) as device:
        # The first stable weight is that of nothing; the container comes after it.
        done = terazi("tare", device.path, "--wait", 20)
        while "nothing to tare" in done.stderr:
            done = terazi("tare", device.path, "--wait", 20)
    assert done.exit_code == 0, done.output
    assert re.fullmatch(r"tare (300\.\d\d|299\.\d\d) g; net -?0\.\d\d g; saved\n", done.stdout)
    assert eeprom.sequence >= 1


def test_tare_that_is_not_stable_says_by_how_much_it_moves():
    with FakeDevice(load=shaken) as device:
        done = terazi("tare", device.path, "--wait", 0.3)
    assert_fails(done, 6, "not stable after 0.3 s: the load moves by")
    moved = float(re.search(r"moves by ([\d.]+) g", done.stderr)[1])
    assert 3 < moved < 25


def test_tare_without_a_container_is_refused_with_what_to_do():
    with FakeDevice(load=lambda _t: EMPTY_COUNTS - 100) as device:
        done = terazi("tare", device.path)
        if done.exit_code == 0:
            pytest.fail(f"nothing was tared: {done.output}")
    assert_fails(done, 6, "there is nothing to tare")
    assert "terazi watch" in done.stderr


def test_tare_names_the_fault_that_keeps_it():
    with FakeDevice(silent_after=20) as device:
        done = terazi("tare", device.path, "--wait", 0.2)
    assert_fails(done, 6, "no weight to be trusted: cable out, no conversion comes")
    assert "DT at D2" in done.stderr


def test_tare_clear_and_zero_say_what_they_did():
    with FakeDevice(load=constant(0.0)) as device:
        assert terazi("tare", device.path, "--clear").stdout.startswith("no tare; net ")
        assert terazi("tare", device.path, "--zero").stdout.startswith("zero is set; net 0.0")
        told = json.loads(terazi("tare", device.path, "--zero", "--json").stdout)
    assert set(told) == {"net_mg", "zero_mg", "tare_mg"}


def test_tare_clear_and_zero_are_not_given_together():
    assert_fails(terazi("tare", "/dev/null", "--clear", "--zero"), 2, "two commands")


# set


def test_set_shows_old_and_new_and_what_goes_with_them_and_saves():
    eeprom = Eeprom()
    with FakeDevice(eeprom=eeprom) as device:
        done = terazi("set", device.path, "max=2kg", "e=0.5g", "checkweigher.on=yes")
        assert done.exit_code == 0, done.output
        for words in (
            "scale.max_mg  5000000 mg (5000 g) -> 2000000 mg (2000 g)",
            "scale.interval_mg  1000 mg (1 g) -> 500 mg (0.5 g)",
            f"scale.stable_band_mg  {FACTORY_BAND_MG} mg (0.4 g) -> {FACTORY_BAND_MG // 2} mg",
            "checkweigher.on  false -> true",
            "saved",
        ):
            assert words in done.stdout
        assert eeprom.config["max_mg"] == 2_000_000
        again = terazi("set", device.path, "max=2kg")
        assert "2000000 mg (2000 g), as it was" in again.stdout


def test_set_without_saving_is_gone_after_the_next_reset():
    with FakeDevice() as device:
        done = terazi("set", device.path, "unit=kg", "--no-save")
        assert "g -> kg" in done.stdout
        assert "not saved" in done.stdout
        assert "scale.unit  g\n" in terazi("set", device.path, "unit").stdout


@pytest.mark.parametrize(
    ("words", "complaint", "remedy"),
    [
        (("maxx=5",), "there is no setting 'maxx'", "scale.max_mg"),
        (("unit=kgg",), "scale.unit cannot be 'kgg'", "Did you mean kg?"),
        (("on=true",), "may mean checkweigher.on, temperature.on", "in full"),
        (("max=1000kg",), "out of range", "between 1 mg and"),
        (("max=0.5mg",), "no whole number of mg", ""),
        (("max=heavy",), "'heavy' is no number", "500"),
        (("max=5s",), "no unit s", ""),
        (("points=3",), "is not set by hand", "terazi calibrate"),
        (("checkweigher.on=maybe",), "true or false", ""),
        (("--everything",), "belongs to --reset", ""),
        (("max=5kg", "--reset"), "give one of", ""),
    ],
)
def test_set_refuses_before_the_board_is_disturbed(words, complaint, remedy):
    with FakeDevice() as device:
        done = terazi("set", device.path, *words)
        assert device.resets == 0
    assert_fails(done, 2, complaint)
    assert remedy in done.stderr


def test_set_that_the_board_refuses_changes_nothing_and_says_why():
    eeprom = Eeprom()
    with FakeDevice(eeprom=eeprom) as device:
        done = terazi("set", device.path, "unit=kg", "stable_band=3g")
        assert_fails(done, 6, "scale.stable_band_mg = 3000: ")
        assert "at most e / 2" in done.stderr
        assert device.chain.config["unit"] == 0
    assert eeprom.sequence == 0


def test_set_refuses_a_max_and_e_that_make_no_scale():
    with FakeDevice() as device:
        assert_fails(terazi("set", device.path, "e=1kg"), 2, "too coarse: at most Max / 16")


def test_set_lists_for_people_and_for_machines():
    with FakeDevice() as device:
        shown = terazi("set", device.path)
        told = json.loads(terazi("set", device.path, "--list", "--json").stdout)
        one = terazi("set", device.path, "hysteresis_q8")
    assert "scale.stable_us" in shown.stdout
    assert "checkweigher.limit_mg_3" not in shown.stdout  # there is one class
    assert told["scale.max_mg"] == 5_000_000
    assert "26 (0.1016 d)" in one.stdout


def test_settings_go_out_as_toml_and_come_back(tmp_path):
    file = tmp_path / "scale.toml"
    with FakeDevice() as device:
        assert terazi("set", device.path, "max=2kg", "gain=b_32").exit_code == 0
        assert terazi("set", device.path, "--export", file).exit_code == 0
        assert_fails(terazi("set", device.path, "--export", file), 8, "exists already")
        assert terazi("set", device.path, "--export", file, "--force").exit_code == 0
        assert "saved" in terazi("set", device.path, "--reset", "--everything").stdout
        assert device.chain.config["max_mg"] == 5_000_000
        done = terazi("set", device.path, "--import", file)
        assert "scale.max_mg  5000000 mg (5000 g) -> 2000000 mg (2000 g)" in done.stdout
        assert "chain.gain  a_128 -> b_32" in done.stdout
        assert "nothing to change" in terazi("set", device.path, "--import", file).stdout
        printed = terazi("set", device.path, "--export", "-").stdout
    assert parse_settings(printed, "printed") == parse_settings(file.read_text(), "the file")


def test_an_import_that_is_no_settings_file_is_named_before_the_board_is_disturbed(tmp_path):
    file = tmp_path / "bad.toml"
    file.write_text("[scale]\nmaxi_mg = 3\n")
    with FakeDevice() as device:
        assert_fails(terazi("set", device.path, "--import", file), 9, "maxi_mg")
        assert device.resets == 0


def test_an_eeprom_that_does_not_take_settings_is_named():
    with FakeDevice(eeprom=Eeprom(is_worn=True)) as device:
        done = terazi("set", device.path, "unit=kg")
    assert_fails(done, 8, "could not write its settings")


# calibrate


def calibrating(*loads_g, **more):
    """A board on which the next load lies as soon as a point of the one before is taken."""

    def load(_t_s):
        staged = device.chain.staged or []
        return round(EMPTY_COUNTS + COUNTS_PER_G * loads_g[min(len(staged), len(loads_g) - 1)])

    device = FakeDevice(load=load, **more)
    return device


def test_calibrate_by_a_list_of_masses_is_kept():
    eeprom = Eeprom()
    with calibrating(0, 2500, 5000, eeprom=eeprom) as device:
        words = ("--mass", 0, "--mass", "2.5kg", "--mass", "5kg", "--json", "--wait", 20)
        done = terazi("calibrate", device.path, *words)
        told = json.loads(done.stdout)
    assert [point["mass_mg"] for point in told["points"]] == [0, 2_500_000, 5_000_000]
    assert eeprom.config["points"] == 3
    assert "Put 2 500.0 g on" in done.stderr


def test_calibrate_needs_somebody_to_ask_or_masses():
    assert_fails(terazi("calibrate", "/dev/null"), 2, "nobody is there to ask")
    assert_fails(terazi("calibrate", "/dev/null", "--mass", 0), 2, "two points or more")
    assert_fails(terazi("calibrate", "/dev/null", "--mass", 0, "--mass", "x"), 2, "is no number")


def test_calibrate_that_contradicts_exits_with_13_and_leaves_the_board_as_it_was():
    with calibrating(0, 2500, 50) as device:
        words = ("--mass", 0, "--mass", "2500", "--mass", "500", "--wait", 20)
        done = terazi("calibrate", device.path, *words)
        assert_fails(done, 13, "you entered 500.0 g")
        assert device.chain.staged is None
        assert len(device.chain.points) == 2


def test_calibrate_abort_forgets_what_nobody_ended():
    with FakeDevice() as device:
        assert "no calibration" in terazi("calibrate", device.path, "--abort").stdout


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (("--no-mass",), "belong to --temperature"),
        (("--temperature",), "nobody is there to ask"),
    ],
)
def test_calibrate_temperature_is_refused_before_the_board_is_disturbed(words, complaint):
    with FakeDevice() as device:
        assert_fails(terazi("calibrate", device.path, *words), 2, complaint)
        assert device.resets == 0


def test_calibrate_temperature_without_a_thermometer_says_how_to_wire_one():
    with FakeDevice() as device:
        done = terazi("calibrate", device.path, "--temperature", "--yes")
    assert_fails(done, 13, "the board has no thermometer")
    assert "SDA at A4" in done.stderr


# watch and info


def test_watch_prints_a_line_for_each_change_into_a_pipe():
    with FakeDevice() as device:
        done = terazi("watch", device.path, "--seconds", 0.5)
    assert done.exit_code == 0, done.output
    assert re.search(r" 0 g  stable, zero$", done.stdout, re.M)
    assert re.search(r" 500 g  stable$", done.stdout, re.M)
    assert re.search(r"s  step 1: -?0\.\d\d g to (499|500)\.\d\d g$", done.stdout, re.M)


def test_watch_tells_machines_every_message():
    with FakeDevice() as device:
        done = terazi("watch", device.path, "--seconds", 0.3, "--json")
    told = [json.loads(line) for line in done.stdout.splitlines()]
    assert {"weight", "status"} <= {one["message"] for one in told}
    assert "net_mg" in next(one for one in told if one["message"] == "weight")


def test_info_explains_the_fault_that_holds():
    with FakeDevice(silent_after=60) as device:
        done = terazi("info", device.path)
        told = json.loads(terazi("info", device.path, "--json").stdout)
    assert done.exit_code == 0, done.output
    if "cable out" not in done.stdout:  # asked before the cable went
        assert "faults       none" in done.stdout
    assert set(told) >= {"hello", "status", "faults", "points", "settings"}
    assert [point["mass_mg"] for point in told["points"]] == [0, 5_000_000]


# log


def test_log_holds_settings_and_points_so_that_a_replay_verifies_the_mass(tmp_path):
    capture = tmp_path / "one.terazi"
    with FakeDevice() as device:
        assert terazi("log", device.path, "-o", capture, "--seconds", 0.4).exit_code == 0
    recording = load_recording(capture)
    assert len(recording.of_kind(Setting)) == len(SETTINGS)
    assert len(recording.of_kind(Point)) == 2
    told = json.loads(terazi("replay", capture, "--json").stdout)
    assert {one["stage"]: one["compared"] for one in told["stages"]}["mass"] == len(recording)
    assert [one["what"] for one in told["unverified"]] == ["net weight and its flags"]


def test_log_writes_steps_and_faults_into_a_table_of_events(tmp_path):
    capture = tmp_path / "one.terazi"
    with FakeDevice(silent_after=600, speed=40.0) as device:
        done = terazi("log", device.path, "-o", capture, "--seconds", 0.6)
    assert done.exit_code == 0, done.output
    head, *rows = capture.with_suffix(".events.csv").read_text().splitlines()
    assert head.startswith("host_s,device_us,boot,message,from_mg,to_mg,steps,mass_mg,verdict")
    assert [row.split(",")[3] for row in rows] == ["step", "step", "fault"]
    assert rows[0].split(",")[6] == "1"


def test_log_of_a_board_that_does_not_tell_its_settings_goes_on_and_says_so(tmp_path):
    capture = tmp_path / "one.terazi"
    with FakeDevice(answers=False) as device:
        done = terazi("log", device.path, "-o", capture, "--seconds", 0.2)
    assert done.exit_code == 0, done.output
    assert "a replay will not verify the mass" in done.stderr
    told = json.loads(terazi("replay", capture, "--json").stdout)
    assert "mass" in [one["what"] for one in told["unverified"]]


def test_report_shows_stability_steps_and_faults(tmp_path):
    maker = CaptureMaker(tmp_path / "one.terazi").hello().samples(300, events=True)
    maker.chain.faults = FaultFlag.CABLE_OUT
    maker.say(maker.chain.fault())
    path = maker.samples(100, events=True, restart=True).end()
    assert terazi("report", path).exit_code == 0
    page = path.with_suffix(".html").read_text()
    for words in ("marked stable", "step at 2.", "→", '<span class="never">cable out</span>'):
        assert words in page
