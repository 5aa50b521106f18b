# SPDX-License-Identifier: MIT
"""For a person who has only the Arduino IDE: lines in, lines out, and back to frames."""

import re

import numpy as np
import pytest

from terazi.link.generated.messages import (
    Ack,
    CalibrateBegin,
    GetInfo,
    Sample,
    SetStream,
    SetTextMode,
    Status,
    Weight,
    WeightFlag,
)

SAMPLE_LINE = re.compile(
    r"raw:(-?\d+),fir:(-?\d+),kf:(-?\d+),weight_g:(-?\d+\.\d{3}),stable:([01])"
)
BARE_NUMBER = re.compile(r"(?:^|[\s,;])-?\d+(?:\.\d+)?(?=$|[\s,;])")


def text_lines(data):
    """The whole lines in what came, frames before and after them left out."""
    lines = data.rsplit(b"\0", 1)[-1].decode("ascii").split("\r\n")[:-1]
    return lines if lines[0].startswith(("raw:", "# ")) else lines[1:]


def enter(uno):
    uno.link.hello()
    uno.samples(1)
    uno.link.command(SetTextMode(on=1))


def test_text_mode_sends_lines_that_the_serial_plotter_draws(uno):
    enter(uno)
    lines = text_lines(uno.read_raw(2.0))
    assert len(lines) > 10
    assert all(SAMPLE_LINE.fullmatch(line) for line in lines), lines


@pytest.mark.board(noise_counts=0.0)
def test_text_mode_tells_what_the_frames_tell(uno):
    uno.load(counts=-1234567)
    enter(uno)
    uno.wait(1.0)
    raw, fir, kf, weight_g, stable = SAMPLE_LINE.fullmatch(
        text_lines(uno.read_raw(0.5))[-1]
    ).groups()
    assert (int(raw), int(fir)) == (-1234567, -1234567)
    assert abs(int(kf) - -1234567) <= 1
    assert abs(float(weight_g) - -1234567 * 2.328e-3) < 0.003
    assert stable == "0", "counts without any noise are a fault"


@pytest.mark.board(noise_counts=0.0)  # a fault, so that nothing is zeroed
@pytest.mark.parametrize(
    ("counts", "weight_g"),
    [(0, "0.000"), (1, "0.002"), (-1, "-0.002"), (43, "0.100"), (430, "1.001"), (-430, "-1.001")],
)
def test_text_mode_sets_the_point_right_in_small_weights(uno, counts, weight_g):
    uno.load(counts=counts)
    enter(uno)
    uno.wait(6.0)
    line = text_lines(uno.read_raw(0.3))[-1]
    assert line == f"raw:{counts},fir:{counts},kf:{counts},weight_g:{weight_g},stable:0"


def test_text_mode_ends_by_frame_and_the_frames_are_whole_again(uno):
    enter(uno)
    uno.wait(0.5)
    uno.link.command(SetTextMode(on=0))
    uno.wait(0.1)
    bad = uno.link.stream.frames_bad
    assert {type(one.message) for one in uno.wait(1.5)} == {Sample, Status, Weight}
    assert uno.link.stream.frames_bad == bad


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r"], ids=repr)
def test_text_mode_is_entered_and_left_by_lines(uno, end):
    uno.link.hello()
    uno.samples(1)
    uno.write(b"text" + end)
    lines = text_lines(uno.read_raw(0.5))
    assert lines[0] == "# text: ok"
    assert SAMPLE_LINE.fullmatch(lines[-1])
    uno.write(b"frames" + end)
    uno.wait(0.2)
    assert {type(one.message) for one in uno.wait(1.5)} == {Sample, Status, Weight}
    uno.link.command(GetInfo())  # the lines left nothing behind in the decoder


def test_a_line_between_frames_spoils_neither_neighbour(uno):
    uno.link.hello()
    uno.link.command(SetStream(mask=0))
    uno.wait(0.2)
    first = uno.link.send(GetInfo())
    uno.write(b"info\r\n")
    second = uno.link.send(GetInfo())
    acks = [one.message for one in uno.wait(0.5) if isinstance(one.message, Ack)]
    assert [ack.command_sequence for ack in acks] == [first, 0, second]
    assert uno.link.status().rx_bad_frames == 0


def put_on(uno, grams):
    """A load that stands, on a scale that was zeroed without it."""
    enter(uno)
    uno.wait(1.5)
    uno.load(grams=grams)
    uno.wait(3.0)


