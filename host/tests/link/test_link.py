# SPDX-License-Identifier: MIT
"""A conversation over a pseudo-terminal with a test double, through pyserial."""

import os

import pytest

from host.tests.fake_chain import RATE_HZ
from host.tests.fake_device import FakeDevice
from terazi.errors import (
    CommandRefused,
    FingerprintMismatch,
    NoAnswer,
    PortBusy,
    PortMissing,
    PortVanished,
    UsageError,
)
from terazi.link import Link, SerialTransport, open_link
from terazi.link.generated.messages import (
    FINGERPRINT,
    GetInfo,
    Result,
    Sample,
    SetStream,
    Status,
    Tare,
)


def test_link_gets_the_hello_that_follows_the_reset():
    with FakeDevice() as device, open_link(device.path) as link:
        assert link.hello().protocol_fingerprint == FINGERPRINT
        assert device.resets == 1
        assert GetInfo.ID not in device.commands


def test_link_asks_for_hello_where_opening_does_not_reset():
    with FakeDevice(hello_at_reset=False) as device, open_link(device.path) as link:
        assert link.hello(timeout_s=0.1).fir_taps == 32
        assert GetInfo.ID in device.commands


def test_link_does_not_wait_for_a_hello_that_will_not_come():
    with FakeDevice(hello_at_reset=False) as device, open_link(device.path) as link:
        assert link.hello(timeout_s=3600.0).fir_taps == 32
        assert GetInfo.ID in device.commands


def test_link_streams_samples_at_the_devices_rate_without_loss():
    with FakeDevice() as device, open_link(device.path) as link:
        samples = []
        for received in link.messages():
            if isinstance(received.message, Sample):
                samples.append(received)
            if len(samples) == 300:
                break
        assert link.stream.frames_lost == link.stream.frames_bad == 0
    elapsed_s = (samples[-1].device_us - samples[0].device_us) / 1e6
    assert 299 / elapsed_s == pytest.approx(RATE_HZ, rel=1e-4)
    host_s = [one.host_s for one in samples]
    assert host_s == sorted(host_s)


def test_link_taps_every_byte_before_decoding():
    heard = bytearray()
    with (
        FakeDevice() as device,
        open_link(device.path, on_bytes=lambda _s, data: heard.extend(data)) as link,
    ):
        link.hello()
        link.poll(0.1)
        assert len(heard) == link.stream.bytes_in > 0


def test_link_request_is_answered_and_keeps_what_came_meanwhile():
    with FakeDevice() as device, open_link(device.path) as link:
        link.hello()
        ack = link.request(SetStream(mask=15))
        assert (ack.command, ack.result) == (SetStream.ID, Result.OK)
        kinds = {type(one.message) for one in link.poll(0.1)}
        assert Sample in kinds


def test_link_repeats_a_command_whose_ack_was_lost():
    with FakeDevice(ignore_commands=2) as device, open_link(device.path) as link:
        link.hello()
        assert link.request(SetStream(mask=1), timeout_s=0.15).result == Result.OK
        assert device.commands.count(SetStream.ID) == 3


def test_link_says_when_a_command_is_never_acknowledged():
    with FakeDevice(answers=False) as device, open_link(device.path) as link:
        link.hello()
        with pytest.raises(NoAnswer, match="does not acknowledge Tare after 2 attempts"):
            link.request(Tare(), timeout_s=0.05, attempts=2)


def test_link_names_a_command_that_the_board_refuses():
    class Unheard:
        ID = 0x70

        def pack(self):
            return b""

    with FakeDevice() as device, open_link(device.path) as link:
        link.hello()
        with pytest.raises(CommandRefused, match="refuses Unheard: unknown command"):
            link.command(Unheard())


def test_link_gives_the_boards_health():
    with FakeDevice() as device, open_link(device.path) as link:
        status = link.status()
    assert isinstance(status, Status)
    assert status.converter_rate_hz_q16 / 65536 == pytest.approx(RATE_HZ, abs=1e-3)


def test_link_refuses_another_fingerprint():
    with (
        FakeDevice(fingerprint=FINGERPRINT ^ 1) as device,
        open_link(device.path) as link,
        pytest.raises(FingerprintMismatch, match=rf"0x{FINGERPRINT ^ 1:04X}.*0x{FINGERPRINT:04X}"),
    ):
        link.hello()


@pytest.mark.parametrize(
    ("speak", "words"),
    [
        ("nothing", "does not answer"),
        ("other", "none of them a frame"),
        ("garbage", "none of them a frame"),
    ],
)
def test_link_says_what_it_heard_when_no_terazi_answers(speak, words, monkeypatch):
    monkeypatch.setattr("terazi.link.link.ANSWER_S", 0.05)
    with (
        FakeDevice(speak=speak) as device,
        open_link(device.path) as link,
        pytest.raises(NoAnswer, match=words) as caught,
    ):
        link.hello(timeout_s=0.1)
    assert device.path in str(caught.value)
    assert "terazi flash" in caught.value.remedy


def test_link_says_when_the_port_vanishes_and_keeps_what_came_before():
    samples = []

    def take_all(link):
        for one in link.messages():
            if isinstance(one.message, Sample):
                samples.append(one.message.conversion)

    with (
        FakeDevice(vanish_after=40) as device,
        open_link(device.path) as link,
        pytest.raises(PortVanished, match="vanished") as caught,
    ):
        take_all(link)
    assert caught.value.exit_code == 5
    assert samples
    assert samples == list(range(1, len(samples) + 1))


def test_transport_names_a_missing_port(tmp_path):
    with pytest.raises(PortMissing, match="there is no port") as caught:
        SerialTransport(str(tmp_path / "ttyACM9"))
    assert "terazi ports" in caught.value.remedy


