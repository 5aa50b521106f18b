# SPDX-License-Identifier: MIT
"""How one stage of the device compares with its C on this machine."""

from dataclasses import dataclass, field

import numpy as np

DIFFERENCES_SHOWN = 5


@dataclass(frozen=True)
class Difference:
    """One answer of the device that is not this host's.

    sample : index in the recording;  conversion : of the converter, or the number of the IMU's
    sample, as on the wire.
    """

    sample: int
    conversion: int
    device: int
    host: int


@dataclass
class StageResult:
    """How one stage compares with the C."""

    stage: str
    compared: int = 0
    differing: int = 0
    first: list[Difference] = field(default_factory=list)

    def add(
        self, numbers: np.ndarray, indices: np.ndarray, device: np.ndarray, host: np.ndarray
    ) -> None:
        """numbers : of every sample, as on the wire;  device, host : (n,), of those at indices; or
        (n, m), and then the first that differs of each row is shown."""
        wrong = np.asarray(device != host)
        rows = np.flatnonzero(wrong.any(axis=1) if wrong.ndim == 2 else wrong)
        self.compared += len(indices)
        self.differing += len(rows)
        for at in rows[: DIFFERENCES_SHOWN - len(self.first)].tolist():
            index, which = int(indices[at]), int(np.argmax(np.atleast_1d(wrong[at])))
            values = (int(np.atleast_1d(one[at])[which]) for one in (device, host))
            self.first.append(Difference(index, int(numbers[index]), *values))
