# SPDX-License-Identifier: MIT
"""Reads records of walks: two published .npz formats, CSV by a layout (layouts.py), and captures
(captures.py), which are known by how they begin.

Vicon .npz: `imu` (n, 6) m/s^2 and rad/s, `ts` (n,) s, `gt` (n, 3) m, left-handed against axes whose
z points up, with jumps where markers were lost; `zv_*_opt` labels, `best_detector` which of them.
Footprints .npz: `imu`, `ts`, `gcp` (k, 2) m, of the same hand, at `stride_index` (k,).
An .npz with `imu` and `ts` alone is a walk without truth.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from terazi.applications.walks import captures, layouts
from terazi.applications.walks.checks import check
from terazi.applications.walks.record import Truth, Walk
from terazi.errors import CannotRead, CannotWrite, UsageError
from terazi.recorder.tables import table_paths

SUFFIXES = (".npz", ".csv")
FIELDS = ("imu", "ts", "gt", "gcp", "stride_index", "best_detector")
JUMP_M = 0.05  # of one sample: no foot does that
MASK_S = 0.25  # around a jump the truth does not count
LEFT_HANDED = np.array([1.0, -1.0, 1.0])


def find_walks(folder: Path, begins: str = "") -> list[Path]:
    """The records of a folder whose names begin so, or the one file named; never none."""
    if folder.is_file():
        return [folder]
    if not folder.is_dir():
        raise CannotRead(f"{folder}: no such file or folder")
    files = [path for path in folder.iterdir() if path.is_file()]
    captured = [path for path in files if captures.is_capture(path)]
    # What lies beside a capture was made of it.
    made = {table for path in captured for table in table_paths(path).values()}
    found = captured + [path for path in files if path.suffix.lower() in SUFFIXES]
    paths = sorted({path for path in found if path.name.startswith(begins) and path not in made})
    if not paths:
        which = f" and begins with {begins}" if begins else ""
        raise CannotRead(
            f"{folder}: holds no capture and no file that ends in {' or '.join(SUFFIXES)}{which}"
        )
    _refuse_twins(paths)
    return paths


def _refuse_twins(paths: list[Path]) -> None:
    """Results are told by the files' names without their ends."""
    by_name: dict[str, Path] = {}
    for path in paths:
        other = by_name.setdefault(path.stem, path)
        if other is not path:
            raise CannotRead(
                f"{path.parent}: {other.name} and {path.name} would bear one name in the result",
                remedy=f"Rename one, or choose: --only {path.name}",
            )


def load_walk(path: Path, *, layout: Path | None = None, rate_hz: float | None = None) -> Walk:
    """Read and check one file; CannotRead says what is wrong with it, UsageError with the wish.

    layout : TOML of columns and units, for a CSV.  rate_hz : of a CSV without times.
    """
    if path.is_dir():
        raise CannotRead(f"{path}: is a folder", remedy=f"`terazi walk score {path}` takes those.")
    is_capture = captures.is_capture(path)
    if is_capture or path.suffix.lower() == ".npz":
        if layout is not None or rate_hz is not None:
            raise UsageError(f"{path}: a layout or a rate is for a CSV; this file tells both")
        return check(captures.read_capture(path) if is_capture else _from_npz(path))
    return check(layouts.read_csv(path, layout=layout, rate_hz=rate_hz))


def _from_npz(path: Path) -> Walk:
    fields = _fields(path)
    imu = _floats(path, fields, "imu", 6)
    t_s = _floats(path, fields, "ts", 0)
    if len(imu) != len(t_s):
        raise CannotRead(f"{path}: {len(imu)} rows of imu, but {len(t_s)} of ts")
    truth = labels = None
    if "gt" in fields:
        truth = _vicon_truth(path, _floats(path, fields, "gt", 3), t_s)
        labels = _labels(fields, len(t_s))
    elif "gcp" in fields:
        points = _floats(path, fields, "gcp", 2)
        at = np.asarray(fields.get("stride_index", ())).astype(np.int64).ravel()
        if len(at) != len(points) or not len(at) or at.min() < 0 or at.max() >= len(t_s):
            raise CannotRead(f"{path}: stride_index does not name a sample of each footprint")
        truth = Truth(at, points * LEFT_HANDED[:2], from_start=True)
    t_s, kept = layouts.growing(path, t_s)
    if not kept.all():
        raise CannotRead(f"{path}: ts does not always grow")
    return Walk(path.stem, t_s, imu[:, :3], imu[:, 3:], truth, labels)


