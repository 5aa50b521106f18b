# SPDX-License-Identifier: MIT
"""Branches of shared_c that the host's tests take: a pytest plugin.

    python -m pytest -p tools.checks.c_coverage host/tests/shared_c
    gcovr ... .build/coverage

It puts a build of the extension that counts branches in place of the shipped one, as --sanitized
does with its own: UBSan adds branches, so that one build cannot serve both.
"""

import importlib.util
import os
import shutil
import sys
from pathlib import Path

from tools.extension import cshared

EXTENSION = "terazi.cshared._cshared"
FOLDER = Path(__file__).resolve().parents[2] / ".build/coverage"


def pytest_configure(config) -> None:
    """Build once, in the process that starts the workers; load in each."""
    if "PYTEST_XDIST_WORKER" not in os.environ:
        shutil.rmtree(FOLDER, ignore_errors=True)
        cshared.build(FOLDER / "extension", coverage=FOLDER / "objects")
    (built,) = (FOLDER / "extension").glob("_cshared.*")
    spec = importlib.util.spec_from_file_location(EXTENSION, built)
    sys.modules[EXTENSION] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sys.modules[EXTENSION])
