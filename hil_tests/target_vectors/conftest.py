# SPDX-License-Identifier: MIT
"""Where the vector runners lie; `./dev` builds them with the firmware."""

from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[2] / ".build" / "target_vectors"


def built(name: str) -> Path:
    elf = FOLDER / name
    if not elf.exists():
        pytest.fail(f"{elf} is not built: run ./dev setup")
    return elf


@pytest.fixture(scope="session")
def runner_elf():
    return built("runner.elf")


@pytest.fixture(scope="session")
def runner_scale_elf():
    return built("runner_scale.elf")


@pytest.fixture(scope="session")
def runner_temperature_elf():
    return built("runner_temperature.elf")


@pytest.fixture(scope="session")
def runner_settings_elf():
    return built("runner_settings.elf")


@pytest.fixture(scope="session")
def runner_faults_elf():
    return built("runner_faults.elf")


@pytest.fixture(scope="session")
def runner_zupt_elf():
    return built("runner_zupt.elf")


@pytest.fixture(scope="session")
def runner_zupt_gru_elf():
    return built("runner_zupt_gru.elf")
