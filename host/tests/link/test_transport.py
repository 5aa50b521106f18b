# SPDX-License-Identifier: MIT
"""A serial port that gives nothing for once, and one that is gone."""

import os
import tty

import pytest
import serial

from terazi.errors import PortVanished
from terazi.link import SerialTransport
from terazi.link.transport import EMPTY_READS_S

EMPTY = serial.SerialException(
    "device reports readiness to read but returned no data "
    "(device disconnected or multiple access on port?)"
)


@pytest.fixture
def line():
    """A port, and the other end of it."""
    master, slave = os.openpty()
    tty.setraw(slave)
    transport = SerialTransport(os.ttyname(slave))
    yield transport, master
    transport.close()
    os.close(slave)
    os.close(master)


def raise_empty(_count):
    raise EMPTY


def test_a_line_that_was_flushed_under_a_read_goes_on(line, monkeypatch):
    transport, master = line
    for _ in range(3):  # each in its turn, with bytes in between
        with monkeypatch.context() as patch:
            patch.setattr(transport._serial, "read", raise_empty)
            assert [transport.read(0.0) for _ in range(5)] == [b""] * 5
        os.write(master, b"here")
        assert transport.read(1.0) == b"here"


def test_a_port_that_gives_nothing_for_long_has_vanished(line, monkeypatch):
    transport, _master = line
    clock_s = iter([0.0, 0.0, 0.1, EMPTY_READS_S + 0.1])
    monkeypatch.setattr(transport._serial, "read", raise_empty)
    monkeypatch.setattr(transport, "now_s", lambda: next(clock_s))
    assert [transport.read(0.0) for _ in range(2)] == [b"", b""]
    with pytest.raises(PortVanished):
        transport.read(0.0)
