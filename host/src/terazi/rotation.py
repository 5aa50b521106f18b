# SPDX-License-Identifier: MIT
"""Quaternions as people see them: angles and the vertical. Body to world, scalar first."""

import numpy as np


def euler_deg(quat_wb: np.ndarray) -> np.ndarray:
    """(n, 3) roll, pitch and yaw in degrees of (n, 4) quaternions of any norm but zero.

    Order z-y-x: yaw about world z, anticlockwise from east, then pitch, then roll.
    """
    w, x, y, z = unit(quat_wb).T
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2 * (w * y - z * x), -1.0, 1.0))
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return np.degrees(np.stack([roll, pitch, yaw], axis=1))


def up_b(quat_wb: np.ndarray) -> np.ndarray:
    """(n, 3) the vertical in body axes, of (n, 4) quaternions of any norm but zero."""
    w, x, y, z = unit(quat_wb).T
    columns = [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]
    return np.stack(columns, axis=1)


def tilt_deg(quat_wb: np.ndarray) -> np.ndarray:
    """(n,) how far body z stands off the vertical."""
    x, y, z = up_b(quat_wb).T
    return np.degrees(np.arctan2(np.hypot(x, y), z))


def unit(quat_wb: np.ndarray) -> np.ndarray:
    """(n, 4) of norm 1."""
    quat = np.asarray(quat_wb, dtype=np.float64)
    return quat / np.linalg.norm(quat, axis=1, keepdims=True)
