# SPDX-License-Identifier: MIT
"""Cycles of every module and variant on the chip: in the vector runner, and in the firmware.

The runner feeds each function data of every sort, so that its least and greatest cost are seen; in
the firmware, the functions cost what the weighing of one load makes them cost.
"""

from __future__ import annotations

import random
from pathlib import Path

from target_vectors.avr_core import AvrCore
from terazi.design import specs
from tools.measure import runner
from tools.measure.cycles import SCENARIOS, run_scenario
from tools.measure.runner import CASES, Case, fir_case, measure_runner, samples

SEED = 11
CALLS = 60


def _masses(core: AvrCore) -> None:
    rng = random.Random(SEED)
    for _ in range(CALLS):
        core.mass_mg(rng.randint(-(2**31), 2**31 - 1), rng.randint(0, 2**32 - 1))
    for net in (0, 1, -1, 2**31 - 1, -(2**31)):
        core.mass_mg(net, 2328 << 16)


def _frames(core: AvrCore) -> None:
    rng = random.Random(SEED)
    for length in range(0, 49, 6):
        payload = bytes(rng.choice((0, rng.randrange(256))) for _ in range(length))
        core.decode(core.encode(0x21, length, rng.randrange(2**32), payload))


def _filter(schedule: int) -> Case:
    return Case("weight_kf_update", lambda core: core.weight_kf(schedule, 0, samples()))


SHIPPED = {
    "fir32_generic": fir_case(0),
    **{
        f"weight_kf_{schedule['name']}": _filter(index)
        for index, schedule in enumerate(specs.weight_kf_schedules())
    },
    "mass": Case("mass_from_counts", _masses),
    "frame_encode": Case("frame_encode", _frames),
    "frame_decoder_push": Case("frame_decoder_push", _frames),
}
"""What the firmware calls, too, and the budget therefore measures there."""


def measure(image: Path) -> dict[str, dict]:
    """The `cycles` part: least, mean and most of each variant; the most of each in the firmware."""
    variants = {
        key: {
            "function": case.function,
            "min": cost.min_cycles,
            "mean": round(cost.mean_cycles, 1),
            "max": cost.max_cycles,
        }
        for cases in (SHIPPED, CASES)
        for (key, case), cost in zip(
            cases.items(), measure_runner(runner.RUNNER, cases).values(), strict=True
        )
    }
    firmware = run_scenario(image, SCENARIOS["weighing_80sps"]).cycles
    return {"variants": dict(sorted(variants.items())), "firmware_max": firmware}
