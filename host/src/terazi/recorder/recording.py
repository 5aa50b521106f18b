# SPDX-License-Identifier: MIT
"""A capture decoded: samples as columns, and everything else that the device said, in order."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from terazi.errors import CannotRead
from terazi.link.generated.messages import Hello, Sample, Status
from terazi.link.stream import MessageStream, Received
from terazi.recorder.capture import Capture
from terazi.recorder.columns import SampleColumns
from terazi.recorder.inertial import Inertial, InertialColumns


@dataclass
class Recording:
    """`samples` holds one numpy array a column (recorder.columns), `inertial` what the IMU told
    (recorder.inertial), `others` the rest."""

    path: Path
    metadata: dict
    samples: dict[str, np.ndarray]
    inertial: Inertial
    others: list[tuple[int, Received]] = field(default_factory=list)  # (samples before it, it)
    ended_cleanly: bool = False
    cut_off_bytes: int = 0
    duration_s: float = 0.0
    frames: int = 0
    frames_lost: int = 0
    frames_bad: int = 0

    def __len__(self) -> int:
        return len(self.samples["host_s"])

    @property
    def hello(self) -> Hello:
        """The first HELLO: every capture has one, because recording begins with it."""
        return self.of_kind(Hello)[0][1].message

    def of_kind(self, kind: type) -> list[tuple[int, Received]]:
        return [(at, one) for at, one in self.others if isinstance(one.message, kind)]

    @property
    def last_status(self) -> Status | None:
        found = self.of_kind(Status)
        return found[-1][1].message if found else None


def load_recording(path: Path, *, needs_samples: bool = True) -> Recording:
    """Read and decode a capture. Raises CannotRead, or FingerprintMismatch.

    needs_samples : False: one of a board without a scale will do, if its IMU has spoken.
    """
    capture = Capture(path)
    version = capture.metadata.get("version", "another version")
    stream = MessageStream(
        whose=str(path),
        remedy=f"It was recorded by terazi {version} from such a board; that version reads it.",
    )
    samples, inertial = SampleColumns(), InertialColumns()
    others: list[tuple[int, Received]] = []
    lost_before = 0
    for host_s, data in capture.chunks():
        for received in stream.feed(data, host_s):
            lost_before += received.lost_before
            if inertial.take(received):
                continue
            if isinstance(received.message, Sample):
                samples.append(received, lost_before)
                lost_before = 0
            else:
                inertial.tell(received)
                others.append((len(samples), received))
    recording = Recording(
        path=path,
        metadata=capture.metadata,
        samples=samples.to_numpy(),
        inertial=inertial.to_inertial(),
        others=others,
        ended_cleanly=capture.ended_cleanly,
        cut_off_bytes=capture.cut_off_bytes,
        duration_s=capture.duration_s,
        frames=stream.frames,
        frames_lost=stream.frames_lost,
        frames_bad=stream.frames_bad,
    )
    if not recording.of_kind(Hello):
        raise CannotRead(f"{path} holds no HELLO: nothing says what its numbers mean")
    if not len(recording) and (needs_samples or not len(recording.inertial)):
        remedy = (
            "`terazi attitude FILE` shows what its IMU told." if len(recording.inertial) else ""
        )
        raise CannotRead(f"{path} holds no samples", remedy=remedy)
    return recording
