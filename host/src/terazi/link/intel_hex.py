# SPDX-License-Identifier: MIT
"""Images for the chip, as Intel HEX files (Intel, Hexadecimal Object File Format, rev. A, 1988).

An image is read and judged here before a board is touched: what comes out of `read_image` fits
the Uno and leaves its boot loader alone.
"""

import string
from dataclasses import dataclass
from pathlib import Path

from terazi.errors import CannotRead, FlashFailed

# Flash of the ATmega328P below the 512 bytes of optiboot (hfuse 0xDE, datasheet table 27-7).
APPLICATION_BYTES = 0x7E00

DATA, END, SEGMENT, START_SEGMENT, LINEAR, START_LINEAR = range(6)
# Bytes before and after a record's data: count, address (2), type; checksum.
RECORD_HEAD, RECORD_TAIL = 4, 1
ADDRESS_BYTES = 2  # in a SEGMENT or LINEAR record


@dataclass(frozen=True)
class Image:
    """What a hex file puts into flash, from address 0; 0xFF where the file says nothing."""

    path: Path
    data: bytes
    used_bytes: int


def read_image(path: Path) -> Image:
    """The image in a hex file.

    Raises CannotRead where it is no sound Intel HEX file, FlashFailed where it does not fit.
    """
    byte_at = _bytes_by_address(path)
    if not byte_at:
        raise CannotRead(f"{path} holds no program", remedy="Build it anew, or name another file.")
    first, last = min(byte_at), max(byte_at)
    if last >= APPLICATION_BYTES:
        raise FlashFailed(
            f"{path} reaches to address 0x{last:X}, the Uno's application section ends at "
            f"0x{APPLICATION_BYTES - 1:X}",
            remedy=f"An image for the Uno has at most {APPLICATION_BYTES} bytes; above them lies "
            "the boot loader.",
        )
    if first != 0:
        raise FlashFailed(
            f"{path} begins at address 0x{first:X}: no program, the chip starts at 0",
            remedy="Name the hex file of a whole firmware.",
        )
    data = bytes(byte_at.get(address, 0xFF) for address in range(last + 1))
    return Image(path, data, len(byte_at))


def _bytes_by_address(path: Path) -> dict[int, int]:
    try:
        lines = path.read_text(encoding="ascii").splitlines()
    except UnicodeDecodeError as error:
        raise _not_hex(
            path, "it is binary; avr-objcopy -O ihex makes a hex file of an ELF"
        ) from error
    except OSError as error:
        raise CannotRead(
            f"cannot read {path}: {error.strerror}",
            remedy="Build it with ./dev setup, or name another file.",
        ) from error

    byte_at: dict[int, int] = {}
    base = 0
    for number, line in enumerate(lines, start=1):
        if not line.strip():
            continue
        kind, address, data = _record(path, number, line.strip())
        if kind == DATA:
            byte_at.update((base + address + i, byte) for i, byte in enumerate(data))
        elif kind == END:
            return byte_at
        elif kind in (SEGMENT, LINEAR) and len(data) == ADDRESS_BYTES:
            base = int.from_bytes(data, "big") << (4 if kind == SEGMENT else 16)
        elif kind not in (START_SEGMENT, START_LINEAR):  # where a PC would start: nothing to us
            raise _not_hex(path, f"line {number} is a record of unknown type {kind}")
    raise _not_hex(path, "its end is missing")


def _record(path: Path, number: int, line: str) -> tuple[int, int, bytes]:
    """Type, address and data of one line."""
    digits = line[1:]
    if line[0] != ":" or len(digits) % 2 or not set(digits) <= set(string.hexdigits):
        raise _not_hex(path, f"line {number} is no record")
    record = bytes.fromhex(digits)
    if len(record) < RECORD_HEAD + RECORD_TAIL:
        raise _not_hex(path, f"line {number} is cut off")
    if len(record) != RECORD_HEAD + record[0] + RECORD_TAIL:
        raise _not_hex(path, f"line {number} is not as long as it says")
    if sum(record) % 256 != 0:
        raise _not_hex(path, f"line {number} has a wrong checksum")
    return record[3], int.from_bytes(record[1:3], "big"), record[RECORD_HEAD:-RECORD_TAIL]


def _not_hex(path: Path, why: str) -> CannotRead:
    return CannotRead(
        f"{path} is not a sound Intel HEX file: {why}",
        remedy="Build it anew, or name another file.",
    )
