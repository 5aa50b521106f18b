# SPDX-License-Identifier: MIT
"""Tables beside a capture: NAME.csv, NAME.parquet, NAME.status.csv and NAME.events.csv; where an
IMU is, NAME.attitude.csv, NAME.imu.csv and NAME.mag.csv, each as Parquet too, and
NAME.imu_status.csv.

They are made while recording, block by block, so that a recording of a week needs no more memory
than one of a minute; or afterwards from the capture, with the same result. A table that cannot be
written is given up with a word on why; the capture goes on.
"""

import contextlib
import csv
import dataclasses
import functools
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np

from terazi.errors import CannotWrite
from terazi.link.generated.messages import Fault, ImuStatus, Product, Status, Step
from terazi.link.plain import plain_message
from terazi.link.stream import Received
from terazi.recorder.columns import SampleColumns, table_of
from terazi.recorder.files import cannot_write
from terazi.recorder.inertial import KINDS, MessageColumns, table_of_kind

CSV_BLOCK_SAMPLES = 64  # so that what reads along is less than a second behind
PARQUET_BLOCK_SAMPLES = 16384  # a row group

PARQUET_REMEDY = "Parquet is not written: pyarrow is not installed (pip install pyarrow)"

EVENTS = (Step, Product, Fault)

CSV_FORMATS = {"host_s": "{:.6f}", "kf_counts": "{:.7f}", "mass_g": "{:.3f}", "weight_g": "{:.3f}"}
CSV_FORMATS |= {"device_s": "{:.6f}"} | {f"quat_{axis}": "{:.10f}" for axis in "wxyz"}
CSV_FORMATS |= {f"{angle}_deg": "{:.5f}" for angle in ("roll", "pitch", "yaw")}
CSV_FORMATS |= {f"acc_{axis}_m_s2": "{:.5f}" for axis in "xyz"}
CSV_FORMATS |= {f"gyro_{axis}_deg_s": "{:.4f}" for axis in "xyz"} | {"temperature_deg_c": "{:.3f}"}


def table_paths(capture: Path) -> dict[str, Path]:
    """Where the tables of a capture lie."""
    paths = {
        "csv": capture.with_suffix(".csv"),
        "status": capture.with_suffix(".status.csv"),
        "events": capture.with_suffix(".events.csv"),
        "parquet": capture.with_suffix(".parquet"),
        "imu_status": capture.with_suffix(".imu_status.csv"),
    }
    for kind in KINDS:
        for ending in ("csv", "parquet"):
            paths[f"{kind.NAME}.{ending}"] = capture.with_suffix(f".{kind.NAME}.{ending}")
    return paths


