# SPDX-License-Identifier: MIT
"""Put an image on a board: who is there, write and verify, who is there now.

The board answers twice: before, if any Terazi firmware runs on it, and after, from the image just
written. Nothing is touched before the image has been read whole and found to fit.
"""

import os
import re
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from terazi.errors import FingerprintMismatch, NoAnswer, UsageError
from terazi.link.avrdude import find_avrdude, write_flash
from terazi.link.generated.messages import Hello
from terazi.link.intel_hex import Image, read_image
from terazi.link.link import open_link
from terazi.link.ports import find_port
from terazi.link.transport import BAUD_DEFAULT

BUILT_HEX = Path(".build/firmware/terazi.hex")
BUILT_LOGS = Path(".build/flash")

# Between closing the port and opening it again: the USB bridge must see both.
PORT_REST_S = 0.3
# A new firmware answers 1.4 s after its reset; a virtual board on a loaded computer takes longer.
HELLO_AFTER_FLASH_S = 8.0

OnStage = Callable[[str, float | None], None]


@dataclass(frozen=True)
class Flashed:
    """What was done, and who answered before and after it."""

    port: str
    image: Image
    before: Hello | FingerprintMismatch | None  # None: no Terazi firmware answered
    after: Hello
    log: Path


def flash(
    port: str | None = None,
    hex_path: Path | None = None,
    *,
    baud: int = BAUD_DEFAULT,
    on_stage: OnStage = lambda _stage, _done: None,
) -> Flashed:
    """Program the board at `port`, or the only one there is, and wait for its new firmware.

    on_stage(name, done) tells of progress; done is None where there is no saying. `baud` is the
    boot loader's. Raises a TeraziError that names what went wrong.
    """
    find_avrdude()
    image = read_image(hex_path if hex_path is not None else built_hex())
    port = find_port(port)
    log = log_path(port)

    on_stage("asking who is there", None)
    before = who_is_there(port)
    time.sleep(PORT_REST_S)
    on_stage("waking the boot loader", None)
    write_flash(port, image.path, baud=baud, log=log, on_progress=on_stage)
    time.sleep(PORT_REST_S)
    on_stage("waiting for the new firmware", None)
    after = await_firmware(port)
    return Flashed(port, image, before, after, log)


def who_is_there(port: str) -> Hello | FingerprintMismatch | None:
    """The firmware that answers, one of another protocol included; None if nothing of ours does.

    Asked at the boot loader's rate only: one that is alone takes bytes at another for commands.
    Raises if the port cannot be used at all.
    """
    try:
        with open_link(port, BAUD_DEFAULT) as link:
            return link.hello()
    except NoAnswer:
        return None
    except FingerprintMismatch as other:
        return other


def await_firmware(port: str) -> Hello:
    """What the board says after it was programmed. Raises NoAnswer if it says nothing."""
    try:
        with open_link(port) as link:
            return link.hello(HELLO_AFTER_FLASH_S)
    except NoAnswer as error:
        raise NoAnswer(
            f"{port} was programmed and verified, but no Terazi firmware answers",
            remedy="If the image is Terazi's: press the board's reset button, try `terazi info`.",
        ) from error


def repository() -> Path | None:
    """The clone of Terazi's sources that the current folder lies in, if it does."""
    here = Path.cwd()
    for folder in (here, *here.parents):
        if (folder / "firmware" / "Makefile").is_file() and (folder / "shared_c").is_dir():
            return folder
    return None


def built_hex() -> Path:
    """The image that ./dev built."""
    top = repository()
    if top is None:
        raise UsageError(
            "which image? This folder is no clone of Terazi's sources",
            remedy="Name it: terazi flash --hex FILE",
        )
    path = top / BUILT_HEX
    if not path.is_file():
        raise UsageError(
            f"the firmware is not built: there is no {path}",
            remedy="Build it with ./dev setup, or name an image: terazi flash --hex FILE",
        )
    return path


def log_path(port: str) -> Path:
    """Where avrdude's words go: a file a port, in the clone's build folder or the user's state."""
    name = "avrdude-" + re.sub(r"[^A-Za-z0-9]+", "-", port).strip("-") + ".log"
    top = repository()
    if top is not None:
        folder = top / BUILT_LOGS
    else:
        state = os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state"
        folder = Path(state) / "terazi"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / name).open("ab").close()
    except OSError:  # a log that cannot be kept there is no reason not to flash
        folder = Path(tempfile.gettempdir())
    return folder / name
