# SPDX-License-Identifier: MIT
"""Recorded raw counts once more through the firmware's C and through the float models.

What the device answered must be what its C answers here, bit for bit, and must lie within the
error budget around what the mathematics say.
"""

from terazi.replay.compare import Replay, replay
from terazi.replay.segments import Segment, segments_of
from terazi.replay.stage import StageResult

__all__ = ["Replay", "Segment", "StageResult", "replay", "segments_of"]
