# SPDX-License-Identifier: MIT
"""The UBSan build does end the run: without this, a green sanitized run would prove nothing."""

import subprocess
import sys

from tools.extension import cshared

OVERFLOW = """
import importlib.util, sys
spec = importlib.util.spec_from_file_location("_cshared", sys.argv[1])
module = importlib.util.module_from_spec(spec)
spec.loader.exec_module(module)
ffi, lib = module.ffi, module.lib
nets, masses = ffi.new("int32_t[]", [-2**31]), ffi.new("int32_t[]", 1)
lib.blocks_mass(nets, int(sys.argv[2]), 1, masses, 1)  # net - tare
print("survived")
"""


def run(tare: int) -> subprocess.CompletedProcess:
    extension = str(cshared.ensure(sanitize=True))
    command = [sys.executable, "-c", OVERFLOW, extension, str(tare)]
    return subprocess.run(command, capture_output=True, text=True)


def test_signed_overflow_ends_the_sanitized_build():
    ended = run(tare=1)
    assert ended.returncode != 0
    assert "signed integer overflow" in ended.stderr
    assert "survived" not in ended.stdout


def test_the_sanitized_build_lives_where_nothing_overflows():
    lived = run(tare=0)
    assert lived.stdout.strip() == "survived", lived.stderr
