# SPDX-License-Identifier: MIT
"""How a magnetometer sits beside the IMU, found from the field's dip in positions at rest."""

import numpy as np
import pytest

from terazi.calibration.imu.axes import NAMES, find_mag_axes
from terazi.calibration.imu.rehearsal import FACES, SLANTS, turn, unit
from terazi.cshared import ImuTurn

IMU = 20  # nx_pz


def positions(mag_code, *, dip_deg=62.0, noise=0.01, count=12, seed=2):
    """(ups, fields) along the parts' axes of a board with any heading in each position."""
    rng = np.random.default_rng(seed)
    ups, fields = [], []
    parts = [
        ImuTurn(code).block(np.eye(3, dtype=np.int16)).astype(float) for code in (IMU, mag_code)
    ]
    for up in (*FACES, *SLANTS)[:count]:
        up_b = unit(unit(up) + rng.normal(0, 0.04, 3))
        level = turn(up_b * rng.uniform(0, 6.28)) @ unit(np.cross(up_b, rng.normal(size=3)))
        dip = np.radians(dip_deg)
        field_b = np.cos(dip) * level - np.sin(dip) * up_b + rng.normal(0, noise, 3)
        ups.append(parts[0] @ up_b)  # the rows are where the part's axes lie
        fields.append(1500 * parts[1] @ field_b)
    return ups, fields


@pytest.mark.parametrize("code", list(NAMES))
def test_each_of_the_24_ways_is_found(code):
    axes = find_mag_axes(*positions(code), IMU, 8)
    assert axes.is_known
    assert axes.best == code
    assert axes.is_wrong == (code != 8)
    if code != 8:
        assert f"sits as {NAMES[code]}, not as px_py" in axes.note


def test_a_right_one_is_not_spoken_of():
    axes = find_mag_axes(*positions(33), IMU, 33)
    assert axes.note == ""


def test_a_field_that_differs_from_place_to_place_says_nothing():
    axes = find_mag_axes(*positions(8, noise=0.6), IMU, 12)
    assert not axes.is_known
    assert not axes.is_wrong
    assert "does not show" in axes.note


def test_too_few_positions_say_nothing():
    assert find_mag_axes(*positions(8, count=5), IMU, 8) is None
