# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading programs: ELF files with their symbols, Intel HEX files without."""

import dataclasses
import pathlib
import re

FLASH_SIZE = 0x8000
SRAM_BASE = 0x800000  # avr-gcc puts data addresses here ...
EEPROM_BASE = 0x810000  # ... and EEPROM contents here
EEPROM_END = 0x820000
# What gcc appends to the name of a function that it fitted to its callers; a .part is no function.
CLONE = re.compile(r"(\.(constprop|isra|lto_priv)\.\d+)+$")


@dataclasses.dataclass(frozen=True)
class Program:
    """Pieces of memory as (address, bytes); symbol values in avr-gcc's address space."""

    flash: list
    eeprom: list
    symbols: dict
    functions: dict  # name -> (flash byte address, size)

    def function_at(self, address):
        """Name of the function that holds a flash byte address, with the offset in it."""
        for name, (start, size) in self.functions.items():
            if start <= address < start + max(size, 2):
                offset = address - start
                return f"{name}+0x{offset:x}" if offset else name
        return f"0x{address:04x}"


def _read_elf(path):
    from elftools.elf.elffile import ELFFile

    flash, eeprom, symbols, functions = [], [], {}, {}
    with open(path, "rb") as file:
        elf = ELFFile(file)
        if elf["e_machine"] != "EM_AVR":
            raise ValueError(f"{path}: not a program for AVR but for {elf['e_machine']}")
        for segment in elf.iter_segments("PT_LOAD"):
            address, data = segment["p_paddr"], segment.data()
            if not data:
                continue
            if address + len(data) <= FLASH_SIZE:
                flash.append((address, data))
            elif EEPROM_BASE <= address < EEPROM_END:
                eeprom.append((address - EEPROM_BASE, data))
        table = elf.get_section_by_name(".symtab")
        for symbol in table.iter_symbols() if table else ():
            if not symbol.name or symbol["st_shndx"] == "SHN_UNDEF":
                continue
            symbols[symbol.name] = symbol["st_value"]
            if symbol["st_info"]["type"] == "STT_FUNC":
                functions[symbol.name] = (symbol["st_value"], symbol["st_size"])
    for name, value in list(symbols.items()):
        symbols.setdefault(CLONE.sub("", name), value)
    return Program(flash, eeprom, symbols, functions)


def read_hex(path):
    """Pieces (address, bytes) of an Intel HEX file; ValueError names the faulty line."""
    pieces, base = [], 0
    for number, line in enumerate(pathlib.Path(path).read_text("ascii").split(), 1):
        try:
            record = bytes.fromhex(line.removeprefix(":"))
        except ValueError:
            record = b""
        if not line.startswith(":") or len(record) < 5 or sum(record) & 0xFF:
            raise ValueError(f"{path}:{number}: not an Intel HEX record")
        count, address, kind = record[0], record[1] << 8 | record[2], record[3]
        data = record[4:-1]
        if len(data) != count:
            raise ValueError(f"{path}:{number}: {len(data)} bytes where {count} are announced")
        if kind == 0:
            address += base
            if pieces and pieces[-1][0] + len(pieces[-1][1]) == address:
                pieces[-1] = (pieces[-1][0], pieces[-1][1] + data)
            else:
                pieces.append((address, data))
        elif kind == 1:
            break
        elif kind == 2:
            base = (data[0] << 8 | data[1]) << 4
        elif kind == 4:
            base = (data[0] << 8 | data[1]) << 16
    for address, data in pieces:
        if address + len(data) > FLASH_SIZE:
            raise ValueError(
                f"{path}: {len(data)} bytes at 0x{address:x} reach past the end of the flash"
            )
    return pieces


def write_hex(path, image):
    """The flash image up to its last programmed byte, as Intel HEX."""
    used = len(image.rstrip(b"\xff"))
    lines = []
    for address in range(0, used, 16):
        data = image[address : min(address + 16, used)]
        record = bytes([len(data), address >> 8, address & 0xFF, 0]) + data
        lines.append(":" + (record + bytes([-sum(record) & 0xFF])).hex().upper())
    lines.append(":00000001FF")
    pathlib.Path(path).write_text("\n".join(lines) + "\n", "ascii")


def read_program(path):
    """An ELF file, or an Intel HEX file by its suffix."""
    if pathlib.Path(path).suffix.lower() in (".hex", ".ihex"):
        return Program(read_hex(path), [], {}, {})
    return _read_elf(path)
