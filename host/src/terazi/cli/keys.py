# SPDX-License-Identifier: MIT
"""Single keys from a terminal, without waiting for them. Where there is none, no key is pressed."""

import sys
from types import TracebackType

try:
    import select
    import termios
    import tty
except ImportError:  # Windows
    termios = None


class Keys:
    """A context in which keys come one by one and unseen; ctrl-C stays an interruption."""

    def __init__(self) -> None:
        self._before = None
        self.is_there = termios is not None and sys.stdin is not None and sys.stdin.isatty()

    def __enter__(self) -> "Keys":
        if self.is_there:
            self._file = sys.stdin.fileno()
            self._before = termios.tcgetattr(self._file)
            # Not the default, which would throw away a key that was pressed early.
            tty.setcbreak(self._file, termios.TCSADRAIN)
        return self

    def __exit__(
        self,
        _kind: type[BaseException] | None,
        _error: BaseException | None,
        _where: TracebackType | None,
    ) -> None:
        if self._before is not None:
            termios.tcsetattr(self._file, termios.TCSADRAIN, self._before)

    def pressed(self) -> str:
        """The keys pressed since the last call, "" if there were none."""
        if not self.is_there:
            return ""
        import os

        came = b""
        while select.select([self._file], [], [], 0)[0]:
            new = os.read(self._file, 64)
            if not new:  # the terminal is gone
                self.is_there = False
                break
            came += new
        return came.decode(errors="replace")