def test_transport_names_a_dangling_link(tmp_path):
    link = tmp_path / "board"
    link.symlink_to(tmp_path / "gone")
    with pytest.raises(PortMissing, match=r"is a link to .*gone, which is not there"):
        SerialTransport(str(link))


def test_transport_names_what_is_no_serial_port(tmp_path):
    file = tmp_path / "file"
    file.write_text("no port")
    with pytest.raises(PortMissing, match="cannot be opened as a serial port"):
        SerialTransport(str(file))


def test_transport_follows_a_link_to_a_port(tmp_path):
    with FakeDevice() as device:
        (tmp_path / "board").symlink_to(device.path)
        with open_link(str(tmp_path / "board")) as link:
            assert link.hello().gain == 128


def test_transport_names_a_busy_port():
    with (
        FakeDevice() as device,
        open_link(device.path),
        pytest.raises(PortBusy, match="in use by another program") as caught,
    ):
        SerialTransport(device.path)
    assert caught.value.exit_code == 4


def test_transport_names_a_missing_permission(monkeypatch):
    import errno

    import serial

    def refuse(*_words, **_more):
        raise serial.SerialException(errno.EACCES, "could not open port")

    monkeypatch.setattr(serial, "Serial", refuse)
    with pytest.raises(PortBusy, match="permission denied: /dev/ttyACM0") as caught:
        SerialTransport("/dev/ttyACM0")
    assert "usermod -aG dialout" in caught.value.remedy


def test_transport_names_an_impossible_baud():
    with FakeDevice() as device, pytest.raises(UsageError, match="cannot run at -5 baud"):
        SerialTransport(device.path, -5)


def test_transport_says_when_it_cannot_write_to_a_vanished_port():
    device = FakeDevice()
    transport = SerialTransport(device.path)
    device._vanish()
    with pytest.raises(PortVanished):
        transport.write(b"x")
    with pytest.raises(PortVanished):
        transport.read(0.1)
    transport.close()
    transport.close()


class Simulated:
    """A transport whose clock moves only when it is read: time-outs are the transport's."""

    def __init__(self):
        self.elapsed_s = 1000.0
        self.written = b""

    def read(self, timeout_s):
        self.elapsed_s += timeout_s
        return b""

    def write(self, data):
        self.written += data

    def now_s(self):
        return self.elapsed_s

    def close(self):
        pass


def test_link_takes_its_time_from_the_transport():
    transport = Simulated()
    with Link(transport) as link, pytest.raises(NoAnswer, match="the board does not answer"):
        link.hello(timeout_s=3600.0)
    assert transport.elapsed_s > 4600.0
    assert transport.written


def test_ports_prefers_boards_and_insists_on_one(monkeypatch):
    from serial.tools.list_ports_common import ListPortInfo

    from terazi.link import find_port, list_ports
    from terazi.link import ports as module

    def port(path, vid=None, pid=None):
        info = ListPortInfo(path)
        info.vid, info.pid = vid, pid
        return info

    there = [port("/dev/ttyS0"), port("/dev/ttyACM0", 0x2341, 0x0043)]
    monkeypatch.setattr(module.pyserial_ports, "comports", lambda: there)
    assert [one.path for one in list_ports()] == ["/dev/ttyACM0", "/dev/ttyS0"]
    assert list_ports()[0].board == "Arduino Uno"
    assert find_port() == "/dev/ttyACM0"
    assert find_port("/dev/other") == "/dev/other"

    there.append(port("/dev/ttyUSB0", 0x1A86, 0x7523))
    with pytest.raises(UsageError, match="/dev/ttyACM0, /dev/ttyUSB0"):
        find_port()
    del there[1:]
    with pytest.raises(PortMissing, match="no Arduino is plugged in"):
        find_port()


def test_double_leaves_no_open_files():
    before = len(os.listdir("/proc/self/fd"))
    with FakeDevice() as device, open_link(device.path) as link:
        link.hello()
    assert len(os.listdir("/proc/self/fd")) == before


@pytest.mark.parametrize("baud", [115_200, 500_000, 1_000_000])
@pytest.mark.parametrize("hello_at_reset", [True, False])
def test_link_finds_the_rate_that_the_board_speaks(baud, hello_at_reset):
    with FakeDevice(baud=baud, hello_at_reset=hello_at_reset) as device:
        with open_link(device.path) as link:
            link.hello()
            assert link.baud == baud
            link.command(SetStream(mask=0))
            assert link.stream.frames_bad == 0
        assert device.resets == 1


def test_link_finds_the_rate_of_a_board_that_streams_nothing(monkeypatch):
    with FakeDevice(baud=1_000_000, silent_after=0) as device, open_link(device.path) as link:
        link.hello(timeout_s=0.3)
        assert link.baud == 1_000_000


def test_link_names_the_rates_at_which_nobody_answered(monkeypatch):
    monkeypatch.setattr("terazi.link.link.ANSWER_S", 0.02)
    with (
        FakeDevice(speak="nothing") as device,
        open_link(device.path) as link,
        pytest.raises(NoAnswer, match="does not answer at 115200, 500000 or 1000000 baud"),
    ):
        link.hello(timeout_s=0.05)


def test_link_keeps_to_a_rate_that_was_named(monkeypatch):
    monkeypatch.setattr("terazi.link.link.ANSWER_S", 0.05)
    with (
        FakeDevice(baud=500_000) as device,
        open_link(device.path, 115_200) as link,
        pytest.raises(NoAnswer, match="at 115200 baud"),
    ):
        link.hello(timeout_s=0.2)
    with FakeDevice(baud=500_000) as device, open_link(device.path, 500_000) as link:
        assert link.hello().gain == 128
