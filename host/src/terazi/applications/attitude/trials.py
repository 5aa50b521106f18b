# SPDX-License-Identifier: MIT
"""Reads recordings of an inertial sensor beside an optical orientation, in BROAD's manner.

An .npz holds, for n samples: `gyr`, `acc`, `mag` (n, 3) in sensor counts, `quat` (n, 4) w x y z
taking body to world (east, north, up) in any common scale, all zero or not a number where it is
missing, `movement` (n,) 1 where the trial moves. Scalars, each with BROAD's value if left out:
`sampling_rate` in Hz, `gyr_lsb_per_dps`, `acc_lsb_per_g`, `mag_lsb_per_uT`.
BROAD: Laidig, Caruso, Cereatti, Seel 2021, Data 6(7):72.
"""

from __future__ import annotations

import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from terazi.errors import CannotRead

# The chip's counts (MPU-6050 at +-2000 deg/s and +-16 g); other scales are converted.
GYRO_COUNTS_PER_DEG_S = 16.384
ACC_COUNTS_PER_G = 2048.0
MAG_COUNTS_PER_UT = 100.0
RATE_HZ = 2000.0 / 7.0
RATES_HZ = (50.0, 1000.0)
SHORTEST_S = 1.0

ARRAYS = {"gyr": 3, "acc": 3, "mag": 3, "quat": 4, "movement": 0}
SCALARS = {
    "sampling_rate": RATE_HZ,
    "gyr_lsb_per_dps": GYRO_COUNTS_PER_DEG_S,
    "acc_lsb_per_g": ACC_COUNTS_PER_G,
    "mag_lsb_per_uT": MAG_COUNTS_PER_UT,
}
SCALE_OF = {"gyr": "gyr_lsb_per_dps", "acc": "acc_lsb_per_g", "mag": "mag_lsb_per_uT"}


@dataclass(frozen=True)
class Trial:
    """One recording, in the chip's counts."""

    name: str
    rate_hz: float
    gyro_b_counts: np.ndarray  # (n, 3) int16
    acc_b_counts: np.ndarray  # (n, 3) int16
    mag_b_counts: np.ndarray  # (n, 3) int16
    truth_wb: np.ndarray  # (n, 4) float64 unit quaternions, NaN where missing
    moving: np.ndarray  # (n,) bool

    @property
    def scored(self) -> np.ndarray:
        """(n,) bool: where errors count."""
        return self.moving & np.isfinite(self.truth_wb).all(axis=1)


def find_trials(folder: Path) -> list[Path]:
    """The .npz files of a folder, or the one file named; never none."""
    if folder.is_file():
        return [folder]
    if not folder.is_dir():
        raise CannotRead(f"{folder}: no such folder")
    paths = sorted(folder.glob("*.npz"))
    if not paths:
        raise CannotRead(
            f"{folder}: holds no file that ends in .npz",
            remedy="Trials in BROAD's format are read: gyr, acc, mag, quat and movement in counts.",
        )
    return paths


def load_trial(path: Path) -> Trial:
    """Read one file; CannotRead says which field is wrong, and how."""
    fields = read_fields(path, needed=tuple(ARRAYS))
    rate_hz = rate_of(path, fields)
    count = len(fields["gyr"])
    if count < SHORTEST_S * rate_hz:
        raise CannotRead(f"{path}: {count} samples are less than {SHORTEST_S:g} s")
    trial = Trial(
        name=path.stem,
        rate_hz=rate_hz,
        gyro_b_counts=chip_counts(path, fields, "gyr"),
        acc_b_counts=chip_counts(path, fields, "acc"),
        mag_b_counts=chip_counts(path, fields, "mag"),
        truth_wb=unit_quaternions(fields["quat"]),
        moving=fields["movement"] == 1,
    )
    if not trial.scored.any():
        raise CannotRead(f"{path}: no sample moves and has a known orientation")
    return trial


def rate_of(path: Path, fields: dict) -> float:
    """The sampling rate, within what the filters are for."""
    rate_hz = fields["sampling_rate"]
    if not RATES_HZ[0] <= rate_hz <= RATES_HZ[1]:
        raise CannotRead(f"{path}: a rate of {rate_hz:g} Hz; {RATES_HZ[0]:g} to {RATES_HZ[1]:g} do")
    return rate_hz


def read_fields(path: Path, *, needed: tuple[str, ...]) -> dict:
    """Arrays and scalars as float64; arrays that are not needed only where the file has them."""
    fields = _fields(path, needed)
    count = fields["gyr"].shape[0] if fields["gyr"].ndim else 0
    for name, width in ARRAYS.items():
        shape = (count, width) if width else (count,)
        if name in fields and fields[name].shape != shape:
            raise CannotRead(f"{path}: {name} has the shape {fields[name].shape}, not {shape}")
    return fields


def _fields(path: Path, needed: tuple[str, ...]) -> dict:
    found: dict = {}
    try:
        with path.open("rb") as stream:  # ours to close: numpy forgets it where the zip is broken
            archive = np.load(stream, allow_pickle=False)
            if not isinstance(archive, np.lib.npyio.NpzFile):
                raise CannotRead(f"{path}: no .npz archive")
            missing = [name for name in needed if name not in archive.files]
            if missing:
                raise CannotRead(f"{path}: lacks {', '.join(missing)}")
            for name in (*ARRAYS, *SCALARS):
                if name in archive.files:
                    found[name] = np.asarray(archive[name]).astype(np.float64)
    except OSError as error:
        raise CannotRead(f"{path}: {error.strerror or error}") from None
    except (ValueError, TypeError, EOFError, zipfile.BadZipFile) as error:
        raise CannotRead(f"{path}: {error}") from None
    for name, usual in SCALARS.items():
        value = found.get(name, np.float64(usual))
        if value.size != 1 or not np.isfinite(value).all() or value.item() <= 0:
            raise CannotRead(f"{path}: {name} must be one positive number")
        found[name] = value.item()
    return found


def chip_counts(path: Path, fields: dict, name: str) -> np.ndarray:
    """(n, 3) int16 in the chip's counts, limited as the chip's converter would."""
    values, scale = fields[name], SCALE_OF[name]
    if not np.isfinite(values).all():
        raise CannotRead(f"{path}: {name} holds what is no number")
    chip = np.rint(values * (SCALARS[scale] / fields[scale]))
    return np.ascontiguousarray(np.clip(chip, -32768, 32767).astype(np.int16))


def unit_quaternions(quats: np.ndarray) -> np.ndarray:
    """Unit quaternions; NaN where there is none."""
    norms = np.linalg.norm(quats, axis=1)
    norms[~np.isfinite(norms) | (norms == 0)] = np.nan
    return quats / norms[:, None]
