# SPDX-License-Identifier: MIT
"""The capture file: every byte that came in, with the host's time. It survives a crash.

    TERAZI-CAPTURE 1\\n
    {metadata as one line of JSON}\\n
    records: host_s f64 | length u32 | bytes      (little-endian)

host_s counts from `started` in the metadata. A record of length 0 is the clean end. A file that
stops without one was cut off, by a crash or a full disk: everything up to its last whole record
counts. Records are written without buffering, so that what was recorded is in the system's hands.
"""

import contextlib
import errno
import json
import math
import os
import struct
from collections.abc import Iterator
from pathlib import Path

from terazi.errors import CannotRead, CannotWrite
from terazi.recorder.files import cannot_read, cannot_write

MAGIC = b"TERAZI-CAPTURE "
FORMAT = 1
RECORD_HEAD = struct.Struct("<dI")
RECORD_MAX = 1 << 20  # no read of a port brings this much; a larger length is damage
HEADER_MAX = 1 << 16


class CaptureWriter:
    """Writes one capture. Made, then begun with the metadata, fed, and closed or abandoned.

    Making it takes the name, so that an unwritable folder shows before a board is disturbed;
    an older file of that name stays as it was until `begin`.
    """

    def __init__(self, path: Path, *, overwrite: bool = False) -> None:
        self.path = path
        self.size_bytes = 0  # of whole records and header
        self._begun = False
        self._is_new = not os.path.lexists(path)
        flags = os.O_WRONLY | os.O_CREAT | getattr(os, "O_BINARY", 0)
        try:
            self._file = os.open(path, flags if overwrite else flags | os.O_EXCL, 0o644)
        except OSError as error:
            raise cannot_write(path, error) from error

    def begin(self, metadata: dict) -> None:
        """Write the header; what the file held before is gone."""
        self._truncate(0)
        self._begun = True
        line = json.dumps(metadata, ensure_ascii=False)
        self._write(MAGIC + b"%d\n" % FORMAT + line.encode() + b"\n")

    def append(self, host_s: float, data: bytes) -> None:
        """Write one record. After CannotWrite the file ends with the record before."""
        if data:
            self._write(RECORD_HEAD.pack(host_s, len(data)) + data)

    def close(self, host_s: float) -> None:
        """End cleanly, and see to it that all of it is on the disk."""
        try:
            self._write(RECORD_HEAD.pack(host_s, 0))
            self._sync()
        finally:
            self._close()

    def abandon(self) -> None:
        """Close without an end mark. A file that holds nothing leaves no trace."""
        if self._file < 0:
            return
        if self._begun:
            with contextlib.suppress(CannotWrite):  # the fault that led here has been told
                self._sync()
        self._close()
        if self._is_new and not self.size_bytes:
            self.path.unlink(missing_ok=True)

    def _write(self, data: bytes) -> None:
        rest = memoryview(data)
        try:
            while rest:
                rest = rest[os.write(self._file, rest) :]
        except OSError as error:
            self._truncate(self.size_bytes)
            raise cannot_write(self.path, error) from error
        self.size_bytes += len(data)

    def _truncate(self, size_bytes: int) -> None:
        # What is not a regular file cannot; the reader tolerates a half-written record.
        with contextlib.suppress(OSError):
            os.ftruncate(self._file, size_bytes)
            os.lseek(self._file, size_bytes, os.SEEK_SET)

    def _sync(self) -> None:
        try:
            os.fsync(self._file)
        except OSError as error:
            if error.errno not in (errno.EINVAL, errno.ENOTSUP):  # no disk behind it
                raise cannot_write(self.path, error) from error

    def _close(self) -> None:
        if self._file >= 0:
            os.close(self._file)
            self._file = -1


class Capture:
    """A capture on disk. `metadata` is there at once; the rest is known after `chunks` ended."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.ended_cleanly = False
        self.cut_off_bytes = 0  # behind the last whole record
        self.duration_s = 0.0
        try:
            with open(path, "rb") as file:
                self.metadata = self._read_header(file)
                self._records_at = file.tell()
        except OSError as error:
            raise cannot_read(path, error) from error

    def chunks(self) -> Iterator[tuple[float, bytes]]:
        """(host_s, bytes) in the order of arrival, up to the end or to where the file is cut."""
        try:
            with open(self.path, "rb") as file:
                size_bytes = os.fstat(file.fileno()).st_size
                file.seek(self._records_at)
                yield from self._read_records(file, size_bytes)
        except OSError as error:
            raise cannot_read(self.path, error) from error

    def _read_header(self, file) -> dict:
        magic = file.readline(HEADER_MAX)
        if not magic:
            raise CannotRead(f"{self.path} is empty")
        if not magic.startswith(MAGIC):
            raise CannotRead(
                f"{self.path} is not a Terazi capture",
                remedy="Captures are made by `terazi log PORT -o FILE`.",
            )
        version = magic[len(MAGIC) :].strip()
        if version != b"%d" % FORMAT:
            raise CannotRead(
                f"{self.path} has capture format {version.decode(errors='replace')}; "
                f"this terazi reads {FORMAT}"
            )
        line = file.readline(HEADER_MAX)
        if not line.endswith(b"\n"):
            raise CannotRead(f"{self.path} is cut off within its header")
        try:
            metadata = json.loads(line)
        except ValueError as error:
            raise CannotRead(f"{self.path} has a damaged header") from error
        if not isinstance(metadata, dict):
            raise CannotRead(f"{self.path} has a damaged header")
        return metadata

    def _read_records(self, file, size_bytes: int) -> Iterator[tuple[float, bytes]]:
        self.ended_cleanly = False
        while True:
            begin = file.tell()
            self.cut_off_bytes = size_bytes - begin
            head = file.read(RECORD_HEAD.size)
            if len(head) < RECORD_HEAD.size:
                return
            host_s, length = RECORD_HEAD.unpack(head)
            if length > RECORD_MAX or not math.isfinite(host_s):
                return
            data = file.read(length)
            if len(data) < length:
                return
            self.duration_s = host_s
            if length == 0:
                self.ended_cleanly = True
                self.cut_off_bytes = size_bytes - file.tell()
                return
            yield host_s, data