def last_sample(uno):
    uno.link.command(SetTextMode(on=0))
    return uno.samples(2)[-1].message


def test_tare_by_line_is_answered_and_done(uno):
    put_on(uno, 321.0)
    uno.write(b"tare\r\n")
    assert "# tare: ok" in text_lines(uno.read_raw(0.5))
    sample = last_sample(uno)
    assert WeightFlag.TARED in sample.weight_flags
    assert abs(sample.net_mg) < 500 < 320_000 < sample.mass_mg


def test_zero_and_clear_by_line_are_answered_and_done(uno):
    put_on(uno, 50.0)
    uno.write(b"zero\n")
    assert "# zero: ok" in text_lines(uno.read_raw(0.5))
    uno.load(grams=321.0)
    uno.wait(3.0)
    uno.write(b"tare\n")
    uno.wait(0.5)
    uno.write(b"clear\n")
    assert "# clear: ok" in text_lines(uno.read_raw(0.5))
    sample = last_sample(uno)
    assert WeightFlag.TARED not in sample.weight_flags
    assert abs(sample.net_mg - 271_000) < 500


def test_what_a_word_cannot_do_now_it_says(uno):
    uno.load(grams=lambda t_s: 100.0 * np.floor(3 * t_s))
    enter(uno)
    uno.write(b"tare\n")
    assert "# tare: not stable" in text_lines(uno.read_raw(0.5))
    uno.load(grams=0.0)
    uno.wait(3.0)
    uno.write(b"clear\n")
    uno.wait(0.3)
    uno.write(b"tare\n")
    uno.read_raw(0.3)
    uno.link.command(CalibrateBegin())
    uno.read_raw(0.2)
    uno.write(b"zero\n")
    assert "# zero: calibrating" in text_lines(uno.read_raw(0.5))


def test_info_by_line_names_version_gain_and_rate(uno):
    enter(uno)
    uno.wait(2.5)
    uno.write(b"info\r\n")
    told = [line for line in text_lines(uno.read_raw(0.5)) if line.startswith("#")]
    hello = uno.link.stream.hello
    version = f"v{hello.version_major}.{hello.version_minor}.{hello.version_patch}"
    build = re.fullmatch(rf"# Terazi {version} build=(0x[0-9a-f]+) \(text frames .*\)", told[0])
    assert int(build[1], 16) == hello.build
    assert re.fullmatch(r"# gain=128 rate_hz=\d+\.\d{3}", told[1])


@pytest.mark.board(rate_sps=92.0)
def test_info_by_line_tells_the_measured_rate(uno):
    enter(uno)
    uno.wait(2.5)
    uno.write(b"info\r\n")
    told = [line for line in text_lines(uno.read_raw(0.5)) if "rate_hz" in line]
    assert abs(float(told[0].split("rate_hz=")[1]) - 92.0) < 0.02


@pytest.mark.parametrize("word", [b"hello", b"TARE", b"tar", b"tare ", b"x"], ids=repr)
def test_an_unknown_line_is_named_and_does_nothing(uno, word):
    put_on(uno, 321.0)
    uno.write(word + b"\n")
    lines = text_lines(uno.read_raw(0.5))
    assert f"# {word.decode()}: unknown (text frames tare clear zero info)" in lines
    assert WeightFlag.TARED not in last_sample(uno).weight_flags


@pytest.mark.parametrize("line", [b"a line much too long for any command", b"ta\x07re", b""])
def test_a_line_that_cannot_be_a_command_is_passed_over(uno, line):
    enter(uno)
    uno.write(line + b"\ntext\n")
    told = [line for line in text_lines(uno.read_raw(0.5)) if line.startswith("#")]
    assert told == ["# text: ok"]


def test_other_lines_hold_no_number_that_the_plotter_would_draw(uno):
    enter(uno)
    uno.wait(0.3)
    came = b""
    for word in (b"info\n", b"tare\n", b"text\n", b"nothing\n"):
        uno.write(word)
        came += uno.read_raw(0.2)
    told = [line for line in text_lines(came) if line.startswith("#")]
    assert len(told) == 5
    assert not [line for line in told if BARE_NUMBER.search(line)]


def test_text_mode_heeds_the_stream_mask(uno):
    uno.link.hello()
    uno.samples(1)
    uno.link.command(SetStream(mask=0))
    uno.link.command(SetTextMode(on=1))
    uno.read_raw(0.1)
    assert uno.read_raw(1.5) == b""