def _fields(path: Path) -> dict:
    try:
        with path.open("rb") as stream:  # ours to close: numpy forgets it where the zip is broken
            archive = np.load(stream, allow_pickle=False)
            if not isinstance(archive, np.lib.npyio.NpzFile):
                raise CannotRead(f"{path}: no .npz archive")
            missing = [name for name in ("imu", "ts") if name not in archive.files]
            if missing:
                raise CannotRead(
                    f"{path}: lacks {' and '.join(missing)}",
                    remedy="Wanted: imu (n, 6) in m/s^2 and rad/s, and ts (n,) in s.",
                )
            return {name: archive[name] for name in archive.files if _is_wanted(name)}
    except OSError as error:
        raise CannotRead(f"{path}: {error.strerror or error}") from None
    except CannotRead:
        raise
    except Exception as error:  # of zip, zlib, numpy's headers: a dozen kinds
        raise CannotRead(f"{path}: is no .npz archive, or a damaged one: {error}") from None


def _is_wanted(name: str) -> bool:
    """What else an archive holds may be of any kind."""
    return name in FIELDS or name.startswith("zv_")


def _floats(path: Path, fields: dict, name: str, width: int) -> np.ndarray:
    try:
        values = np.asarray(fields[name]).astype(np.float64)
    except ValueError as error:
        raise CannotRead(f"{path}: {name}: {error}") from None
    if values.ndim != (2 if width else 1) or (width and values.shape[1] != width):
        wanted = f"(n, {width})" if width else "(n,)"
        raise CannotRead(f"{path}: {name} has the shape {values.shape}, not {wanted}")
    finite = np.isfinite(values)
    wrong = np.flatnonzero(~(finite.all(axis=1) if width else finite))
    if name != "gt" and len(wrong):
        raise CannotRead(
            f"{path}: {name} holds what is no number in {len(wrong)} rows, first in row "
            f"{wrong[0] + 1}",
            remedy="Leave such rows out, of ts as well.",
        )
    return values


def _vicon_truth(path: Path, pos_m: np.ndarray, t_s: np.ndarray) -> Truth | None:
    if len(pos_m) != len(t_s):
        raise CannotRead(f"{path}: {len(pos_m)} rows of gt, but {len(t_s)} of ts")
    if np.isfinite(pos_m).all(axis=1).sum() < 2:
        return None
    counted = np.isfinite(pos_m).all(axis=1)
    jumps = np.flatnonzero(~(np.linalg.norm(np.diff(pos_m, axis=0), axis=1) <= JUMP_M))
    for at in np.unique(np.concatenate([jumps, jumps + 1])):
        begin, end = np.searchsorted(t_s, [t_s[at] - MASK_S, t_s[at] + MASK_S])
        counted[begin : end + 1] = False
    if not counted.any():
        counted = np.isfinite(pos_m).all(axis=1)
    at = np.flatnonzero(counted)
    return Truth(at, pos_m[at] * LEFT_HANDED)


def _labels(fields: dict, count: int) -> np.ndarray | None:
    """Those of the detector that was best in this trial."""
    best = str(np.asarray(fields.get("best_detector", "")).ravel()[0])
    labels = fields.get(f"zv_{best}_opt")
    if labels is None or np.shape(labels) != (count,):
        return None
    return np.asarray(labels).astype(bool)


def save_walk(path: Path, walk: Walk) -> None:
    """Write an .npz as load_walk reads it: a walk whose truth is known at every sample."""
    fields = {"imu": np.hstack([walk.acc_b_m_s2, walk.gyro_b_rad_s]), "ts": walk.t_s}
    if walk.truth is not None:
        fields["gt"] = walk.truth.pos_t_m * LEFT_HANDED
    if walk.zero_velocity is not None:
        fields |= {"best_detector": "shoe", "zv_shoe_opt": walk.zero_velocity.astype(np.uint8)}
    try:
        with path.open("wb") as stream:
            np.savez_compressed(stream, **fields)
    except OSError as error:
        raise CannotWrite(f"{path}: {error.strerror or error}") from None
