# SPDX-License-Identifier: GPL-3.0-or-later
"""The program on a pseudo-terminal, used as a person or avrdude uses a real board.

Nothing here asserts how long something took; limits are only there so that a hang fails.
"""

import contextlib
import csv
import os
import re
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import serial

from virtual_uno.optiboot import SOURCE, optiboot_hex
from virtual_uno.program import read_hex, read_program

HANG_S = 60.0


@pytest.fixture
def board(avr, tmp_path):
    """``board(*options)`` starts the program; it has .path, .stop() and .done()."""
    started = []

    class Board:
        def __init__(self, *options, program="hello.c"):
            words = ["--elf", avr(program)] if program else []
            self.process = subprocess.Popen(
                [sys.executable, "-m", "virtual_uno", *map(str, [*words, *options])],
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                cwd=tmp_path,
                env={**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])},
            )
            started.append(self.process)
            self.path = self.process.stdout.readline().strip()

        def stop(self, how=signal.SIGTERM):
            self.process.send_signal(how)
            return self.done()

        def done(self):
            """(exit code, what it said on stderr)"""
            _, said = self.process.communicate(timeout=HANG_S)
            return self.process.returncode, said

    yield Board
    for process in started:
        if process.poll() is None:
            process.kill()
        process.communicate()


def opened(path, baud=115200):
    return serial.Serial(str(path), baud, timeout=HANG_S)


def is_the_greeting(said):
    """EXTRF, with PORF where the program had not yet run since power-on."""
    return said in (b"<2>", b"<3>")


def is_a_counting_stream(data):
    """a..z over and over, 256 letters a round: n is eight bits wide."""
    letters = bytes(97 + n % 26 for n in range(256)) * 2
    for start in range(256):
        if letters[start : start + 20] == data[:20]:
            expected = (letters[start : start + 256] * (len(data) // 256 + 1))[: len(data)]
            return data == expected
    return False


def test_opening_resets_the_chip_each_time(board):
    port = board().path
    for _ in range(3):
        with opened(port) as line:
            said = line.read(200)
            assert is_the_greeting(said[:3])
            assert is_a_counting_stream(said[3:])


def test_bytes_from_before_the_opening_are_gone(board):
    port = board("--speed", "0").path
    with opened(port) as line:
        line.read(10)
        line.write(b"x" * 50)
        time.sleep(0.05)  # let the terminal's buffers fill in both directions
    with opened(port) as line:
        assert is_the_greeting(line.read(3))
        assert is_a_counting_stream(line.read(500))  # no echo of what was sent before


def test_closing_and_opening_at_once_is_two_openings(board):
    program = board("--speed", "0.01")  # long slices of real time between looks
    for _ in range(20):
        with opened(program.path) as line:
            assert is_the_greeting(line.read(3))
    assert "20 opened" in program.stop()[1]


def test_a_second_opening_beside_the_first_does_not_reset(board):
    port = board().path
    with opened(port) as line:
        line.read(10)
        opened(port).close()
        assert b"<" not in line.read(2000)


def test_host_to_device_and_back(board):
    with opened(board().path) as line:
        line.read(3)
        line.write(b"q")
        assert line.read_until(b"Q").endswith(b"Q")


def test_a_slow_reader_makes_time_wait_and_loses_nothing(board):
    with opened(board("--speed", "0").path) as line:
        assert is_the_greeting(line.read(3))
        time.sleep(0.5)  # many times what the terminal's buffer holds, at full speed
        assert is_a_counting_stream(line.read(60000))


def test_another_baud_rate_garbles(board):
    port = board().path
    with opened(port, 57600) as line:
        assert not is_the_greeting(line.read(300)[:3])
    with opened(port, 115200) as line:
        assert is_the_greeting(line.read(300)[:3])


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGINT])
def test_signals_end_it_cleanly_and_take_the_link_away(board, tmp_path, how):
    link = tmp_path / "uno"
    program = board("--link", link)
    assert os.path.realpath(link) == program.path
    with opened(link) as line:
        assert is_the_greeting(line.read(3))
        code, said = program.stop(how)
        assert code == 0
        assert re.fullmatch(r"virtual Uno: [\d.]+ s simulated, 1 opened, .*\n", said)
        with pytest.raises((serial.SerialException, OSError)):
            line.read(1000000)  # what was still buffered, then the end of the line
    assert not os.path.lexists(link)


