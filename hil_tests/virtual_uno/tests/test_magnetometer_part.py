# SPDX-License-Identifier: GPL-3.0-or-later
"""The simulated magnetometers, held to their data sheets."""

import pytest

QMC, HMC = 0x0D, 0x1E


def little(data):
    return [int.from_bytes(data[at : at + 2], "little", signed=True) for at in range(0, 6, 2)]


def big(data):
    return [int.from_bytes(data[at : at + 2], "big", signed=True) for at in range(0, 6, 2)]


@pytest.fixture
def qmc(bus):
    bus.board.mag.fit("qmc5883l")
    return bus


@pytest.fixture
def hmc(bus):
    bus.board.mag.fit("hmc5883l")
    return bus


def test_each_answers_at_its_own_address_only(qmc):
    assert qmc.transfer(QMC, (0x0D,), 1) == b"\xff"
    with pytest.raises(OSError, match="32"):
        qmc.transfer(HMC, (0x0A,), 3)
    qmc.board.mag.unplug()
    with pytest.raises(OSError, match="32"):
        qmc.transfer(QMC, (0x0D,), 1)


def test_hmc5883l_identifies_itself_and_idles(hmc):
    assert hmc.transfer(HMC, (0x0A,), 3) == b"H43"
    assert hmc.transfer(HMC, (0x00,), 3) == b"\x10\x20\x01"


@pytest.mark.parametrize(
    ("control", "counts"), [(0x0D, 12_000), (0x1D, 3_000)]
)  # 200 Hz, 2 and 8 G
def test_qmc5883l_measures_in_its_ranges(qmc, control, counts):
    qmc.board.mag.feel((20.0, -30.0, 45.0))
    qmc.transfer(QMC, (0x0B, 0x01))
    qmc.transfer(QMC, (0x09, control))
    qmc.board.run(0.02)
    assert qmc.transfer(QMC, (0x06,), 1)[0] & 1
    wanted = [round(gauss * counts) for gauss in (0.2, -0.3, 0.45)]
    assert little(qmc.transfer(QMC, (0x00,), 6)) == wanted


def test_qmc5883l_tells_of_fresh_missed_and_overflowing_data(qmc):
    qmc.transfer(QMC, (0x09, 0x01))  # 10 Hz, 2 G
    qmc.board.run(0.15)
    assert qmc.transfer(QMC, (0x06,), 1) == b"\x01"
    qmc.transfer(QMC, (0x00,), 6)
    assert qmc.transfer(QMC, (0x06,), 1) == b"\x00"
    qmc.board.run(0.25)
    assert qmc.transfer(QMC, (0x06,), 1) == b"\x05"  # one was never read
    qmc.board.mag.feel((300.0, 0.0, 0.0))  # 3 G
    qmc.board.run(0.1)
    assert qmc.transfer(QMC, (0x06,), 1)[0] & 2
    qmc.transfer(QMC, (0x0A, 0x80))
    assert qmc.transfer(QMC, (0x09,), 1) == b"\x00"


@pytest.mark.parametrize(
    ("gain", "counts"), list(enumerate([1370, 1090, 820, 660, 440, 390, 330, 230]))
)
def test_hmc5883l_measures_x_z_y_in_its_gains(hmc, gain, counts):
    hmc.board.mag.feel((20.0, -30.0, 45.0))
    hmc.transfer(HMC, (0x00, 0x18, gain << 5, 0x00))  # 75 Hz, continuous
    hmc.board.run(0.03)
    assert hmc.transfer(HMC, (0x09,), 1)[0] & 1
    wanted = [round(gauss * counts) for gauss in (0.2, 0.45, -0.3)]
    assert big(hmc.transfer(HMC, (0x03,), 6)) == wanted


def test_hmc5883l_measures_once_when_asked_and_marks_what_is_beyond(hmc):
    hmc.board.mag.feel((0.0, 250.0, 0.0))
    hmc.transfer(HMC, (0x02, 0x01))
    hmc.board.run(0.01)
    assert big(hmc.transfer(HMC, (0x03,), 6)) == [0, 0, -4096]
    assert hmc.transfer(HMC, (0x09,), 1) == b"\x00"
    hmc.board.run(0.1)
    assert hmc.transfer(HMC, (0x09,), 1) == b"\x00"  # idle


def test_hmc5883l_pointer_returns_to_the_data_after_them(hmc):
    hmc.transfer(HMC, (0x00, 0x18, 0x20, 0x00))
    hmc.board.run(0.03)
    data = hmc.transfer(HMC, (0x03,), 12)
    assert data[:6] == data[6:]


def test_a_second_magnetometer_is_refused(qmc):
    with pytest.raises(ValueError, match="already"):
        qmc.board.mag.fit("hmc5883l")
