# SPDX-License-Identifier: MIT
"""Build hook: puts the compiled extension into the wheel, or into the tree where it is editable."""

import sys
from pathlib import Path

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

ROOT = Path(__file__).resolve().parents[2]


class CffiBuildHook(BuildHookInterface):
    """Runs for wheels only; an sdist carries the sources."""

    def initialize(self, version: str, build_data: dict) -> None:
        sys.path.insert(0, str(ROOT))
        try:
            from tools.extension import cshared
        finally:
            sys.path.remove(str(ROOT))

        build_data["pure_python"] = False
        build_data["infer_tag"] = True
        if version == "editable":
            cshared.ensure(force=True)
            return
        built = cshared.build(Path(self.directory) / "cshared")
        build_data["force_include"][str(built)] = f"terazi/cshared/{built.name}"
