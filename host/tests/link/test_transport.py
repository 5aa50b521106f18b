# SPDX-License-Identifier: MIT
"""A serial port whose other end is gone."""

import os
import tty

import pytest

from terazi.errors import PortVanished
from terazi.link import SerialTransport


def test_a_port_whose_other_end_is_gone_has_vanished():
    master, slave = os.openpty()
    tty.setraw(slave)
    transport = SerialTransport(os.ttyname(slave))
    os.close(slave)
    os.write(master, b"here")
    assert transport.read(1.0) == b"here"
    os.close(master)
    with pytest.raises(PortVanished):
        transport.read(1.0)
    transport.close()
