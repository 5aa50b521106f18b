#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Make PlatformIO Core work with no PlatformIO registry and no network.

PlatformIO fetches one thing before it can build anything: SCons, as the registry package
`tool-scons`. PyPI has SCons too, so this writes a stand-in package that calls that one, into a
PlatformIO folder of the project's own (`.build/pio-core`; the user's ~/.platformio stays as it
is). Telemetry and the search for updates are turned off there, since both reach for the network.

    python tools/flash/setup_platformio.py              set up; at once when nothing changed
    python tools/flash/setup_platformio.py run -e uno-system     set up, then `pio run ...` in it

Exit code: PlatformIO's own; 2 where PlatformIO or SCons is not installed for this Python.
"""

import importlib.metadata
import importlib.util
import json
import os
import re
import sys
import time
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
CORE_DIR = REPOSITORY / ".build" / "pio-core"

CALL_SCONS = """from SCons.Script.Main import main

main()
"""

# No search for updates for a century: PlatformIO knows an interval, but no `never`.
CHECK_INTERVAL_DAYS = 36500


def environment() -> dict[str, str]:
    """What to add to the environment of a `pio` so that it uses the project's own folder."""
    return {
        "PLATFORMIO_CORE_DIR": str(CORE_DIR),
        "PLATFORMIO_SETTING_ENABLE_TELEMETRY": "no",
        "PLATFORMIO_DISABLE_UPGRADE_CHECK": "true",
    }


def scons_package_version() -> str:
    """A version that this PlatformIO accepts for tool-scons: the lowest it asks for ("~4.41101.0").

    The registry numbers its packages in its own way, so SCons's number says nothing here.
    """
    from platformio.dependencies import get_core_dependencies

    required = get_core_dependencies()["tool-scons"]
    version = re.search(r"\d+\.\d+\.\d+", required)
    if version is None:
        raise SystemExit(f"setup_platformio: cannot read PlatformIO's requirement {required!r}")
    return version.group()


def write_if_changed(path: Path, text: str) -> bool:
    """Write `text`; returns whether the file was not already so."""
    if path.exists() and path.read_text() == text:
        return False
    path.parent.mkdir(parents=True, exist_ok=True)
    # Several builds may set up at once: a reader must see the old file or the new one, no half.
    partial = path.with_name(f"{path.name}.{os.getpid()}")
    partial.write_text(text)
    partial.replace(path)
    return True


def write_scons_package() -> bool:
    """The stand-in for tool-scons; returns whether anything had to be written."""
    folder = CORE_DIR / "packages" / "tool-scons"
    version = scons_package_version()
    package = {
        "name": "tool-scons",
        "version": version,
        "description": "calls the SCons that pip installed",
        "system": "*",
    }
    installed = {
        "type": "tool",
        "name": "tool-scons",
        "version": version,
        "spec": {
            "owner": "platformio",
            "id": None,
            "name": "tool-scons",
            "requirements": None,
            "uri": None,
        },
    }
    changed = [
        write_if_changed(folder / "package.json", json.dumps(package, indent=2) + "\n"),
        write_if_changed(folder / ".piopm", json.dumps(installed)),
        write_if_changed(folder / "scons.py", CALL_SCONS),
    ]
    return any(changed)


def write_settings() -> bool:
    """PlatformIO's state: quiet, and of this version (another one starts an upgrade by network)."""
    path = CORE_DIR / "appstate.json"
    try:
        state = json.loads(path.read_text())
    except (OSError, ValueError):
        state = {}
    before = json.dumps(state)
    state["last_version"] = importlib.metadata.version("platformio")
    state.setdefault("last_check", {"platformio_upgrade": int(time.time())})
    state.setdefault("settings", {}).update(
        enable_telemetry=False,
        check_platformio_interval=CHECK_INTERVAL_DAYS,
        check_prune_system_threshold=0,
    )
    after = json.dumps(state)
    return after != before and write_if_changed(path, after)


def main(arguments: list[str]) -> int:
    if arguments[:1] in (["-h"], ["--help"]):
        print(__doc__)
        return 0
    missing = [m for m in ("platformio", "SCons") if importlib.util.find_spec(m) is None]
    if missing:
        names = " ".join(m.lower() for m in missing)
        print(
            f"setup_platformio: {sys.executable} has no {names}; run ./dev setup, "
            f"or: {sys.executable} -m pip install {names}",
            file=sys.stderr,
        )
        return 2
    changed = [write_scons_package(), write_settings()]
    if not arguments:
        print(f"PlatformIO folder {'written' if any(changed) else 'up to date'}: {CORE_DIR}")
        print(f"use it with: export PLATFORMIO_CORE_DIR={CORE_DIR}")
        return 0
    os.chdir(REPOSITORY)
    os.environ.update(environment())
    os.execv(sys.executable, [sys.executable, "-m", "platformio", *arguments])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
