# SPDX-License-Identifier: MIT
"""The page's truth is laid over the path, wherever its axes point."""

from dataclasses import replace

import numpy as np

from terazi.applications.walks import Truth, estimate, simulator, summarise
from terazi.applications.walks.page import _truth_in_path, write_page

WALK = simulator.simulate(simulator.square(5.0), seed=3)


def elsewhere(pos, angle, shift):
    cos, sin = np.cos(angle), np.sin(angle)
    return pos @ np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]]) + shift


def test_truth_of_other_axes_is_drawn_over_the_path():
    path = estimate(WALK).path.pos_w_m
    for from_start in (False, True):
        at = np.arange(0, len(WALK), 10)
        moved = elsewhere(WALK.truth.pos_t_m, 2.0, [5.0, -3.0, 1.0])[at]
        drawn = _truth_in_path(path, Truth(at, moved, from_start))
        assert np.linalg.norm(drawn - path[at], axis=1).max() < 0.3


def test_a_page_is_whole_without_network_and_escapes_names(tmp_path):
    page = tmp_path / "x.html"
    write_page(page, estimate(replace(WALK, name="<b>name</b>", truth=None)))
    text = page.read_text()
    assert "&lt;b&gt;name" in text
    assert "<b>name" not in text.replace("\\u003cb\\u003e", "")
    assert 'src="http' not in text


def test_a_page_tells_no_time_that_nobody_took_and_no_negative_nought(tmp_path):
    result = estimate(WALK)
    page = tmp_path / "x.html"
    write_page(page, result)
    assert "computed" not in page.read_text().split("</table>")[0]
    level = replace(summarise(result, computed_s=1.0), end_w_m=[-0.001, 0.004, -2.0])
    assert dict(level.rows())["end"] == "x 0.00 m, y 0.00 m, z -2.00 m"
    assert dict(level.rows())["computed"] == "in 1.00 s"
