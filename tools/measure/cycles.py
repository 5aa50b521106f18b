# SPDX-License-Identifier: MIT
"""Cycles, interrupts-off windows, load and painted stack of the firmware while it weighs.

The image runs in the virtual Uno, which counts every cycle; nothing is instrumented, so what is
measured is what ships. The load swings from rail to rail now and then, so that the clamps are
taken as well as the usual path.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from terazi.cshared import encode_frame
from terazi.link.generated.messages import (
    CalibrateAbort,
    CalibrateBegin,
    CalibrateEnd,
    CalibrateKnown,
    CalibratePoint,
    CountPieces,
    GetInfo,
    GetPoint,
    GetSetting,
    ResetCounts,
    ResetSettings,
    ResetWhat,
    SaveSettings,
    SetSetting,
    Show,
    Tare,
    TareClear,
    Unit,
    View,
    Zero,
)
from terazi.link.generated.settings import SettingKey
from virtual_uno import Uno
from virtual_uno.motion import read_motion
from virtual_uno.uno import RAM_END

RATE_SPS = 80.0
WARM_UP_S = 1.5  # settling and the first STATUS
RUN_S = 12.0
STEP_S = 1.0
COMMAND_S = 0.05
READ_FUNCTION = "hx711_read"
ZUPT_GRU = 5  # of imu.zupt

# Figure -> function of the image. What one call does is said in its header.
FUNCTIONS = {"hx711_read": READ_FUNCTION}


@dataclass(frozen=True)
class Run:
    """What one scenario cost."""

    cpu_load: float  # 0..1, share of cycles awake
    cycles: dict[str, int]  # the longest call of each function
    isr_cycles_max: int
    irq_off_cycles_max: int  # outside handlers and outside the read
    irq_off_where: str
    hx711_irq_off_cycles_max: int
    stack_painted_bytes: int


def load_counts(t_s: np.ndarray) -> np.ndarray:
    """A swinging load that stands on each rail once in five seconds."""
    swing = 4e6 * np.sin(2 * np.pi * 0.7 * t_s)
    jolt = np.select([t_s % 5 < 0.1, t_s % 5 > 4.9], [2.0**24, -(2.0**24)], default=0.0)
    return swing + jolt


def stream_frames(uno: Uno) -> None:
    uno.run(RUN_S)


def stream_text(uno: Uno) -> None:
    uno.uart.write(b"text\n")
    uno.run(RUN_S)


COMMANDS = [
    GetInfo(),
    SetSetting(SettingKey.SCALE_UNIT, Unit.KG),
    SetSetting(SettingKey.SCALE_DECIMALS, 3),
    SetSetting(SettingKey.CHECKWEIGHER_ON, 1),
    SetSetting(SettingKey.TEMPERATURE_SPAN_PPM_PER_K_Q4, 800),
    SetSetting(SettingKey.TEMPERATURE_ON, 1),
    *(GetSetting(key) for key in SettingKey),
    Zero(),
    Tare(),
    CountPieces(7),
    Show(View.PEAK),
    CalibrateBegin(),
    *(CalibrateKnown(-(n**3) * 1_000_000, n * 40_000_000) for n in (8, 1, 7, 2, 6, 3, 5, 4)),
    CalibratePoint(0),
    GetPoint(7),
    CalibrateEnd(),
    ResetCounts(),
    SaveSettings(),
    CalibrateBegin(),
    CalibrateAbort(),
    TareClear(),
    ResetSettings(ResetWhat.ALL_BUT_CALIBRATION),
]


def command(uno: Uno) -> None:
    """Every command, some at a bad time; a whole calibration, a change of units, two saves."""
    for sequence, message in enumerate(COMMANDS):
        uno.uart.write(encode_frame(message.ID, sequence % 256, 0, message.pack()))
        uno.run(COMMAND_S)
    uno.run(STEP_S)


def pass_products(uno: Uno) -> None:
    """Products over a checkweigher, among them one that is not weighed."""
    for key, value in (("ON", 1), ("CLASSES", 2), ("LIMIT_MG_0", 400_000)):
        message = SetSetting(SettingKey[f"CHECKWEIGHER_{key}"], value)
        uno.uart.write(encode_frame(message.ID, 0, 0, message.pack()))
        uno.run(COMMAND_S)
    uno.load(grams=lambda t_s: np.where(t_s % 0.5 < 0.3, 500.0 * (t_s % 3.0 < 2.4) + 20.0, 0.0))
    uno.run(RUN_S)


def exercise(uno: Uno) -> None:
    """Words, noise on the line and a converter that goes away: the paths off the usual one."""
    for words in (b"info\n", b"tare\n", b"nonsense\n", b"\x00noise\x00" * 4, b"text\ninfo\n"):
        uno.uart.write(words)
        uno.run(STEP_S)
    uno.fault("dout_high")
    uno.run(STEP_S)
    uno.clear_faults()
    uno.run(STEP_S)
    uno.uart.write(b"frames\n")
    uno.run(STEP_S)


def _put(uno: Uno, key: SettingKey, value: int) -> None:
    message = SetSetting(key, value)
    uno.uart.write(encode_frame(message.ID, 0, 0, message.pack()))
    uno.run(COMMAND_S)


def fit_imu(uno: Uno) -> None:
    """An IMU that is moved, at 500 Hz; ATTITUDE 100 times a second, at 115 200 baud."""
    motion = read_motion("rocking")
    uno.imu.fit().noise()
    uno.imu.feel(acc_g=motion.acc_g, gyro_deg_s=motion.gyro_deg_s)
    uno.run(STEP_S)


def fit_fast_imu(uno: Uno) -> None:
    """At 1 kHz; ATTITUDE 200 times a second, at 500 000 baud."""
    fit_imu(uno)
    _put(uno, SettingKey.IMU_MODE, 2)
    _put(uno, SettingKey.UART_BAUD, 1)
    uno.uart.write(encode_frame(SaveSettings.ID, 0, 0, b""))
    uno.run(STEP_S)
    uno.reset()


def fit_foot(uno: Uno) -> None:
    """At 1 kHz, with the learnt detector."""
    fit_imu(uno)
    _put(uno, SettingKey.IMU_ZUPT, ZUPT_GRU)
    fit_fast_imu(uno)


def fit_magnetometer(uno: Uno) -> None:
    """The same with a field."""
    uno.mag.fit("qmc5883l").feel(read_motion("rocking").field_ut)
    fit_fast_imu(uno)


@dataclass(frozen=True)
class Scenario:
    """What is measured, and what comes before it."""

    run: Callable[[Uno], None]
    prepare: Callable[[Uno], None] = lambda _uno: None


# The name of a scenario is its key in cpu_load.
SCENARIOS = {
    "weighing_80sps": Scenario(stream_frames),
    "weighing_80sps_text": Scenario(stream_text),
    "attitude_500hz": Scenario(stream_frames, fit_imu),
    "attitude_1khz": Scenario(stream_frames, fit_fast_imu),
    "attitude_1khz_mag": Scenario(stream_frames, fit_magnetometer),
    "attitude_1khz_gru": Scenario(stream_frames, fit_foot),
    "command": Scenario(command, fit_imu),
    "pass_products": Scenario(pass_products, fit_fast_imu),
    "exercise": Scenario(exercise, fit_imu),
}


def run_scenario(elf: Path, scenario: Scenario) -> Run:
    uno = Uno(elf, rate_sps=RATE_SPS, noise_counts=40.0)
    uno.load(counts=load_counts)
    scenario.prepare(uno)
    uno.run(WARM_UP_S)
    uno.paint_stack()
    with uno.profile(FUNCTIONS.values()) as profile:
        scenario.run(uno)
    figures = profile.figures
    reads, others = [], []  # the longest come first
    for window in figures.windows:
        inside_read = window.begin.split("+")[0] == READ_FUNCTION
        (reads if inside_read else others).append(window)
    return Run(
        cpu_load=figures.cpu_load,
        cycles={key: figures.functions[name].max_cycles for key, name in FUNCTIONS.items()},
        isr_cycles_max=max(cost.max_cycles for cost in figures.handlers.values()),
        irq_off_cycles_max=others[0].max_cycles,
        irq_off_where=others[0].begin,
        hx711_irq_off_cycles_max=reads[0].max_cycles,
        stack_painted_bytes=RAM_END + 1 - uno.symbol("_end") - uno.stack_free(),
    )
