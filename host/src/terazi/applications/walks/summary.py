# SPDX-License-Identifier: MIT
"""What one reads of a walk at a glance."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from terazi.applications.walks.estimate import Result
from terazi.applications.walks.score import path_errors


@dataclass(frozen=True)
class Summary:
    """Of one path."""

    name: str
    duration_s: float
    computed_s: float | None  # how long it took, where somebody looked at the clock
    rate_hz: float
    detector: str
    settled_s: float
    still_share: float
    strides: int
    distance_m: float
    climbed_m: float
    descended_m: float
    end_w_m: list[float]
    end_distance_m: float
    rmse_2d_m: float | None
    rmse_3d_m: float | None
    closure_m: float | None
    notes: list[str]

    def plain(self) -> dict:
        """What `terazi walk FILE --json` prints."""
        return asdict(self)

    def rows(self) -> list[tuple[str, str]]:
        """Names and values for a table."""
        rows = [
            (
                "walk",
                f"{self.name}: {self.duration_s:.1f} s at {self.rate_hz:.1f} samples a second",
            ),
            ("stands", f"{100 * self.still_share:.0f} % of the time, by {self.detector}"),
            ("strides", f"{self.strides} of this foot"),
            ("distance", f"{self.distance_m:.2f} m on the plan"),
            ("height", f"{self.climbed_m:.2f} m up, {self.descended_m:.2f} m down"),
            ("end", "x {} m, y {} m, z {} m".format(*map(_hundredths, self.end_w_m))),
        ]
        if self.computed_s is not None:
            rows.insert(1, ("computed", f"in {self.computed_s:.2f} s"))
        # Of a loop it is the error; what is no loop ends elsewhere.
        rows.append(("end to start", f"{self.end_distance_m:.3f} m"))
        if self.rmse_2d_m is not None:
            rows.append(("error, 2-D rms", f"{self.rmse_2d_m:.3f} m"))
        if self.rmse_3d_m is not None:
            rows.append(("error, 3-D rms", f"{self.rmse_3d_m:.3f} m"))
        return rows


def _hundredths(value_m: float) -> str:
    return f"{round(value_m, 2) + 0.0:.2f}"  # + 0.0: never -0.00


def summarise(result: Result, *, computed_s: float | None = None) -> Summary:
    """The figures of one path."""
    walk, path, strides = result.walk, result.path, result.strides
    known = path_errors(walk, path.pos_w_m)
    rises = strides.vectors_m[:, 2]
    end = path.pos_w_m[-1] - path.pos_w_m[0]
    return Summary(
        name=walk.name,
        duration_s=float(walk.t_s[-1] - walk.t_s[0]),
        computed_s=computed_s,
        rate_hz=walk.rate_hz,
        detector=result.detection.detector,
        settled_s=float(walk.t_s[max(path.settled, 1) - 1] - walk.t_s[0]),
        still_share=float(np.mean(path.still)),
        strides=len(strides),
        distance_m=strides.length_m,
        climbed_m=float(rises[rises > 0].sum()),
        descended_m=float(abs(rises[rises < 0].sum())),
        end_w_m=[float(each) for each in end],
        end_distance_m=float(np.linalg.norm(end)),
        rmse_2d_m=known.rmse_2d_m,
        rmse_3d_m=known.rmse_3d_m,
        closure_m=known.closure_m,
        notes=list(walk.notes),
    )
