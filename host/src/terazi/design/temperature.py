# SPDX-License-Identifier: MIT
"""shared_c/spec/temperature.toml as numbers."""

from __future__ import annotations

import tomllib
from functools import cache

from terazi.design.specs import CHECKOUT, INSTALLED


@cache
def _spec() -> dict:
    folder = INSTALLED if INSTALLED.is_dir() else CHECKOUT
    return tomllib.loads((folder / "temperature.toml").read_text(encoding="utf-8"))


def limits() -> dict[str, float]:
    """[limits] and [fit]: span_max_ppm_per_k, moved_min_k."""
    return {**_spec()["limits"], **_spec()["fit"]}
