# SPDX-License-Identifier: MIT
"""What can go wrong, each with its exit code and, where there is one, its remedy.

The command line prints `str(error)` on one line, the remedy on the next, and exits with
`error.exit_code`. The codes are a public interface; scripts rely on them.
"""


class TeraziError(Exception):
    """Any fault that has a name. `remedy` says what the reader can do about it."""

    exit_code = 1

    def __init__(self, message: str, *, remedy: str = "") -> None:
        super().__init__(message)
        self.remedy = remedy


class UsageError(TeraziError):
    """The command makes no sense as given, or a tool that it needs is missing."""

    exit_code = 2


class PortMissing(TeraziError):
    """There is no such serial port, or no board at all."""

    exit_code = 3


class PortBusy(TeraziError):
    """The port is there, but another program or a missing permission keeps it."""

    exit_code = 4


class PortVanished(TeraziError):
    """The port went away while in use: a pulled cable, a board that lost power."""

    exit_code = 5


class NoAnswer(TeraziError):
    """Nothing that speaks Terazi's protocol answers at the port."""

    exit_code = 6


class FingerprintMismatch(TeraziError):
    """The other side speaks another version of the protocol."""

    exit_code = 7

    def __init__(self, theirs: int, ours: int, *, whose: str, remedy: str = "") -> None:
        super().__init__(
            f"{whose} speaks protocol 0x{theirs:04X}, this host speaks 0x{ours:04X}",
            remedy=remedy,
        )
        self.theirs = theirs
        self.ours = ours


class CannotWrite(TeraziError):
    """A file cannot be written: full disk, no permission, or it exists already."""

    exit_code = 8


class CannotRead(TeraziError):
    """A file cannot be read, or is not what it should be."""

    exit_code = 9


class ReplayDisagrees(TeraziError):
    """A recording's answers are not those that this host computes."""

    exit_code = 10


class FlashFailed(TeraziError):
    """The board could not be programmed."""

    exit_code = 11


class DesignMisses(TeraziError):
    """A filter was designed, but does not do what was wished for."""

    exit_code = 12


class CommandRefused(TeraziError):
    """The board understood a command and said no; `result` is its word for it."""

    exit_code = 6

    def __init__(self, message: str, *, remedy: str = "", result: int | None = None) -> None:
        super().__init__(message, remedy=remedy)
        self.result = result


class Aborted(TeraziError):
    """The one at the keyboard ended a dialogue before its end; the board is as it was."""

    exit_code = 130


class CalibrationRefused(TeraziError):
    """Points that contradict one another, or sense."""

    exit_code = 13
