# SPDX-License-Identifier: MIT
"""The recorded walks that programs of this room run over."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path

from terazi.applications.walks.formats import find_walks, load_walk
from terazi.applications.walks.record import Walk

USAGE = 2


def recorded_walks(folders: Sequence[Path], names: Sequence[str]) -> list[Walk]:
    """All in these folders; where there are none, in those of these names below walks in
    TERAZI_DATA. Ends the program where that is unset, too."""
    data = os.environ.get("TERAZI_DATA")
    if not folders and not data:
        print("tune: name a folder of walks, or set TERAZI_DATA", file=sys.stderr)
        raise SystemExit(USAGE)
    folders = folders or [Path(data) / "walks" / name for name in names]
    return [load_walk(path) for folder in folders for path in find_walks(folder)]
