# SPDX-License-Identifier: MIT
"""Settings of a device: read, compared with a file, made to be what that says, or left alone."""

import pytest

from host.tests.fake_bench import Bench
from terazi.control import Balance
from terazi.errors import CommandRefused
from terazi.link.generated.messages import Point
from terazi.link.generated.settings import SETTINGS
from terazi.settings import (
    SettingsFile,
    apply_file,
    differences,
    parse_settings,
    read_device,
    render_settings,
)

POINTS = (Point(0, 1_000, 0), Point(1, 99_000_000, 2_000_000), Point(2, 200_000_000, 4_000_000))


@pytest.fixture
def bench():
    return Bench()


def test_a_device_gives_every_setting(bench):
    values = read_device(bench.link)
    assert list(values) == [one.full_name for one in SETTINGS]
    assert values["scale.max_mg"] == 5_000_000


def test_what_a_device_exports_changes_nothing_in_it(bench):
    values = read_device(bench.link)
    file = parse_settings(render_settings(values), "export")
    assert differences(values, file) == []
    assert apply_file(Balance(bench.link), file) == []
    assert read_device(bench.link) == values


def test_an_export_makes_another_device_alike(bench):
    changes = {"scale.max_mg": 60_000, "scale.interval_mg": 20, "checkweigher.on": 0}
    changes |= {"scale.stable_band_mg": 10, "scale.under_mg": 400, "scale.step_mg": 40}
    changes |= {"scale.decimals": 2, "scale.digit": 2, "chain.order": 1}
    apply_file(Balance(bench.link), SettingsFile(changes, POINTS))
    exported = render_settings(read_device(bench.link))
    other = Bench()
    told = apply_file(Balance(other.link), parse_settings(exported, "export"))
    assert {change.name for change in told} >= {"scale.max_mg", "calibration.points"}
    assert render_settings(read_device(other.link)) == exported


def test_the_order_in_a_file_does_not_matter(bench):
    """A Max of 60 g refuses an e of 1 g, and an e of 20 mg its old band: each waits for others."""
    small = {"scale.max_mg": 60_000, "scale.interval_mg": 20, "scale.stable_band_mg": 10}
    small |= {"scale.under_mg": 400, "scale.step_mg": 40, "scale.decimals": 2, "scale.digit": 2}
    for file in (small, dict(reversed(small.items()))):
        device = Bench()
        apply_file(Balance(device.link), SettingsFile(file))
        assert read_device(device.link).items() >= file.items()


def test_what_a_file_changes_is_told_in_words(bench):
    file = SettingsFile({"scale.max_mg": 3_000_000, "scale.unit": 1, "scale.digit": 1}, POINTS)
    told = [str(change) for change in differences(read_device(bench.link), file)]
    assert told[0] == "scale.max_mg: 5000000 mg (5000 g) -> 3000000 mg (3000 g)"
    assert told[1] == "scale.unit: g -> kg"
    assert told[2].endswith("-> 3 points (0, 2000, 4000 g)")
    assert len(told) == 3


def test_settings_that_contradict_one_another_leave_the_device_as_it_was(bench):
    before = read_device(bench.link)
    with pytest.raises(CommandRefused, match=r"scale\.interval_mg"):
        apply_file(
            Balance(bench.link),
            SettingsFile({"scale.unit": 1, "scale.interval_mg": 400_000}, POINTS),
        )
    assert read_device(bench.link) == before


def test_points_that_the_device_refuses_leave_the_settings_too_as_they_were(bench):
    before = read_device(bench.link)
    crooked = (POINTS[0], Point(1, 300_000_000, 2_000_000), POINTS[2])
    with pytest.raises(CommandRefused):
        apply_file(Balance(bench.link), SettingsFile({"scale.unit": 1}, crooked))
    assert read_device(bench.link) == before
    assert bench.chain.staged is None
