# SPDX-License-Identifier: MIT
"""What a board's stream takes of its line, and what to change where that is too much."""

from collections.abc import Mapping

from terazi.link.generated.messages import Attitude, Imu, ImuStatus, Sample, Status, Weight
from terazi.link.transport import BAUDS

FRAME_BYTES = 10  # beside the payload: head of 6, check of 2, COBS and its end (frame.h)
BITS_PER_BYTE = 10
SAMPLES_PER_S, WEIGHTS_PER_S = 94, 12  # the HX711 at its fastest; 10 and changes of flags
LINE_SHARE = 0.85  # more than this leaves no room for answers and a magnetometer
RATES_HZ = {"hz_500": 500, "hz_1000": 1000}


def bytes_per_s(imu_rate_hz: float, every: int) -> float:
    """Of everything that `terazi log --imu` switches on, but a magnetometer's."""
    rates = {Sample: SAMPLES_PER_S, Weight: WEIGHTS_PER_S, Status: 1, ImuStatus: 1}
    rates |= {Imu: imu_rate_hz / every, Attitude: imu_rate_hz / every}
    return sum((kind.LEN + FRAME_BYTES) * rate for kind, rate in rates.items())


def baud_for(imu_rate_hz: float, every: int) -> int | None:
    """The lowest rate of the line that will do; None if none does."""
    bits_per_s = bytes_per_s(imu_rate_hz, every) * BITS_PER_BYTE
    return next((baud for baud in BAUDS if bits_per_s <= LINE_SHARE * baud), None)


def imu_advice(settings: Mapping[str, int], baud: int | None) -> list[str]:
    """What keeps a recording of raw IMU samples from being whole, each with its remedy.

    settings : by full name; baud: of the line, None where there is none.
    """
    from terazi.link.generated.settings import SETTINGS_BY_NAME

    modes = {number: name for name, number in SETTINGS_BY_NAME["imu.mode"].choices}
    rate_hz = RATES_HZ.get(modes.get(settings["imu.mode"], ""))
    if rate_hz is None:
        return ["The IMU is off or testing itself: `terazi set imu.mode=hz_500` switches it on."]
    every, advice = settings["imu.every"], []
    needed = baud_for(rate_hz, every)
    if baud is not None and (needed is None or needed > baud):
        remedy = f"terazi set uart.baud={needed}" if needed else "terazi set imu.every=5"
        advice.append(
            f"One in {every} samples at {rate_hz} Hz is more than {baud} baud can carry: frames "
            f"will be lost. `{remedy}` makes room."
        )
    if every != 1:
        advice.append(
            f"One in {every} samples is recorded; a replay of the attitude needs all: "
            "`terazi set imu.every=1`."
        )
    return advice
