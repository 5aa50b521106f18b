# SPDX-License-Identifier: MIT
"""Options and settings of all host tests.

--sanitized runs them over the UBSan build of shared_c, in which undefined behaviour ends the run.
"""

import importlib.util
import signal
import sys
from pathlib import Path

import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parents[2]
EXTENSION = "terazi.cshared._cshared"

# The same examples on every machine; a failure prints how to repeat it.
settings.register_profile("terazi", derandomize=True, deadline=None, print_blob=True)
settings.load_profile("terazi")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--sanitized", action="store_true", help="run over shared_c built with UBSan")


def pytest_configure(config: pytest.Config) -> None:
    # Shells make what they start in the background deaf to ctrl-C, and so all that this starts.
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if not config.getoption("sanitized"):
        return
    sys.path.insert(0, str(ROOT))
    from tools.extension import cshared

    built = cshared.ensure(sanitize=True)  # workers of xdist find it built
    if EXTENSION in sys.modules:
        raise pytest.UsageError(f"{EXTENSION} was imported before --sanitized could replace it")
    spec = importlib.util.spec_from_file_location(EXTENSION, built)
    module = importlib.util.module_from_spec(spec)
    sys.modules[EXTENSION] = module
    spec.loader.exec_module(module)


def pytest_report_header(config: pytest.Config) -> str:
    return f"shared_c: {'UBSan' if config.getoption('sanitized') else 'as shipped'} build"