def test_a_link_replaces_a_stale_link_but_nothing_else(board, tmp_path):
    stale = tmp_path / "stale"
    stale.symlink_to("/nowhere")
    board("--link", stale)
    assert stale.exists()
    taken = tmp_path / "taken"
    taken.write_text("dear")
    code, said = board("--link", taken).done()
    assert code == 2
    assert "exists and is no link" in said
    assert taken.read_text() == "dear"


def test_it_ends_after_the_seconds_asked_for(board):
    code, said = board("--seconds", "3", "--speed", "0").done()
    assert code == 0
    assert "3.0" in said.split(" s simulated")[0]


def test_truth_and_scenario_start_anew_at_each_opening(board, tmp_path):
    (tmp_path / "ramp.py").write_text(
        "import numpy as np\n"
        "def load(t):\n    return 100 * t + 5 * np.sin(300 * t)\n"
        "load.truth_g = lambda t: 100 * t\n"
    )
    truth = tmp_path / "truth.csv"
    options = ["--scenario", "ramp:load", "--truth", truth, "--speed", "0", "--rate", "92"]
    program = board(*options, program="reader.c")
    for _ in range(2):
        with opened(program.path) as line:
            data = np.frombuffer(line.read(4 * 100), np.uint8).reshape(-1, 4).astype(int)
    assert program.stop()[0] == 0
    with open(truth) as file:
        rows = list(csv.DictReader(file))
    t_s = np.array([float(row["t_s"]) for row in rows])
    load_g = np.array([float(row["load_g"]) for row in rows])
    counts = np.array([int(row["counts"]) for row in rows])
    assert t_s[0] < 1 / 92 + 1e-3
    assert np.diff(t_s) == pytest.approx(1 / 92, abs=1e-6)
    assert load_g == pytest.approx(100 * t_s, rel=1e-5, abs=1e-5)
    felt_g = load_g + 5 * np.sin(300 * t_s)
    assert counts[4:] == pytest.approx(429.55 * felt_g[4:], abs=2)  # the first four settle
    sent = data[:, 0] << 16 | data[:, 1] << 8 | data[:, 2]
    assert (sent == counts[:100] & 0xFFFFFF).all()


def test_scenario_from_npz(board, tmp_path):
    path = tmp_path / "steps.npz"
    np.savez(path, t_s=[0, 1, 1.001, 10], load_g=[0, 0, 50, 50], truth_g=[0, 0, 49, 49])
    truth = tmp_path / "truth.csv"
    board("--scenario", path, "--truth", truth, "--seconds", "2", "--speed", "0").done()
    with open(truth) as file:
        last = list(csv.DictReader(file))[-1]
    assert float(last["load_g"]) == 49
    assert int(last["counts"]) == round(50 * 429.55)


@pytest.mark.parametrize(
    ("scenario", "complaint"),
    [
        ("nothing.npz", "No such file"),
        ("no_such_module:load", "No module named"),
        ("math:nothing", "no attribute"),
        ("math:pi", "is no function"),
        ("heavy", "neither FILE.npz, module:function nor grams"),
        ("short.npz", "it needs load_g"),
        ("uneven.npz", "differ in length"),
        ("chilly.npz", "differ in length"),
    ],
)
def test_bad_scenarios_are_refused_in_one_line(board, tmp_path, scenario, complaint):
    np.savez(tmp_path / "short.npz", load=[1])
    np.savez(tmp_path / "uneven.npz", load_g=[1, 2], t_s=[0])
    np.savez(tmp_path / "chilly.npz", load_g=[1, 2], rate_hz=1, temperature_c=[0])
    code, said = board("--scenario", scenario).done()
    assert code == 2
    assert said.startswith("virtual Uno: ")
    assert complaint in said
    assert said.count("\n") == 1


