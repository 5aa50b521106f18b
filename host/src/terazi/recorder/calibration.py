# SPDX-License-Identifier: MIT
"""Which tare and span held when, as far as a recording can tell."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from terazi.link.generated.messages import Ack, Hello, Result, Tare
from terazi.recorder.chain import chain_of, last_counts_q7
from terazi.recorder.recording import Recording

CONVERSION_PERIOD = 1 << 16


@dataclass(frozen=True)
class Calibration:
    """One value a sample. Where is_certain is false, the values are the likeliest."""

    tare_counts_q7: np.ndarray  # (n,) int64
    span_ug_per_count_q16: np.ndarray  # (n,) int64
    is_certain: np.ndarray  # (n,) bool

    def stretches(self) -> list[tuple[int, int]]:
        """[begin, end) of samples with one tare, one span and one certainty."""
        changes = np.zeros(len(self.tare_counts_q7), bool)
        for column in (self.tare_counts_q7, self.span_ug_per_count_q16, self.is_certain):
            changes[1:] |= column[1:] != column[:-1]
        cuts = [0, *np.flatnonzero(changes).tolist(), len(changes)]
        return [(begin, end) for begin, end in pairwise(cuts) if begin < end]


def calibration_of(recording: Recording) -> Calibration:
    """Follow HELLOs and acknowledged tare commands through a recording.

    A tare takes what the chain ends with, which is that of the last sample before the ACK.
    Where a frame is missing that was no sample, it may have been such an ACK: from there to the
    next HELLO nothing is certain.
    """
    count = len(recording)
    tare_q7 = np.full(count, recording.hello.tare_counts_q7, np.int64)
    span_q16 = np.full(count, recording.hello.span_ug_per_count_q16, np.int64)
    is_certain = np.zeros(count, bool)
    chain = chain_of(recording)
    last_q7 = last_counts_q7(recording, chain)
    losses = [at for at in _unexplained_losses(recording) if not _hello_after_loss(recording, at)]
    events = [*recording.others, *((at, None) for at in losses)]
    for at, received in sorted(events, key=lambda event: event[0]):  # stable: losses come last
        message = received and received.message
        if isinstance(message, Hello):
            tare_q7[at:] = message.tare_counts_q7
            span_q16[at:] = message.span_ug_per_count_q16
            is_certain[at:] = True
        elif _is_tare(message):
            if at:
                tare_q7[at:] = last_q7[at - 1]
            is_certain[at:] &= at > 0 and received.lost_before == 0 and chain.is_certain[at - 1]
        elif message is None:
            is_certain[at:] = False
    return Calibration(tare_q7, span_q16, is_certain)


def _is_tare(message) -> bool:
    """Whether this says that the device has taken its present weight as zero load."""
    return isinstance(message, Ack) and (message.command, message.result) == (Tare.ID, Result.OK)


def _unexplained_losses(recording: Recording) -> list[int]:
    """Samples before which more frames are missing than conversions."""
    samples = recording.samples
    conversion = samples["conversion"].astype(np.int64)
    missing = (np.diff(conversion, prepend=conversion[:1] - 1) - 1) % CONVERSION_PERIOD
    return np.flatnonzero(samples["lost_before"] > missing).tolist()


def _hello_after_loss(recording: Recording, at: int) -> bool:
    """Whether all that is missing before sample `at` was missing before a HELLO already."""
    between = [received for place, received in recording.others if place == at]
    lost_after = recording.samples["lost_before"][at] - sum(one.lost_before for one in between)
    for received in reversed(between):
        if lost_after:
            return False
        if isinstance(received.message, Hello):
            return True
        lost_after += received.lost_before
    return False
