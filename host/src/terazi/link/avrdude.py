# SPDX-License-Identifier: MIT
"""avrdude, run and watched: its progress as numbers, its complaints as one clear error.

avrdude 6.3 to 8.x word things differently; what is looked for here they have in common. It
cannot be left alone: when the port goes away under it, 7.1 reads for ever at full load; when the
board falls silent, it tries again for many minutes; and its exit code is 1 whatever happened.
"""

import os
import queue
import re
import shutil
import subprocess
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from serial.tools import list_ports

from terazi.errors import (
    CannotWrite,
    FlashFailed,
    PortBusy,
    PortMissing,
    PortVanished,
    TeraziError,
    UsageError,
)

PART = "atmega328p"
PART_SIGNATURE = "1E950F"  # ATmega328P datasheet, section 27.3
PROGRAMMER = "arduino"  # STK500 version 1, which optiboot speaks, with a reset by DTR

BAR_MARKS = 50  # avrdude's progress bar, from nothing to 100 %
STAGES = {b"Writing | ": "writing", b"Reading | ": "verifying"}

WATCH_S = 0.2  # how often the port is looked after while avrdude says nothing
# Without a step forward for so long, nothing will come any more: a page takes 20 ms, and the boot
# loader answers within 1 s or, wrong speed, never (7.1: ten attempts of up to 5 s).
PATIENCE_S = 20.0
EXIT_S = 5.0  # from the end of its output to the end of the process

REPLUG = "Plug the board in again and repeat: its boot loader is unharmed."

OnProgress = Callable[[str, float], None]


@dataclass(frozen=True)
class Run:
    """A finished run of avrdude: all that it said, and how far it had come."""

    code: int
    said: str
    stage: str  # "" until it writes, then "writing", then "verifying"
    done: float  # of that stage, 0..1


class Progress:
    """Follows avrdude's progress bars in its output, fed in pieces of any size."""

    def __init__(self, on_progress: OnProgress | None = None) -> None:
        self.stage = ""
        self.done = 0.0
        self._on_progress = on_progress
        self._line = b""

    def feed(self, chunk: bytes) -> None:
        for byte in chunk:
            if byte in b"\r\n":
                self._line = b""
                continue
            self._line += bytes((byte,))
            self._look()

    def _look(self) -> None:
        for head, stage in STAGES.items():
            if self._line.startswith(head):
                bar = self._line[len(head) :].split(b"|")[0]
                self._step(stage, min(bar.count(b"#") / BAR_MARKS, 1.0))

    def _step(self, stage: str, done: float) -> None:
        # Before it writes, avrdude 6.3 draws a bar for reading the signature.
        if stage == "verifying" and not self.stage:
            return
        if (stage, done) == (self.stage, self.done):
            return
        self.stage, self.done = stage, done
        if self._on_progress is not None:
            self._on_progress(stage, done)


def find_avrdude() -> str:
    """The program's path. Raises UsageError with the way to get it."""
    found = shutil.which("avrdude")
    if found is None:
        raise UsageError(
            "avrdude is not installed",
            remedy="Install it (Debian, Ubuntu: apt install avrdude; macOS: brew install "
            "avrdude) or put the Arduino IDE's on PATH.",
        )
    return found


def write_flash(
    port: str, hex_path: Path, *, baud: int, log: Path, on_progress: OnProgress | None = None
) -> None:
    """Write a hex file through the boot loader and verify it.

    All that avrdude says goes to `log`. Raises the error that fits what went wrong.
    """
    command = [find_avrdude(), "-p", PART, "-c", PROGRAMMER, "-P", port, "-b", str(baud)]
    # -D: optiboot erases page by page as it writes, and has no chip erase.
    command += ["-D", "-U", f"flash:w:{hex_path}:i"]
    try:
        with log.open("wb") as log_file:
            log_file.write(f"$ {' '.join(command)}\n".encode())
            run = _watched(command, port, log_file, Progress(on_progress))
    except OSError as error:
        raise CannotWrite(f"cannot write {log}: {error.strerror}") from error
    if run.code != 0 or "verified" not in run.said:
        error = diagnose(run, port, baud)
        error.remedy = f"{error.remedy} What avrdude said: {log}".strip()
        raise error


