# SPDX-License-Identifier: MIT
"""What the operating system says when a file cannot be had, in words for people."""

import errno
import os
from pathlib import Path

from terazi.errors import CannotRead, CannotWrite

FULL = {
    errno.ENOSPC: "the disk is full",
    errno.EDQUOT: "the disk quota is used up",
    errno.EFBIG: "the largest allowed file size is reached",
}


def cannot_write(path: Path, error: OSError) -> CannotWrite:
    """The error to raise for an OSError met while making or writing `path`."""
    if error.errno in FULL:
        return CannotWrite(
            f"cannot write {path}: {FULL[error.errno]}",
            remedy="Free some space, or record to another disk with -o.",
        )
    if isinstance(error, FileExistsError):
        return CannotWrite(
            f"{path} exists already",
            remedy="Choose another name, or overwrite it with --force.",
        )
    if isinstance(error, FileNotFoundError):
        return CannotWrite(
            f"cannot write {path}: there is no folder {path.parent}",
            remedy=f"Make it: mkdir -p {path.parent}",
        )
    if isinstance(error, PermissionError):
        return CannotWrite(
            f"cannot write {path}: permission denied", remedy="Choose a folder of your own with -o."
        )
    return CannotWrite(f"cannot write {path}: {_reason(error)}")


def cannot_read(path: Path, error: OSError) -> CannotRead:
    """The error to raise for an OSError met while reading `path`."""
    if isinstance(error, FileNotFoundError):
        return CannotRead(f"there is no file {path}")
    return CannotRead(f"cannot read {path}: {_reason(error)}")


def _reason(error: OSError) -> str:
    text = os.strerror(error.errno) if error.errno else str(error)
    return text[:1].lower() + text[1:]
