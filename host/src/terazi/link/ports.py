# SPDX-License-Identifier: MIT
"""The serial ports of this computer, and which of them look like an Arduino Uno."""

from dataclasses import dataclass

from serial.tools import list_ports as pyserial_ports

from terazi.errors import PortMissing, UsageError

# USB vendors of the Uno and of the bridges on its clones.
BOARD_BY_VENDOR = {
    0x2341: "Arduino",
    0x2A03: "Arduino (arduino.org)",
    0x1A86: "clone with CH340",
    0x0403: "clone with FTDI bridge",
    0x10C4: "clone with CP210x",
}
UNO_PRODUCTS = {(0x2341, 0x0043), (0x2341, 0x0001), (0x2341, 0x0243), (0x2A03, 0x0043)}


@dataclass(frozen=True)
class Port:
    """One serial port; `board` is empty if nothing says that an Arduino sits there."""

    path: str
    board: str
    description: str
    usb_id: str

    @property
    def is_candidate(self) -> bool:
        return bool(self.board)


def list_ports() -> list[Port]:
    """Ports that are there now, those that look like a board first."""
    ports = [_port(info) for info in pyserial_ports.comports()]
    return sorted(ports, key=lambda port: (not port.is_candidate, port.path))


def find_port(named: str | None = None) -> str:
    """The port that was named, or else the only one that looks like a board."""
    if named:
        return named
    candidates = [port for port in list_ports() if port.is_candidate]
    if not candidates:
        raise PortMissing(
            "no Arduino is plugged in",
            remedy="Plug the board in, or name its port: `terazi ports` lists all of them.",
        )
    if len(candidates) > 1:
        names = ", ".join(port.path for port in candidates)
        raise UsageError(f"several boards are plugged in: {names}", remedy="Name one of them.")
    return candidates[0].path


def _port(info) -> Port:
    if info.vid is None:
        board, usb_id = "", ""
    else:
        usb_id = f"{info.vid:04x}:{info.pid:04x}"
        is_uno = (info.vid, info.pid) in UNO_PRODUCTS
        board = "Arduino Uno" if is_uno else BOARD_BY_VENDOR.get(info.vid, "")
    description = info.description if info.description not in (None, "n/a") else ""
    return Port(info.device, board, description, usb_id)
