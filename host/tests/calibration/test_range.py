# SPDX-License-Identifier: MIT
"""Max and e: what is refused, and what follows them."""

import pytest

from terazi.calibration.range import changes, division_of, why_not
from terazi.cshared import SCALE_UNITS, Scale
from terazi.design import scale

FACTORY = {
    f"scale.{name}": scale.config()[name]
    for name in (
        "max_mg",
        "interval_mg",
        "under_mg",
        "step_mg",
        "stable_band_mg",
        "unit",
        "decimals",
        "digit",
    )
}


@pytest.mark.parametrize(
    ("max_mg", "interval_mg", "words"),
    [
        (0, 1, "Max lies between"),
        (500_000_001, 1000, "Max lies between"),
        (1000, 0, "e is 1 mg at least"),
        (16_000, 1001, "too coarse"),
        (5_000_000, 3000, "2.00 g or 5.00 g"),
        (500_000_000, 10, "too fine"),
    ],
)
def test_a_pair_that_makes_no_scale_is_refused_with_what_would(max_mg, interval_mg, words):
    assert words in why_not(max_mg, interval_mg)


@pytest.mark.parametrize(
    ("max_mg", "interval_mg"),
    [(5_000_000, 1000), (200_000, 10), (60_000_000, 20_000), (300, 2), (500_000_000, 100_000)],
)
def test_every_pair_that_is_taken_makes_a_scale(max_mg, interval_mg):
    assert why_not(max_mg, interval_mg) == ""
    config = scale.config()
    for name, value in changes(max_mg, interval_mg, FACTORY).items():
        config[name.removeprefix("scale.")] = value
    Scale(config)  # raises where scale.h refuses it
    assert (config["max_mg"], config["interval_mg"]) == (max_mg, interval_mg)


def test_limits_stay_so_many_e_and_the_display_shows_e():
    changed = changes(2_000_000, 500, FACTORY)
    for name in ("scale.stable_band_mg", "scale.under_mg", "scale.step_mg"):
        assert changed[name] * 2 == FACTORY[name]
    assert (changed["scale.decimals"], changed["scale.digit"]) == (1, 5)


def test_nothing_changes_where_max_and_e_are_as_they_were():
    assert changes(5_000_000, 1000, FACTORY) == {}


def test_what_gram_cannot_show_is_shown_in_kilogram():
    assert division_of(20_000, "g") == ("kg", 2, 2)
    assert "KG" in SCALE_UNITS
    assert division_of(1000, "lb") == ("kg", 3, 1)
