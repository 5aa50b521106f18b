# SPDX-License-Identifier: MIT
"""Where the vector runner lies; `./dev` builds it with the firmware."""

from pathlib import Path

import pytest

RUNNER_ELF = Path(__file__).resolve().parents[2] / ".build" / "target_vectors" / "runner.elf"


@pytest.fixture(scope="session")
def runner_elf():
    if not RUNNER_ELF.exists():
        pytest.fail(f"{RUNNER_ELF} is not built: run ./dev setup")
    return RUNNER_ELF
