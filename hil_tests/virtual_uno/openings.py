# SPDX-License-Identifier: GPL-3.0-or-later
"""Who has the pseudo-terminal open: every opening and closing, however quick, in order.

A hang-up seen by poll() is not enough: a program that closes the port and another that opens it
at once would pass unnoticed between two looks. The kernel's inotify keeps both events, though it
merges equal neighbours; so poll() has the last word on whether anybody holds it now.
"""

import ctypes
import os
import select
import struct

IN_CLOSE_WRITE, IN_CLOSE_NOWRITE, IN_OPEN = 0x08, 0x10, 0x20  # <sys/inotify.h>
EVENT = struct.Struct("iIII")  # watch, mask, cookie, length of the name that follows
READ_BYTES = 65536


class Openings:
    """Watches the openings of the slave at ``path`` of a pseudo-terminal's ``master``."""

    def __init__(self, master, path):
        libc = ctypes.CDLL(None, use_errno=True)
        self._fd = libc.inotify_init1(os.O_NONBLOCK | os.O_CLOEXEC)
        mask = IN_OPEN | IN_CLOSE_WRITE | IN_CLOSE_NOWRITE
        if self._fd < 0 or libc.inotify_add_watch(self._fd, os.fsencode(path), mask) < 0:
            code = ctypes.get_errno()
            raise OSError(code, f"cannot watch for openings: {os.strerror(code)}", path)
        self._poll = select.poll()
        self._poll.register(master, 0)
        self._holders = 0

    def close(self):
        """Stop watching."""
        os.close(self._fd)

    @property
    def held(self):
        """Whether anybody had it open at the last look."""
        return self._holders > 0

    def look(self):
        """What happened since the last look: a list of "opened" and "closed".

        Only the first opening and the last closing count, as with the line DTR.
        """
        masks = list(self._masks())
        held_now = self._held_now()
        while more := list(self._masks()):  # until the poll is newer than every event
            masks += more
            held_now = self._held_now()
        happened = []
        for mask in masks:
            if mask & IN_OPEN:
                self._holders += 1
                if self._holders == 1:
                    happened.append("opened")
            elif mask & (IN_CLOSE_WRITE | IN_CLOSE_NOWRITE) and self._holders:
                self._holders -= 1
                if self._holders == 0:
                    happened.append("closed")
        if held_now and not self._holders:
            self._holders = 1
            if happened:  # two openings were merged into one, and one of them was closed
                happened.pop()
            else:
                happened.append("opened")
        elif not held_now and self._holders:
            self._holders = 0
            happened.append("closed")
        return happened

    def forget(self):
        """Events since the last look were our own doing."""
        for _ in self._masks():
            pass

    def _held_now(self):
        return not any(event & select.POLLHUP for _, event in self._poll.poll(0))

    def _masks(self):
        try:
            data = os.read(self._fd, READ_BYTES)
        except BlockingIOError:
            return
        at = 0
        while at < len(data):
            _, mask, _, name_length = EVENT.unpack_from(data, at)
            yield mask
            at += EVENT.size + name_length
