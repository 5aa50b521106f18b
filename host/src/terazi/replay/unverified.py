# SPDX-License-Identifier: MIT
"""What a replay cannot judge, by name and with the reason: silence would look like agreement."""

from dataclasses import dataclass

from terazi.cshared import Fir
from terazi.link.generated.messages import KfKind
from terazi.recorder.calibration import Stretch
from terazi.recorder.chain import Chain
from terazi.replay.segments import Segment


@dataclass(frozen=True)
class Unverified:
    """samples: how many it is of."""

    what: str
    samples: int
    why: str

    def __str__(self) -> str:
        return f"{self.what} of {self.samples} samples: {self.why}"


def unverified(
    samples: int,
    segments: list[Segment],
    chain: Chain,
    stretches: list[Stretch],
    design: str,
    kalman_compared: int,
) -> list[Unverified]:
    """Everything in a recording that the replay said nothing of."""
    unknown = int(samples - chain.is_certain.sum())
    certain = [segment for segment in segments if chain.is_certain[segment.begin]]
    late = [segment for segment in certain if not segment.is_primed]
    window = Fir(design, 0).taps - 1
    fir = sum(min(window, len(segment)) for segment in late)
    adaptive = sum(
        len(segment) for segment in late if chain.kf_kind[segment.begin] == KfKind.ADAPTIVE
    )
    kalman = samples - unknown - adaptive - kalman_compared
    mass = sum(stretch.end - stretch.begin for stretch in stretches if stretch.points is None)
    found = [
        Unverified("all", unknown, "nothing says which filters made them"),
        Unverified("FIR", fir, "its window was not all recorded"),
        Unverified("adaptive Kalman", adaptive, "recorded from mid-stream, its state is unknown"),
        Unverified("Kalman", kalman, "recorded from mid-stream, its gains had not settled"),
        Unverified("mass", mass, "no POINT tells the calibration; `terazi log` asks for them"),
        Unverified("net weight and its flags", samples, "zero and stability are the board's past"),
    ]
    return [one for one in found if one.samples > 0]
