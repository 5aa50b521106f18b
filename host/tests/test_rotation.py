# SPDX-License-Identifier: MIT
"""Quaternions as angles, on poses that need no computing."""

import numpy as np
import pytest

from terazi import rotation

HALF = np.sqrt(0.5)


@pytest.mark.parametrize(
    ("quat_wb", "angles_deg", "tilt_deg"),
    [
        ((1, 0, 0, 0), (0, 0, 0), 0),
        ((HALF, HALF, 0, 0), (90, 0, 0), 90),  # body y stands up
        ((HALF, 0, HALF, 0), (0, 90, 0), 90),  # body x points down
        ((HALF, 0, 0, HALF), (0, 0, 90), 0),  # body x points north
        ((0, 1, 0, 0), (180, 0, 0), 180),  # upside down
        ((0.98, 0, 0, 0), (0, 0, 0), 0),  # norm is not one
        ((-HALF, -HALF, 0, 0), (90, 0, 0), 90),  # the same attitude with the other sign
    ],
)
def test_angles_of_poses_that_a_hand_can_hold(quat_wb, angles_deg, tilt_deg):
    quats = np.array([quat_wb], dtype=float)
    assert rotation.tilt_deg(quats)[0] == pytest.approx(tilt_deg, abs=1e-9)
    found = rotation.euler_deg(quats)[0]
    if abs(angles_deg[1]) == 90:  # roll and yaw are one there
        assert found[1] == pytest.approx(angles_deg[1], abs=1e-5)
    else:
        assert found == pytest.approx(angles_deg, abs=1e-9)


def test_vertical_turns_with_the_board():
    assert rotation.up_b(np.array([[HALF, HALF, 0, 0]])) == pytest.approx(np.array([[0, 1, 0]]))
