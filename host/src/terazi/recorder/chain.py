# SPDX-License-Identifier: MIT
"""Which order of filters and which Kalman filter made each sample, as far as a recording tells."""

from dataclasses import dataclass

import numpy as np

from terazi.link.generated.messages import (
    Ack,
    ChainOrder,
    Hello,
    KfKind,
    ResetSettings,
    Result,
    Setting,
)
from terazi.link.generated.settings import SettingKey
from terazi.recorder.recording import Recording


@dataclass(frozen=True)
class Chain:
    """One value a sample. Where is_certain is false, the values are the last that were told."""

    order: np.ndarray  # (n,) ChainOrder
    kf_kind: np.ndarray  # (n,) KfKind
    is_certain: np.ndarray  # (n,) bool

    def at(self, sample: int) -> tuple[int, int] | None:
        """Order and kind at a sample; None where they are not certain."""
        if not self.is_certain[sample]:
            return None
        return int(self.order[sample]), int(self.kf_kind[sample])


def chain_of(recording: Recording) -> Chain:
    """Follow HELLO, which tells both, and SETTING where it tells the order.

    The device takes it up with the next sample. Where all settings were reset, nothing is certain
    until they are told anew.
    """
    count, first = len(recording), recording.hello
    order = np.full(count, first.chain_order, np.uint8)
    kf_kind = np.full(count, first.kf_kind, np.uint8)
    is_certain = np.ones(count, bool)
    for at, received in recording.others:
        message = received.message
        if isinstance(message, Hello):
            order[at:], kf_kind[at:] = message.chain_order, message.kf_kind
            is_certain[at:] = True
        elif isinstance(message, Setting) and message.key == SettingKey.CHAIN_ORDER:
            order[at:] = message.value
        elif isinstance(message, Ack) and (message.command, message.result) == (
            ResetSettings.ID,
            Result.OK,
        ):
            is_certain[at:] = False
    known = (order <= max(ChainOrder)) & (kf_kind <= max(KfKind))
    return Chain(order, kf_kind, is_certain & known)


def last_counts_q7(recording: Recording, chain: Chain) -> np.ndarray:
    """(n,) int64: what the chain ended with, counts in Q7; the mass is of this."""
    fir_q7 = recording.samples["fir_counts"].astype(np.int64) * 128
    kf_q7 = recording.samples["kf_counts_q7"].astype(np.int64)
    return np.where(chain.order == ChainOrder.KF_FIR, fir_q7, kf_q7)