class CsvTable:
    """NAME.csv: one line a sample."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file = open(path, "w", newline="", encoding="utf-8")  # noqa: SIM115 - own close
        self._names: list[str] = []

    def write(self, table: dict[str, np.ndarray]) -> None:
        if not self._names:
            self._names = list(table)
            self._file.write(",".join(self._names) + "\n")
        columns = [
            map(CSV_FORMATS.get(name, "{}").format, column.tolist())
            for name, column in table.items()
        ]
        self._file.writelines(",".join(row) + "\n" for row in zip(*columns, strict=True))
        self._file.flush()

    def close(self) -> None:
        self._file.close()

    def give_up(self) -> None:
        """Close, and keep what could be written."""
        with contextlib.suppress(OSError):
            self._file.close()


class ParquetTable:
    """NAME.parquet. It has no meaning before its end is written: until then NAME.parquet.part."""

    def __init__(self, path: Path, metadata: dict) -> None:
        import pyarrow
        import pyarrow.parquet

        self.path = path
        self._arrow = pyarrow
        self._part = path.with_name(path.name + ".part")
        self._metadata = {key: str(value) for key, value in metadata.items()}
        self._writer = None
        self._file = open(self._part, "wb")  # noqa: SIM115 - own close

    def write(self, table: dict[str, np.ndarray]) -> None:
        block = self._arrow.table(table).replace_schema_metadata(self._metadata)
        if self._writer is None:
            self._writer = self._arrow.parquet.ParquetWriter(self._file, block.schema)
        self._writer.write_table(block)

    def close(self) -> None:
        if self._writer is not None:
            self._writer.close()
        self._file.close()
        os.replace(self._part, self.path)

    def give_up(self) -> None:
        """Close and remove: a Parquet file without its end cannot be read."""
        with contextlib.suppress(OSError):
            self._file.close()
        self._part.unlink(missing_ok=True)


class MessageTable:
    """One line a message, with rates in Hz. Made when the first one comes.

    names : columns after the clocks; None: those of the first message. What a message has not is
        left empty.
    """

    def __init__(self, path: Path, names: list[str] | None = None) -> None:
        self.path = path
        self._names = names
        self._file = None

    def write(self, received: Received) -> None:
        row = {
            "host_s": f"{received.host_s:.6f}",
            "device_us": received.device_us,
            "boot": received.boot,
            "message": type(received.message).__name__.lower(),
        } | plain_message(received.message)
        if self._names is None:
            del row["message"]  # all of one kind
        if self._file is None:
            columns = [*row] if self._names is None else [*list(row)[:4], *self._names]
            self._file = open(self.path, "w", newline="", encoding="utf-8")  # noqa: SIM115
            self._rows = csv.DictWriter(self._file, columns, lineterminator="\n")
            self._rows.writeheader()
        self._rows.writerow(row)
        self._file.flush()

    @property
    def is_begun(self) -> bool:
        return self._file is not None

    def close(self) -> None:
        self._file.close()


def _event_columns() -> list[str]:
    """Fields of all events, each once."""
    names = (field.name for kind in EVENTS for field in dataclasses.fields(kind))
    return list(dict.fromkeys(names))


class Tables:
    """All tables of one recording. Nothing here raises: `faults` says what went wrong."""

    def __init__(self, capture: Path, metadata: dict) -> None:
        self.faults: list[CannotWrite] = []
        self.notes: list[str] = []
        self.written: list[Path] = []
        self._metadata = metadata
        self._paths = paths = table_paths(capture)
        self._has_parquet = has_parquet()
        if not self._has_parquet:
            self.notes.append(PARQUET_REMEDY)
        self._samples = self._open("csv", "parquet", SampleColumns, table_of)
        self._kinds: dict[type, list[_Output]] = {}  # of those of KINDS that came
        self._messages = [
            (MessageTable(paths["status"]), (Status,)),
            (MessageTable(paths["events"], _event_columns()), EVENTS),
            (MessageTable(paths["imu_status"]), (ImuStatus,)),
        ]
        # Of an older recording under this name; made only where such messages come.
        late = [table.path for table, _kinds in self._messages]
        late += [paths[f"{kind.NAME}.{ending}"] for kind in KINDS for ending in ("csv", "parquet")]
        for path in late:
            with contextlib.suppress(OSError):
                path.unlink()

    def add_sample(self, received: Received, lost_before: int) -> None:
        self._add(self._samples, received, lost_before)

    def add_message(self, received: Received) -> None:
        """Take anything but a sample; what has no table is in the capture only."""
        kind = type(received.message)
        if kind in KINDS:
            if kind not in self._kinds:
                self._kinds[kind] = self._open(
                    f"{kind.NAME}.csv",
                    f"{kind.NAME}.parquet",
                    lambda: MessageColumns(kind),
                    lambda columns: table_of_kind(kind, columns),
                )
            self._add(self._kinds[kind], received)
        for table, kinds in list(self._messages):
            if not isinstance(received.message, kinds):
                continue
            try:
                table.write(received)
            except OSError as error:
                self.faults.append(cannot_write(table.path, error))
                self._messages.remove((table, kinds))

    def close(self) -> None:
        groups = [self._samples, *self._kinds.values()]
        for outputs in groups:
            for output in list(outputs):
                self._try(outputs, output, output.finish)
        self.written = [output.table.path for output in self._samples]
        for table, _kinds in self._messages:
            if table.is_begun:
                table.close()
                self.written.append(table.path)
        self.written += [output.table.path for outputs in groups[1:] for output in outputs]
        for outputs in groups:
            outputs.clear()

    def _open(self, csv_name: str, parquet_name: str, columns: Callable, shown: Callable) -> list:
        """CSV and, where it can be had, Parquet; those that could be opened."""
        outputs: list[_Output] = []
        made: list[tuple[str, Callable, int]] = [(csv_name, CsvTable, CSV_BLOCK_SAMPLES)]
        if self._has_parquet:
            make = functools.partial(ParquetTable, metadata=self._metadata)
            made.append((parquet_name, make, PARQUET_BLOCK_SAMPLES))
        for name, make, block_rows in made:
            path = self._paths[name]
            try:
                outputs.append(_Output(make(path), block_rows, columns, shown))
            except OSError as error:
                self.faults.append(cannot_write(path, error))
        return outputs

    def _add(self, outputs: "list[_Output]", *what) -> None:
        for output in list(outputs):
            output.waiting.append(*what)
            if len(output.waiting) >= output.block_rows:
                self._try(outputs, output, output.write_waiting)

    def _try(self, outputs: "list[_Output]", output: "_Output", action: Callable) -> None:
        try:
            action()
        except OSError as error:
            self.faults.append(cannot_write(output.table.path, error))
            outputs.remove(output)
            output.table.give_up()


class _Output:
    """A table and the rows that wait for its next block.

    columns : makes an empty collection of rows;  shown : what the table has of its arrays.
    """

    def __init__(
        self, table: CsvTable | ParquetTable, block_rows: int, columns: Callable, shown: Callable
    ) -> None:
        self.table = table
        self.block_rows = block_rows
        self.waiting = columns()
        self._columns, self._shown = columns, shown
        self._is_empty = True

    def write_waiting(self) -> None:
        block = self._shown(self.waiting.to_numpy())
        self.waiting = self._columns()
        self._is_empty = False
        self.table.write(block)

    def finish(self) -> None:
        if len(self.waiting) or self._is_empty:  # an empty table still names its columns
            self.write_waiting()
        self.table.close()


def has_parquet() -> bool:
    """Whether pyarrow is there. Importing it takes a moment: better before a board is opened."""
    try:
        import pyarrow.parquet  # noqa: F401
    except ImportError:
        return False
    return True
