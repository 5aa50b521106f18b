# SPDX-License-Identifier: MIT
"""Where a recording can be replayed: stretches in which nothing of the filters' input is lost."""

from dataclasses import dataclass

import numpy as np

from terazi.link.generated.messages import SampleFlag

CONVERSION_PERIOD = 1 << 16


@dataclass(frozen=True)
class Segment:
    """Samples [begin, end) that the device's filters saw one after the other.

    is_primed: the filters started anew with the first of them, so that their state is known.
    Otherwise it is not: frames were lost before it, or the recording began in mid-stream.
    """

    begin: int
    end: int
    is_primed: bool

    def __len__(self) -> int:
        return self.end - self.begin


def segments_of(samples: dict[str, np.ndarray]) -> list[Segment]:
    """Cut the samples where the filters restart and where samples are missing.

    A conversion that the device itself lost (flag `gap`, no frame missing) is no cut: its
    filters ran on over it just as the replay does.
    """
    count = len(samples["conversion"])
    if not count:
        return []
    flags = samples["flags"]
    restarted = (flags & int(SampleFlag.RESTARTED)) != 0
    gap = (flags & int(SampleFlag.GAP)) != 0
    step = np.diff(samples["conversion"].astype(np.int64), prepend=0) % CONVERSION_PERIOD
    lost_here = (step != 1) & ~(gap & (samples["lost_before"] == 0))
    other_run = np.diff(samples["boot"], prepend=samples["boot"][:1]) != 0
    cuts = restarted | lost_here | other_run
    cuts[0] = True
    begins = np.flatnonzero(cuts)
    ends = [*begins[1:].tolist(), count]
    return [
        Segment(begin, end, bool(restarted[begin]))
        for begin, end in zip(begins.tolist(), ends, strict=True)
    ]
