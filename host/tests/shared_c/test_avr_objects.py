# SPDX-License-Identifier: MIT
"""shared_c as avr-gcc compiles it: no warnings, and no routine that is large and slow."""

import re
import shutil
import subprocess

import pytest

from tools.gen.spec import ROOT

SHARED, PORT = ROOT / "shared_c", ROOT / "firmware" / "port"
SOURCES = sorted([*(SHARED / "src").glob("*.c"), *(SHARED / "generated").glob("*.c")])
WARNINGS = ["-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wdouble-promotion", "-Werror"]
# Ours, avr-libc's copies, avr-gcc's 16 x 16 and 16 x 32 products, its jump for a switch, and the
# start-up code that fills RAM.
LAWFUL = re.compile(
    r"(port|fir|weight_kf|mass|frame|messages|imu_cal|rest|mahony|scale|temperature)_\w+"
    r"|checkweigher_\w+|faults_\w+|settings_\w+|zupt_\w+"
    r"|__u?mulhisi3|__muluhisi3|mem(cpy|move|set)|__tablejump2__|__do_copy_data|__do_clear_bss"
)

pytestmark = pytest.mark.skipif(shutil.which("avr-gcc") is None, reason="avr-gcc is not installed")


@pytest.mark.parametrize("source", SOURCES, ids=lambda path: path.name)
def test_avr_object_calls_no_division_no_float_and_no_64_bit_routine(source, tmp_path):
    folders = [SHARED / "include", SHARED / "src", SHARED / "generated", PORT]
    target = tmp_path / "object.o"
    command = ["avr-gcc", "-mmcu=atmega328p", "-Os", "-std=gnu11", *WARNINGS]
    command += [f"-I{folder}" for folder in folders]
    subprocess.run([*command, "-c", str(source), "-o", str(target)], check=True)
    listing = subprocess.run(
        ["avr-nm", "--undefined-only", str(target)], check=True, capture_output=True, text=True
    )
    called = {line.split()[-1] for line in listing.stdout.splitlines()}
    assert {name for name in called if not LAWFUL.fullmatch(name)} == set()


def test_the_law_on_avr_objects_would_catch_a_division(tmp_path):
    source = tmp_path / "divides.c"
    source.write_text("#include <stdint.h>\nint32_t f(int32_t a, int32_t b) { return a / b; }\n")
    target = tmp_path / "object.o"
    command = ["avr-gcc", "-mmcu=atmega328p", "-Os", "-c", str(source), "-o", str(target)]
    subprocess.run(command, check=True)
    listing = subprocess.run(
        ["avr-nm", "--undefined-only", str(target)], check=True, capture_output=True, text=True
    )
    assert not LAWFUL.fullmatch(listing.stdout.split()[-1])
