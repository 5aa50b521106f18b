# SPDX-License-Identifier: MIT
"""PlatformIO script: tell the firmware the commit it is built from, as firmware/Makefile does.

The commit is named only if it holds every source that the image is made of; otherwise, and where
there is no git, the image says 0. TERAZI_BUILD in the environment overrules, for example
TERAZI_BUILD=0x1234abcd.
"""

import os
import subprocess

Import("env")  # noqa: F821 - SCons gives it to the script

BUILD_PATHS = ("firmware", "shared_c")


def git(*arguments: str) -> str:
    project = env.subst("$PROJECT_DIR")  # noqa: F821
    done = subprocess.run(["git", *arguments], cwd=project, capture_output=True, text=True)
    return done.stdout.strip() if done.returncode == 0 else "unknown"


def version_build() -> str:
    if overruled := os.environ.get("TERAZI_BUILD"):
        return overruled
    try:
        if git("status", "--porcelain", "--", *BUILD_PATHS):
            return "0x0"
        return "0x" + git("rev-parse", "--short=8", "HEAD")
    except OSError:
        return "0x0"


env.Append(CPPDEFINES=[("VERSION_BUILD", version_build())])  # noqa: F821
