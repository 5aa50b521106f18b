# SPDX-License-Identifier: MIT
"""Cycles of the shared modules in the vector runner: variants that the firmware need not call.

The runner is linked from the firmware's own objects, so that a call costs what it costs there.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from target_vectors.avr_core import AvrCore
from terazi.design import specs
from terazi.link.generated.messages import ImuStatus
from tools.measure import (
    runner_adaptive,
    runner_faults,
    runner_imu,
    runner_mahony,
    runner_scale,
    runner_settings,
    runner_temperature,
    runner_zupt,
    runner_zupt_gru,
)
from virtual_uno.profile import Cost

RUNNER = Path(__file__).resolve().parents[2] / ".build" / "target_vectors" / "runner.elf"
RUNNER_SCALE = RUNNER.with_name("runner_scale.elf")  # one chip does not hold all modules
RUNNER_FAULTS = RUNNER.with_name("runner_faults.elf")
RUNNER_SETTINGS = RUNNER.with_name("runner_settings.elf")
RUNNER_TEMPERATURE = RUNNER.with_name("runner_temperature.elf")
RUNNER_ZUPT = RUNNER.with_name("runner_zupt.elf")
RUNNER_ZUPT_GRU = RUNNER.with_name("runner_zupt_gru.elf")
SEED = 7
RAIL_LOW, RAIL_HIGH = -(1 << 23), (1 << 23) - 1


@dataclass(frozen=True)
class Case:
    """A function, and what makes the chip call it with all sorts of data."""

    function: str
    drive: Callable[[AvrCore], object]
    prepare: Callable[[AvrCore], object] | None = None  # done before, not measured
    elf: Path | None = None  # where its module is not in the usual runner


def samples(count: int = 240) -> list[int]:
    """Noise of full scale, a resting weight, both rails for longer than any window, and beyond."""
    rng = random.Random(SEED)
    noise = [rng.randint(RAIL_LOW, RAIL_HIGH) for _ in range(count)]
    weight = [429_550 + rng.randint(-100, 100) for _ in range(count)]
    rails = [RAIL_HIGH] * 70 + [RAIL_LOW] * 70 + [RAIL_HIGH + 1, RAIL_LOW - 1] * 4
    return noise + weight + rails


def within_rails(counts: list[int]) -> list[int]:
    """What a converter, and a filter behind it, can give."""
    return [min(max(each, RAIL_LOW), RAIL_HIGH) for each in counts]


def drive_mass(core: AvrCore) -> None:
    for counts in within_rails(samples(40)):
        core.mass_mg(counts * 128, 2328 << 16)


def drive_frames(core: AvrCore) -> None:
    """IMU_STATUS, the longest frame, with bytes of all sorts."""
    rng = random.Random(SEED)
    for device_us in (0, 1, (1 << 32) - 1):
        core.encode(ImuStatus.ID, 255, device_us, rng.randbytes(ImuStatus.LEN))


def fir_case(design: int | list[int], *, by_heart: bool = False) -> Case:
    function = "fir_update_default" if by_heart else "fir_update"
    return Case(function, lambda core: core.fir(design, 0, samples(), by_heart=by_heart))


def _fir_design(name: str) -> int:
    return [design["name"] for design in specs.fir_designs()].index(name)


def _cases() -> dict[str, Case]:
    cases = {
        f"fir_{design['name']}": fir_case(index)
        for index, design in enumerate(specs.fir_designs())
        if index > 0
    }
    loaded = specs.fir_taps_q15("lowpass32").tolist()
    return {
        "frame_encode": Case("frame_encode", drive_frames),
        "fir32_generic": fir_case(0),
        "fir32_default": fir_case(0, by_heart=True),
        "fir32_loaded": fir_case(loaded),
        "fir64_generic": fir_case(_fir_design("lowpass64")),
        "weight_kf_constant": Case(
            "weight_kf_update", lambda core: core.weight_kf(0, 0, within_rails(samples()))
        ),
        "mass": Case("mass_from_counts", drive_mass),
        "weight_kf_adaptive": Case("weight_kf_adaptive_update", runner_adaptive.drive_single),
        "weight_kf_adaptive_pair": Case(
            "weight_kf_adaptive_pair_update", runner_adaptive.drive_pair
        ),
        "imu_cal": Case("imu_cal_apply", runner_imu.drive_imu_cal),
        "imu_cal_turn": Case("imu_cal_turn", runner_imu.drive_imu_turn),
        "rest": Case("rest_update", runner_imu.drive_rest),
        **{
            key: Case(function, runner_mahony.drive, runner_mahony.prepare)
            for key, function in {
                "mahony_update": "mahony_update",
                "mahony_mag": "mahony_update_mag",
                "mahony_quaternion": "mahony_quaternion",
                "euler": "mahony_euler",
            }.items()
        },
        **{
            f"mahony{axes}": Case(
                f"attitude{axes}", runner_mahony.drive_chain, runner_mahony.prepare_chain(axes)
            )
            for axes in (6, 9)
        },
        "scale": Case("scale_update", runner_scale.drive_scale, elf=RUNNER_SCALE),
        "scale_shown": Case("scale_shown", runner_scale.drive_scale, elf=RUNNER_SCALE),
        "checkweigher": Case(
            "checkweigher_update", runner_scale.drive_checkweigher, elf=RUNNER_SCALE
        ),
        "faults": Case("faults_update", runner_faults.drive, elf=RUNNER_FAULTS),
        "settings": Case("settings_save_step", runner_settings.drive, elf=RUNNER_SETTINGS),
        "temperature": Case(
            "temperature_correct", runner_temperature.drive, elf=RUNNER_TEMPERATURE
        ),
        "zupt": Case("zupt_update", runner_zupt.drive, elf=RUNNER_ZUPT),
        "zupt_gru": Case("zupt_gru_step", runner_zupt_gru.drive_steps, elf=RUNNER_ZUPT_GRU),
        "zupt_gru_update": Case("zupt_gru_update", runner_zupt_gru.drive, elf=RUNNER_ZUPT_GRU),
        **cases,
    }


CASES = _cases()
"""Key of the budget's [cycles] -> what is measured for it."""


def measure_runner(elf: Path = RUNNER, cases: dict[str, Case] = CASES) -> dict[str, Cost]:
    """Cost of each case; a whole call as the budget counts it."""
    cores, costs = {}, {}
    for key, case in cases.items():
        image = case.elf or elf
        if image not in cores:
            cores[image] = AvrCore(image)
        core = cores[image]
        if case.prepare:
            case.prepare(core)
        with core.profile([case.function]) as profile:
            case.drive(core)
        costs[key] = profile.figures.functions[case.function]
    return costs