def _watched(command: list[str], port: str, log: BinaryIO, progress: Progress) -> Run:
    """Run avrdude to its end, or end it when the port is gone or nothing moves any more."""
    process = subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    chunks: queue.Queue[bytes] = queue.Queue()
    reader = threading.Thread(target=_pump, args=(process.stdout, chunks), daemon=True)
    reader.start()
    said = b""
    reached, moved_s = None, 0.0
    try:
        while True:
            if reached != (progress.stage, progress.done):
                reached, moved_s = (progress.stage, progress.done), time.monotonic()
            elif time.monotonic() - moved_s > PATIENCE_S:
                break
            try:
                chunk = chunks.get(timeout=WATCH_S)
            except queue.Empty:
                if not port_is_there(port):
                    break
                continue
            if not chunk:
                process.wait(EXIT_S)
                break
            said += chunk
            log.write(chunk)
            log.flush()
            progress.feed(chunk)
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()
        reader.join()
        process.stdout.close()
    return Run(process.returncode, said.decode("utf-8", "replace"), progress.stage, progress.done)


def _pump(source: BinaryIO, chunks: "queue.Queue[bytes]") -> None:
    """Hand on what comes from avrdude, as it comes; an empty chunk is the end."""
    while chunk := os.read(source.fileno(), 4096):
        chunks.put(chunk)
    chunks.put(b"")


def port_is_there(port: str) -> bool:
    if os.name == "posix":
        return os.path.exists(port)
    return port.upper() in {info.device.upper() for info in list_ports.comports()}


def diagnose(run: Run, port: str, baud: int) -> TeraziError:
    """The error that a failed run of avrdude amounts to."""
    said = run.said
    reached = f"{run.stage}, at {run.done:.0%}" if run.stage else "before anything was written"
    if _has(said, r"permission denied"):
        return PortBusy(
            f"permission denied: {port}",
            remedy="Add yourself to the dialout group: sudo usermod -aG dialout $USER; then log "
            "out and in.",
        )
    if _has(said, r"(device|resource) (or resource )?busy|access is denied"):
        return PortBusy(
            f"{port} is in use by another program",
            remedy="Close the Arduino IDE's monitor or whatever else has it open.",
        )
    if not port_is_there(port):
        if _has(said, r"(can't|cannot) open (device|port)"):
            return PortMissing(
                f"there is no port {port}", remedy="`terazi ports` lists those that there are."
            )
        return PortVanished(f"{port} went away while being flashed ({reached})", remedy=REPLUG)
    if (wrong := _wrong_signature(said)) is not None:
        return FlashFailed(
            f"the chip at {port} is no ATmega328P: {wrong}",
            remedy="Terazi's firmware is for the Arduino Uno and boards with its chip.",
        )
    if _has(said, r"verification (error|mismatch)|content mismatch"):
        return FlashFailed(
            f"{port} was written, but does not read back the same",
            remedy="Try again; if it stays so, the chip's flash is worn or its supply is weak.",
        )
    if _has(said, r"input/output error|no such device|(read|write) error"):
        return PortVanished(f"{port} broke off while being flashed ({reached})", remedy=REPLUG)
    if run.stage:
        return FlashFailed(
            f"{port} stopped answering while being flashed ({reached})", remedy=REPLUG
        )
    if _has(said, r"not in sync|not responding|unable to open programmer|protocol error"):
        return _no_boot_loader(port, baud)
    if complaint := _last_complaint(said):
        return FlashFailed(f"avrdude could not program {port}: {complaint}")
    return _no_boot_loader(port, baud)


def _no_boot_loader(port: str, baud: int) -> FlashFailed:
    return FlashFailed(
        f"no boot loader answers at {port} with {baud} baud",
        remedy="Is it an Uno? An old Nano or Duemilanove wants --baud 57600. If so, press its "
        "reset button and try again; without a boot loader it needs a programmer.",
    )


def _wrong_signature(said: str) -> str | None:
    """What chip is there instead, if avrdude was told of another than the Uno's."""
    found = re.search(
        r"device signature = (?:0x)?([0-9a-f]{2} ?[0-9a-f]{2} ?[0-9a-f]{2})(?: \(([^)]*)\))?",
        said,
        re.IGNORECASE,
    )
    if found is None:
        return None
    signature = found[1].replace(" ", "").upper()
    if signature == PART_SIGNATURE:
        return None
    name = f" ({found[2]})" if found[2] else ""
    return f"its signature is 0x{signature}{name}, not 0x{PART_SIGNATURE}"


def _last_complaint(said: str) -> str:
    """The last line in which avrdude says what it did not like; a missing DTR does not count."""
    lines = re.findall(r"^avrdude(?:\.exe)?(?: OS)?(?: error)?:\s*(.+)$", said, re.MULTILINE)
    lines = [line for line in lines if "done." not in line and "TIOCM" not in line]
    return lines[-1].rstrip(".") if lines else ""


def _has(said: str, pattern: str) -> bool:
    return re.search(pattern, said, re.IGNORECASE) is not None
