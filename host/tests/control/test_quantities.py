# SPDX-License-Identifier: MIT
"""Quantities as people write them."""

import pytest

from terazi.control.quantities import parse, parse_mass_mg, show_mass
from terazi.errors import UsageError


@pytest.mark.parametrize(
    ("text", "mass_mg"),
    [
        ("500", 500_000),
        ("500g", 500_000),
        (" 0.5 kg ", 500_000),
        ("0.5KG", 500_000),
        (".5", 500),
        ("-2g", -2000),
        ("1e3", 1_000_000),
        ("1lb", 453_592),
        ("16oz", 453_592),
        ("9.80665N", 1_000_000),
        ("1500ug", 2),
    ],
)
def test_masses_are_read_with_and_without_a_unit(text, mass_mg):
    assert parse_mass_mg(text) == mass_mg


def test_times_convert_exactly():
    assert parse("300ms", "us") == 300_000
    assert parse("0.5s", "us") == 500_000
    assert parse("7µs", "us") == 7


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("0,5", "write a point"),
        ("1,000g", "nothing between thousands"),
        ("much", "is no number"),
        ("", "is no number"),
        ("5 s", "no unit s"),
        ("5 stone", "no unit stone; there are ug, mg, g, kg"),
    ],
)
def test_what_is_no_mass_is_refused_with_the_reason(text, words):
    with pytest.raises(UsageError, match=words):
        parse_mass_mg(text)


def test_masses_are_shown_as_finely_as_a_tenth_of_e():
    assert show_mass(1_234_567, 10) == "1 234.567 g"
    assert show_mass(1_234_567, 1000) == "1 234.6 g"
    assert show_mass(-1, 1000) == "0.0 g"
    assert show_mass(2_500_000, 20_000) == "2 500 g"
