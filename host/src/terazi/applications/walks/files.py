# SPDX-License-Identifier: MIT
"""Writes a path as CSV: one row a sample, metres and seconds, z up, heading 0 at the start."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from terazi.applications.walks.estimate import Result
from terazi.errors import CannotWrite

COLUMNS = "t_s,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s,qw,qx,qy,qz,still,settled"


def write_path(target: Path, result: Result) -> None:
    """Replace what is there."""
    path = result.path
    settled = np.arange(len(path.pos_w_m)) < path.settled
    rows = np.column_stack(
        [result.walk.t_s, path.pos_w_m, path.vel_w_m_s, path.quat_wb, path.still, settled]
    )
    try:
        np.savetxt(target, rows, "%.6f,%.5f,%.5f,%.5f,%.5f,%.5f,%.5f,%.7f,%.7f,%.7f,%.7f,%d,%d",
                   header=COLUMNS, comments="")  # fmt: skip
    except OSError as error:
        raise CannotWrite(f"{target}: {error.strerror or error}") from None
