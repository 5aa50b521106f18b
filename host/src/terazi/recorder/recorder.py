# SPDX-License-Identifier: MIT
"""Records one conversation: capture and tables together, whatever ends it."""

import os
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from pathlib import Path

from terazi import __version__
from terazi.errors import CannotWrite, UsageError
from terazi.link.generated.messages import FINGERPRINT, Attitude, Imu, Sample, SampleFlag
from terazi.link.stream import MessageStream, Received
from terazi.recorder.capture import CaptureWriter
from terazi.recorder.files import cannot_write
from terazi.recorder.tables import Tables, has_parquet, table_paths

CONVERSION_PERIOD = 1 << 16


@dataclass
class Summary:
    """What a recording came to."""

    path: Path
    size_bytes: int
    duration_s: float
    samples: int
    frames_lost: int
    frames_bad: int
    conversions_lost: int
    restarts: int
    imu_samples: int = 0
    attitudes: int = 0
    tables: list[Path] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    faults: list[CannotWrite] = field(default_factory=list)


class Recorder:
    """Takes bytes and messages, writes capture and tables.

    Bytes that come before `begin` are kept and become the capture's first records, so that the
    HELLO is in it. Give `on_bytes` to the link. After CannotWrite from there, call `finish`.
    """

    def __init__(self, path: Path, *, overwrite: bool = False) -> None:
        if path.suffix in (".csv", ".parquet"):
            raise UsageError(
                f"{path} would be the raw capture's name",
                remedy=f"CSV and Parquet are written beside it: -o {path.with_suffix('.terazi')}",
            )
        if not overwrite:
            for table in table_paths(path).values():
                if os.path.lexists(table):
                    raise cannot_write(table, FileExistsError())
        has_parquet()  # the import takes a moment, in which a board would already be sending
        self._writer = CaptureWriter(path, overwrite=overwrite)
        self._early: list[tuple[float, bytes]] = []
        self._tables: Tables | None = None
        self._lost_before = 0
        self._conversion: int | None = None
        self._last_host_s = 0.0
        self._write_fault: CannotWrite | None = None
        self.samples = self.imu_samples = self.attitudes = 0
        self.conversions_lost = 0

    def on_bytes(self, host_s: float, data: bytes) -> None:
        """Record bytes. Raises CannotWrite when the capture cannot grow."""
        self._last_host_s = host_s
        if self._tables is None:
            self._early.append((host_s, data))
            return
        try:
            self._writer.append(host_s, data)
        except CannotWrite as error:
            self._write_fault = error
            raise

    def forget(self) -> None:
        """What came so far is of another conversation; only before `begin`."""
        self._early.clear()

    def begin(self, *, port: str, baud: int, age_s: float) -> None:
        """Write the header and what came so far. age_s: how long ago host_s was zero."""
        started = datetime.now(UTC) - timedelta(seconds=age_s)
        metadata = {
            "product": "terazi",
            "version": __version__,
            "protocol_fingerprint": f"0x{FINGERPRINT:04X}",
            "started": started.isoformat(timespec="milliseconds"),
            "port": port,
            "baud": baud,
        }
        self._begin_s = age_s
        self._writer.begin(metadata)
        for host_s, data in self._early:
            self._writer.append(host_s, data)
        self._early.clear()
        self._tables = Tables(self._writer.path, metadata)

    def add(self, received: Received) -> None:
        """Take a decoded message into the tables."""
        self._lost_before += received.lost_before
        message = received.message
        if isinstance(message, Sample):
            self.samples += 1
            self._count_conversions(message)
            self._tables.add_sample(received, self._lost_before)
            self._lost_before = 0
        else:
            self.imu_samples += isinstance(message, Imu)
            self.attitudes += isinstance(message, Attitude)
            self._tables.add_message(received)

    def finish(self, stream: MessageStream, host_s: float | None = None) -> Summary:
        """Bring everything to disk and say what there is. Never raises for a full disk."""
        end_s = self._last_host_s if host_s is None else host_s
        faults = [self._write_fault] if self._write_fault else []
        if self._write_fault:
            self._writer.abandon()
        else:
            try:
                self._writer.close(end_s)
            except CannotWrite as error:
                faults.append(error)
        self._tables.close()
        return Summary(
            path=self._writer.path,
            size_bytes=self._writer.size_bytes,
            duration_s=end_s - self._begin_s,
            samples=self.samples,
            frames_lost=stream.frames_lost,
            frames_bad=stream.frames_bad,
            conversions_lost=self.conversions_lost,
            restarts=stream.boot,
            imu_samples=self.imu_samples,
            attitudes=self.attitudes,
            tables=self._tables.written,
            notes=self._tables.notes,
            faults=faults + self._tables.faults,
        )

    def abandon(self) -> None:
        """There was nothing to record: leave no trace."""
        self._writer.abandon()

    def _count_conversions(self, sample: Sample) -> None:
        """Conversions that never reached us; those dropped while settling are not lost."""
        if self._conversion is not None and not sample.flags & SampleFlag.RESTARTED:
            step = (sample.conversion - self._conversion) % CONVERSION_PERIOD
            self.conversions_lost += step - 1
        self._conversion = sample.conversion
