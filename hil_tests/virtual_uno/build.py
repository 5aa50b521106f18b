# SPDX-License-Identifier: GPL-3.0-or-later
"""Build the C core into ``.build/bench``; quick when nothing changed.

``python -m virtual_uno.build [--force]`` needs gcc, Python's headers, libsimavr-dev and
libelf-dev.
"""

import argparse
import contextlib
import fcntl
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile

PACKAGE = pathlib.Path(__file__).resolve().parent
CORE = PACKAGE / "core"
BUILD = PACKAGE.parents[1] / ".build" / "bench"
MODULE = "_virtual_uno"
CFLAGS = ["-O2", "-fPIC", "-std=gnu11", "-isystem", "/usr/include/simavr"]
WARNINGS = [
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Wshadow",
    "-Wdouble-promotion",
    "-Wmissing-prototypes",
    "-Werror",
]
CALLBACK = """
extern "Python" void virtual_uno_source(void *, const uint64_t *, double *, uint32_t);
extern "Python" void virtual_uno_part_source(
    void *, uint8_t, const uint64_t *, uint8_t, double *, uint32_t);
"""
GLUE = """
#include "uno.h"
static void virtual_uno_source(void *, const uint64_t *, double *, uint32_t);
void uno_source(void *ctx, const uint64_t *ticks, double *counts, uint32_t n);
void uno_source(void *ctx, const uint64_t *ticks, double *counts, uint32_t n)
{
    virtual_uno_source(ctx, ticks, counts, n);
}
static void virtual_uno_part_source(
    void *, uint8_t, const uint64_t *, uint8_t, double *, uint32_t);
void uno_part_source(
    void *ctx, uint8_t part, const uint64_t *ticks, uint8_t filter, double *rows, uint32_t n);
void uno_part_source(
    void *ctx, uint8_t part, const uint64_t *ticks, uint8_t filter, double *rows, uint32_t n)
{
    virtual_uno_part_source(ctx, part, ticks, filter, rows, n);
}
"""


def extension_path():
    """Where the compiled module lies, or will."""
    return BUILD / (MODULE + sysconfig.get_config_var("EXT_SUFFIX"))


def _declarations():
    """uno.h as cffi reads it: no comments, no preprocessor lines."""
    text = (CORE / "uno.h").read_text()
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
    return "\n".join(line for line in text.splitlines() if not line.startswith("#"))


def _fingerprint():
    digest = hashlib.sha256(sys.version.encode())
    for path in sorted([*CORE.glob("*.[ch]"), pathlib.Path(__file__)]):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()


def _compile(into):
    import cffi

    objects = []
    for source in sorted(CORE.glob("*.c")):
        objects.append(str(into / f"{source.stem}.o"))
        compiler = os.environ.get("CC", "cc")
        subprocess.run([compiler, *CFLAGS, *WARNINGS, "-c", source, "-o", objects[-1]], check=True)
    ffi = cffi.FFI()
    ffi.cdef(_declarations() + CALLBACK)
    ffi.set_source(
        MODULE,
        GLUE,
        include_dirs=[str(CORE)],
        extra_objects=objects,
        libraries=["simavr", "elf", "m"],
    )
    return pathlib.Path(ffi.compile(tmpdir=str(into), verbose=False))


def build(force=False):
    """Compile if sources, Python or this file changed; return the module's path."""
    BUILD.mkdir(parents=True, exist_ok=True)
    stamp = BUILD / "stamp"
    with open(BUILD / "lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # two test workers may come here together
        wanted = _fingerprint()
        fresh = stamp.exists() and stamp.read_text() == wanted and extension_path().exists()
        if force or not fresh:
            work = tempfile.mkdtemp(dir=BUILD)
            try:
                made = _compile(pathlib.Path(work))
                os.replace(made, extension_path())
                stamp.write_text(wanted)
            finally:
                with contextlib.suppress(OSError):
                    shutil.rmtree(work)
    return extension_path()


def main():
    parser = argparse.ArgumentParser(prog="python -m virtual_uno.build", description=__doc__)
    parser.add_argument("--force", action="store_true", help="compile even when up to date")
    print(build(parser.parse_args().force))


if __name__ == "__main__":
    main()
