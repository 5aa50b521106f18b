# SPDX-License-Identifier: MIT
"""Which calibration held when, as far as a recording can tell."""

from dataclasses import dataclass

import numpy as np

from terazi.link.generated.messages import (
    Ack,
    CalibrateAbort,
    CalibrateBegin,
    CalibrateEnd,
    Point,
    ResetSettings,
    Result,
)
from terazi.link.stream import Received
from terazi.recorder.recording import Recording

CONVERSION_PERIOD = 1 << 16
CHANGES = (CalibrateEnd.ID, ResetSettings.ID)


@dataclass(frozen=True)
class Stretch:
    """Samples [begin, end) of one calibration. points: (counts_q7, mass_mg); None: not known."""

    begin: int
    end: int
    points: tuple[tuple[int, int], ...] | None


def calibration_of(recording: Recording) -> list[Stretch]:
    """Follow the POINTs of a recording, which tell a calibration once it holds.

    A calibration holds from a start of the device, an acknowledged CALIBRATE_END or RESET_SETTINGS
    on, and what is told of it later holds from there. Where a frame is missing that was no sample,
    it may have been such an ACK: from there on it must be told anew.
    """
    begin, boot, is_staged = 0, recording.others[0][1].boot if recording.others else 0, False
    told: dict[int, tuple[int, int]] = {}
    stretches = []
    for at, received in _with_losses(recording):
        message = received and received.message
        is_done = isinstance(message, Ack) and message.result == Result.OK
        starts = received is not None and received.boot != boot
        if received is None or starts or (is_done and message.command in CHANGES):
            if at > begin:
                stretches.append(Stretch(begin, at, _points(told)))
            begin, told = at, {}
        if starts:
            boot, is_staged = received.boot, False
        if is_done and message.command in (CalibrateBegin.ID, CalibrateAbort.ID, CalibrateEnd.ID):
            is_staged = message.command == CalibrateBegin.ID
        elif isinstance(message, Point) and not is_staged:
            told[message.index] = (message.counts_q7, message.mass_mg)
    if len(recording) > begin:
        stretches.append(Stretch(begin, len(recording), _points(told)))
    return stretches


def _points(told: dict[int, tuple[int, int]]) -> tuple[tuple[int, int], ...] | None:
    """In their order; None where some are missing."""
    if len(told) < 2 or sorted(told) != list(range(len(told))):
        return None
    return tuple(told[index] for index in range(len(told)))


def _with_losses(recording: Recording) -> list[tuple[int, Received | None]]:
    """What was said besides samples; None where something that was no sample may be missing."""
    events = list(recording.others)
    for at in reversed(_unexplained_losses(recording)):
        end = sum(place <= at for place, _one in recording.others)
        begin = sum(place < at for place, _one in recording.others)
        lost = [one.lost_before for _place, one in recording.others[begin:end]]
        place = end  # just before the sample, or else before what came after the last loss
        if recording.samples["lost_before"][at] == sum(lost):
            place = begin + max(n for n, count in enumerate(lost) if count)
        events.insert(place, (at, None))
    return events


def _unexplained_losses(recording: Recording) -> list[int]:
    """Samples before which more frames are missing than conversions."""
    samples = recording.samples
    conversion = samples["conversion"].astype(np.int64)
    missing = (np.diff(conversion, prepend=conversion[:1] - 1) - 1) % CONVERSION_PERIOD
    return np.flatnonzero(samples["lost_before"] > missing).tolist()
