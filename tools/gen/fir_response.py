# SPDX-License-Identifier: MIT
"""Renders fir_response.svg: what the quantised designs of fir.toml do, beside their limits."""

from __future__ import annotations

from terazi.design import plot, specs
from tools.gen.spec import Spec


def page(spec: Spec) -> str:
    """Text of fir_response.svg."""
    curves = [
        plot.Curve(
            design["name"],
            specs.fir_taps_q15(design["name"]),
            design["nominal_rate_hz"],
            design["stopband_from_hz"],
            design["stopband_max_db"],
        )
        for design in spec.content["design"]
    ]
    return plot.svg(curves, (spec.origin, "SPDX-License-Identifier: MIT"))
