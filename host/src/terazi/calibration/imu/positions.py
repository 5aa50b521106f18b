# SPDX-License-Identifier: MIT
"""Which ways up a board has lain, which are wanted yet, and how to get there.

Nothing is known of how the part sits on its board. So a position is named by the part's own axes,
and a hint refers to positions that were taken already.

    face     an axis within 25 degrees of the vertical; offset and scale come of the six
    slant    two axes that are both off the level and the vertical; cross axes come of these
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

AXES = "xyz"
FACES = tuple(f"{axis} {way}" for axis in AXES for way in ("up", "down"))
PAIRS = (("x", "y"), ("y", "z"), ("z", "x"))
FACE_LEAST = 0.9  # cosine of 25.8 degrees
SLANT_LEAST = 0.25  # product of the two components: 15 degrees off level and vertical alike
SLANTS_EACH = 2  # positions for each pair of axes
FREE_POSITIONS = 12
APART_DEG = 20.0


def face_of(up: np.ndarray) -> str | None:
    """The face that is up, or None: at a slant."""
    at = int(np.argmax(np.abs(up)))
    if abs(up[at]) < FACE_LEAST:
        return None
    return f"{AXES[at]} {'up' if up[at] > 0 else 'down'}"


def name_of(up: np.ndarray) -> str:
    """A position in words: `z up`, or `x and z at a slant`."""
    face = face_of(up)
    if face is not None:
        return face
    axes = [axis for axis, value in zip(AXES, up, strict=True) if abs(value) > 0.25]
    return f"{' and '.join(axes)} at a slant"


def missing_faces(ups: Sequence[np.ndarray]) -> list[str]:
    """Faces that none of these positions has up."""
    taken = {face_of(up) for up in ups}
    return [face for face in FACES if face not in taken]


def missing_slants(ups: Sequence[np.ndarray]) -> list[str]:
    """Pairs of axes that want more positions at a slant, with how many."""
    wanted = []
    for pair in PAIRS:
        i, j = (AXES.index(axis) for axis in pair)
        there = sum(abs(up[i] * up[j]) > SLANT_LEAST for up in distinct(ups))
        if there < SLANTS_EACH:
            wanted.append(f"{pair[0]} and {pair[1]} ({SLANTS_EACH - there} more)")
    return wanted


def distinct(ups: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Positions that lie APART_DEG from all before them."""
    kept: list[np.ndarray] = []
    most = np.cos(np.radians(APART_DEG))
    for up in ups:
        if all(up @ other < most for other in kept):
            kept.append(up)
    return kept


def hint(faces: Sequence[str], ups: Sequence[np.ndarray]) -> str:
    """How to bring one of the missing faces up, by what was taken already."""
    taken = {face_of(up) for up in ups}
    for face in faces:
        other = opposite(face)
        if other in taken:
            return f"{face}: as it lay for “{other}”, but upside down"
    if taken - {None}:
        return f"{faces[0]}: on one of the sides that have not been down yet"
    axis, way = faces[0].split()
    return f"{faces[0]}: the arrow {axis.upper()} on the module points {way}"


def opposite(face: str) -> str:
    """`x down` of `x up`."""
    axis, way = face.split()
    return f"{axis} {'down' if way == 'up' else 'up'}"


def emptiest(ups: Sequence[np.ndarray]) -> str:
    """For positions without faces: the direction furthest from all taken ones, in words."""
    grid = _directions()
    nearest = np.max(grid @ np.array(ups).T, axis=1) if len(ups) else np.zeros(len(grid))
    return name_of(grid[int(np.argmin(nearest))]).replace(" at a slant", " both at a slant")


def _directions() -> np.ndarray:
    """The 26 directions to the faces, edges and corners of a cube."""
    grid = np.array([(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)])
    grid = grid[np.any(grid != 0, axis=1)]
    return grid / np.linalg.norm(grid, axis=1)[:, None]