@pytest.mark.parametrize(
    ("options", "degrees"),
    [
        (["--imu", "mpu6050"], 25.0),
        (["--imu", "mpu6050", "--temperature", "31.5"], 31.5),
        (["--imu", "mpu6050", "--scenario", "warm.npz"], 12.0),
        (["--imu", "mpu6050", "--scenario", "warm.npz", "--temperature", "-5"], -5.0),
        (["--scenario", "warm.npz"], None),
    ],
)
def test_an_imu_feels_the_temperature_asked_for(board, tmp_path, options, degrees):
    np.savez(tmp_path / "warm.npz", load_g=[0, 0], rate_hz=1, temperature_c=[12.0, 12.0])
    running = board(*options, program="warmth.c")
    with opened(running.path) as port:
        port.readline()  # perhaps cut
        said = port.readline().decode().strip()
    running.stop()
    assert said == "none" if degrees is None else abs(int(said) / 340 + 36.53 - degrees) < 0.002


def test_bad_options_are_refused(board, tmp_path):
    code, said = board("--temperature", "20").done()
    assert code == 2
    assert "--imu mpu6050" in said
    code, said = board(program=None).done()
    assert code == 2
    assert "nothing to run" in said
    assert board("--speed", "-1").done()[0] == 2
    code, said = board("--elf", tmp_path / "missing.elf", program=None).done()
    assert code == 2
    assert "missing.elf" in said


def test_a_crash_of_the_program_ends_it_with_code_1(board):
    code, said = board("--seconds", "1", "--speed", "0", program="crash.c").done()
    assert code == 1
    assert "crashed at" in said


def test_waveforms_are_written_at_the_end(board, tmp_path, vcd_edges):
    board("--seconds", "0.095", "--vcd", tmp_path / "w.vcd", program="reader.c").done()
    assert len(vcd_edges(tmp_path / "w.vcd", "SCK")) == 2 * 25 * 7


needs_avrdude = pytest.mark.skipif(
    not (shutil.which("avrdude") and SOURCE.exists()),
    reason="avrdude or arduino-core-avr is not installed",
)


def avrdude(port, image, *, part="atmega328p"):
    words = ["avrdude", "-q", "-p", part, "-c", "arduino", "-P", str(port), "-b", "115200"]
    words += ["-D", "-U", f"flash:w:{image}:i"]
    return subprocess.run(words, capture_output=True, text=True, timeout=HANG_S)


@pytest.fixture
def hello_hex(avr, tmp_path):
    path = tmp_path / "hello.hex"
    subprocess.run(["avr-objcopy", "-O", "ihex", str(avr("hello.c")), str(path)], check=True)
    return path


@needs_avrdude
def test_unmodified_avrdude_flashes_through_the_boot_loader(board, avr, tmp_path, hello_hex):
    image = tmp_path / "flash.hex"
    options = ["--boot", "optiboot", "--flash-image", image]
    program = board(*options, program=None)
    done = avrdude(program.path, hello_hex)
    assert done.returncode == 0, done.stderr
    assert "verified" in done.stderr
    with opened(program.path) as line:  # the program starts when the loader has waited in vain
        assert line.read(3) == b"<0>"  # the loader took the cause of the reset away
        assert is_a_counting_stream(line.read(100))
    assert program.stop()[0] == 0
    saved = dict(read_hex(image))
    ((address, code),) = read_program(avr("hello.c")).flash
    assert saved[address][: len(code)] == code
    # and the image is a board that has been flashed
    with contextlib.closing(opened(board(*options, program=None).path)) as line:
        assert line.read(3) == b"<0>"


@needs_avrdude
def test_avrdude_fails_with_the_wrong_part(board, hello_hex):
    program = board("--boot", "optiboot", program=None)
    assert avrdude(program.path, hello_hex, part="atmega2560").returncode == 1
    assert avrdude(program.path, hello_hex).returncode == 0  # and then it works


@needs_avrdude
def test_the_boot_loader_fits_its_512_bytes():
    (start, code), (version, _) = read_hex(optiboot_hex())
    assert start == 0x7E00
    assert start + len(code) <= version == 0x7FFE
