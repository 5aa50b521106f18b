# SPDX-License-Identifier: MIT
"""Golden vectors (shared_c/vectors): read here, by the host's tests and the chip's runner alike.

A file opens with lines `# key: value`: claim, kind (published, model or recorded), origin,
generator, libraries, seed, then `parameter NAME` and `column NAME` lines; CSV with a head follows.
Whole numbers are decimal; columns ending in _hex are bytes.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[4] / "shared_c" / "vectors"
HEADER_KEYS = ("claim", "kind", "origin", "generator", "libraries", "seed")
KINDS = ("published", "model", "recorded")


class VectorError(ValueError):
    """A file is not a golden vector; the message names file and place."""


@dataclass(frozen=True)
class Vector:
    """One golden vector."""

    name: str
    header: dict[str, str]
    parameters: dict[str, str]
    columns: dict[str, list[int] | list[bytes]]

    def parameter(self, name: str) -> int:
        """A whole-number parameter."""
        return int(self.parameters[name])

    def __getitem__(self, column: str) -> list:
        return self.columns[column]

    def __str__(self) -> str:
        return self.name


def load(path: Path) -> Vector:
    """Read one file, refused where its header is not whole."""
    header, parameters, units = {}, {}, {}
    lines = path.read_text(encoding="utf-8").splitlines()
    body = [line for line in lines if not line.startswith("#")]
    for line in lines[: len(lines) - len(body)]:
        key, separator, value = line.removeprefix("# ").partition(": ")
        if not separator:
            raise VectorError(f"{path.name}: no `key: value` in {line!r}")
        kind, _, name = key.partition(" ")
        if kind == "parameter":
            parameters[name] = value.split(" (")[0]
        elif kind == "column":
            units[name] = value
        else:
            header[key] = value
    missing = [key for key in HEADER_KEYS if not header.get(key)]
    if missing or header["kind"] not in KINDS:
        raise VectorError(f"{path.name}: header lacks {missing or 'a known kind'}")
    rows = list(csv.reader(body))
    if len(rows) < 2 or rows[0] != list(units):
        raise VectorError(f"{path.name}: columns {rows[:1]} are not those described: {list(units)}")
    columns = {
        name: [bytes.fromhex(text) if name.endswith("_hex") else int(text) for text in values]
        for name, values in zip(rows[0], zip(*rows[1:], strict=True), strict=True)
    }
    return Vector(path.stem, header, parameters, columns)


def golden(prefix: str, folder: Path = FOLDER) -> list[Vector]:
    """All vectors whose file name begins with `prefix`; never none."""
    paths = sorted(folder.glob(f"{prefix}*.csv"))
    if not paths:
        raise VectorError(f"no vector {prefix}*.csv in {folder}")
    return [load(path) for path in paths]
