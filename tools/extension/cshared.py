# SPDX-License-Identifier: MIT
"""Builds terazi.cshared._cshared, the cffi extension, from shared_c.

    python -m tools.extension.cshared [--sanitize] [--force]

Without an option: in place, beside terazi/cshared/__init__.py, and only if a source is newer.
--sanitize: a variant in .build/ubsan for tests, where signed overflow is an error. Python's own
CFLAGS carry -fwrapv, which would hide it, so -fno-wrapv stands behind them.

The C declarations that Python sees are the public headers themselves; in API mode the compiler
checks every one of them against the code.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import os
import re
import shutil
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "host" / "src" / "terazi" / "cshared"
SANITIZED_DIR = ROOT / ".build" / "ubsan"
MODULE = "_cshared"
STAMP = ".build/cshared"  # a hash of everything that went into the last build, per variant

SHARED = ROOT / "shared_c"
PUBLIC_HEADERS = ("fir.h", "weight_kf.h", "mass.h", "frame.h", "imu_cal.h", "rest.h", "mahony.h")
PUBLIC_HEADERS += ("scale.h", "checkweigher.h", "weight_kf_adaptive.h", "temperature.h")
GENERATED_HEADERS = ("fir_designs.h", "weight_kf_gains.h", "messages.h", "rest_configs.h")
GENERATED_HEADERS += ("mahony_configs.h", "scale_units.h", "weight_kf_adaptive_variants.h")
PUBLIC_HEADERS += ("settings.h", "faults.h", "zupt.h", "zupt_gru.h")
GENERATED_HEADERS += ("settings_table.h", "zupt_configs.h")
# Loops over arrays.
BLOCKS = ("blocks", "adaptive_blocks", "imu_blocks", "mahony_blocks", "scale_blocks")
BLOCKS += ("temperature_blocks", "ins_blocks", "faults_blocks", "zupt_blocks")
BLOCKS += ("zupt_gru_blocks",)
SEAM = "typedef int... port_place_t;\n"  # of port_rom.h, which is no public header
SOURCE_FOLDERS = ("src", "generated", "port_plain")

OPTIMISE = ["-O2", "-ffp-contract=off", "-fvisibility=hidden"]
# cffi's own code for the address of a const struct or table; our C meets -Wall and more in
# tools/checks.
OPTIMISE += ["-Wno-discarded-qualifiers", "-Wno-discarded-array-qualifiers"]
SANITIZE = ["-g", "-fsanitize=undefined", "-fno-sanitize-recover=all", "-fno-wrapv", "-UNDEBUG"]
COVERAGE = ["--coverage", "-O0"]  # optimised code has other branches than the source


def _readable(header: str) -> str:
    """A header as cffi wants it: constants by name only, guards and includes gone.

    An `extern const` struct must lose its const, or cffi gives its value and not its address.
    """
    header = re.sub(r"^#define (\w+) .+", r"#define \1 ...", header, flags=re.MULTILINE)
    header = re.sub(r"^#(?!define \w+ \.\.\.$).*$", "", header, flags=re.MULTILINE)
    return re.sub(r"^extern const (?!.*\*)", "extern ", header, flags=re.MULTILINE)


def declarations() -> str:
    """What cffi is told: the public headers without directives, which they hardly have."""
    headers = [SHARED / "include" / name for name in PUBLIC_HEADERS]
    headers += [SHARED / "generated" / name for name in GENERATED_HEADERS]
    headers += [PACKAGE / f"{name}.h" for name in BLOCKS]
    return SEAM + "".join(_readable(path.read_text(encoding="utf-8")) for path in headers)


def c_sources() -> list[Path]:
    """All of shared_c and the loops over arrays."""
    shared = [path for folder in SOURCE_FOLDERS for path in sorted((SHARED / folder).glob("*.c"))]
    return [*shared, *(PACKAGE / f"{name}.c" for name in BLOCKS)]


def include_dirs() -> list[Path]:
    """The port is chosen here: plain C."""
    return [SHARED / "include", *(SHARED / folder for folder in SOURCE_FOLDERS), PACKAGE]


def fingerprint(sanitize: bool) -> str:
    """A hash of sources, headers, this program and the interpreter."""
    digest = hashlib.sha256(f"{sys.version} {sanitize}".encode())
    headers = [path for folder in include_dirs() for path in sorted(folder.glob("*.h"))]
    for path in [Path(__file__), *c_sources(), *headers]:
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()


def build(target: Path, *, sanitize: bool = False, coverage: Path | None = None) -> Path:
    """Compile the extension into the folder target; gives the file.

    coverage : compile there, counting branches; the counts and the sources stay in that folder.
    """
    from cffi import FFI  # a build requirement, so only here

    ffi = FFI()
    ffi.cdef(declarations())
    headers = (*PUBLIC_HEADERS, *GENERATED_HEADERS, *(f"{name}.h" for name in BLOCKS))
    windows = os.name == "nt"
    compile_args = OPTIMISE + (SANITIZE if sanitize else []) + (COVERAGE if coverage else [])
    link_args = ["-fsanitize=undefined"] if sanitize else []
    with contextlib.ExitStack() as stack:
        if coverage:
            coverage.mkdir(parents=True, exist_ok=True)
            scratch, link_args = str(coverage), [*link_args, "--coverage"]
        else:
            scratch = stack.enter_context(tempfile.TemporaryDirectory(prefix="cshared-"))
        # Relative source paths keep objects inside the scratch folder; setuptools would else
        # rebuild the absolute path below it.
        sources = []
        for path in c_sources():
            copy = Path(scratch) / path.name
            shutil.copyfile(path, copy)
            sources.append(path.name)
        ffi.set_source(
            MODULE,
            "".join(f'#include "{name}"\n' for name in headers),
            sources=sources,
            include_dirs=[str(folder) for folder in include_dirs()],
            extra_compile_args=[] if windows else compile_args,
            extra_link_args=link_args,
        )
        before = Path.cwd()
        os.chdir(scratch)
        try:
            built = Path(ffi.compile(tmpdir=".", verbose=False)).resolve()
        finally:
            os.chdir(before)
        target.mkdir(parents=True, exist_ok=True)
        # Put in place whole: a running Python may hold the old one.
        fresh = target / f".{built.name}.{os.getpid()}"
        shutil.copyfile(built, fresh)
        fresh.replace(target / built.name)
        return target / built.name


def ensure(*, sanitize: bool = False, force: bool = False) -> Path:
    """Build where something has changed since; gives the file."""
    target = SANITIZED_DIR if sanitize else PACKAGE
    stamp = ROOT / f"{STAMP}-{'ubsan' if sanitize else 'inplace'}.stamp"
    wanted = fingerprint(sanitize)
    present = sorted(target.glob(f"{MODULE}.*"))
    if not force and present and stamp.is_file() and stamp.read_text() == wanted:
        return present[0]
    # Two processes may build at once, as pytest's workers do: each replaces whole files only.
    built = build(target, sanitize=sanitize)
    for stale in present:
        if stale.name != built.name:  # of another interpreter
            stale.unlink(missing_ok=True)
    stamp.parent.mkdir(parents=True, exist_ok=True)
    stamp.write_text(wanted)
    return built


def main() -> int:
    """Command line, see above."""
    parser = argparse.ArgumentParser(prog="cshared", description=__doc__.splitlines()[0])
    parser.add_argument("--sanitize", action="store_true", help="the UBSan variant, .build/ubsan")
    parser.add_argument("--force", action="store_true", help="even if nothing has changed")
    options = parser.parse_args()
    print(ensure(sanitize=options.sanitize, force=options.force).relative_to(ROOT))
    return 0


if __name__ == "__main__":
    sys.exit(main())
