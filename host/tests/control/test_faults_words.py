# SPDX-License-Identifier: MIT
"""Every fault that a board may tell has words and a remedy."""

import pytest

from terazi.control import faults
from terazi.link.generated.messages import FaultFlag


@pytest.mark.parametrize("flag", list(FaultFlag), ids=lambda flag: flag.name)
def test_fault_has_words_and_a_remedy(flag):
    ((name, words, remedy),) = faults.explained(flag)
    assert name == flag.name.lower().replace("_", " ")
    assert words
    assert remedy.endswith((".", "`."))


@pytest.mark.parametrize("flag", [FaultFlag.IMU_LOST, FaultFlag.ASKEW], ids=lambda flag: flag.name)
def test_faults_of_the_imu_spoil_no_weight(flag):
    assert not flag & faults.SPOILING


def test_fault_of_a_newer_board_is_told_by_its_number():
    assert faults.names(1 << 15) == ["unknown fault 0x8000"]
