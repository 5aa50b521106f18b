# SPDX-License-Identifier: MIT
"""Faults at random on the shipped image: the short run of tools/measure/faults.py."""

import pytest

from tools.measure.faults import KINDS, Injection


@pytest.mark.parametrize(("rate_sps", "samples"), [(92.0, 10_000), (80.0, 6_000), (10.8, 4_000)])
def test_no_wrong_weight_is_stable_while_anything_fails(request, rate_sps, samples):
    if request.config.getoption("--uno") != "virtual":
        pytest.skip("a real board cannot break its own wires")
    figures = Injection(rate_sps=rate_sps, seed=round(rate_sps)).run(samples)
    assert figures.samples >= samples
    assert figures.stable > 0.3 * samples, "or it would be easy"
    assert len(figures.injected) >= len(KINDS) - 3
    assert figures.wrong == 0
    assert figures.late == []
