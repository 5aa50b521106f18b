# SPDX-License-Identifier: MIT
"""`pip install .` gives what a user needs, from the tree and from the source archive alone."""

import json
import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
PIP_WHEEL = ["-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation"]

# Python 3.11.2 of Debian 12 does not know the filter, newer ones ask for it.
SAFELY = {"filter": "data"} if hasattr(tarfile, "data_filter") else {}

# Run where only the unpacked wheel gives `terazi`.
USE = """
import json, sys
sys.path.insert(0, sys.argv[1])
import terazi, terazi.cshared as cshared
from terazi.models import fir
step = [0] * 4 + [1000] * 60
of_c, of_model = cshared.fir_block(step), fir.fir(step)
print(json.dumps({"from": terazi.__file__, "last": [int(of_c[-1]), round(of_model[-1])]}))
"""


def python(*arguments, cwd=ROOT):
    # What runs from an unpacked wheel is no coverage of the tree.
    environment = {**os.environ, "COVERAGE_PROCESS_CONFIG": ""}
    done = subprocess.run(
        [sys.executable, *map(str, arguments)],
        cwd=cwd,
        env=environment,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    python(*PIP_WHEEL, "--wheel-dir", folder, ".")
    (built,) = folder.glob("terazi-*.whl")
    return built


def contents(wheel):
    with zipfile.ZipFile(wheel) as archive:
        return archive.namelist()


def used_from(wheel, folder):
    """What USE says with the wheel unpacked into folder."""
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder)
    return json.loads(python("-I", "-c", USE, folder, cwd=folder))


def test_wheel_holds_the_compiled_extension_and_is_of_this_platform(wheel):
    extensions = [name for name in contents(wheel) if name.endswith((".so", ".pyd"))]
    assert len(extensions) == 1
    assert extensions[0].startswith("terazi/cshared/_cshared.")
    assert "none-any" not in wheel.name


def test_wheel_holds_the_package_and_its_licence_and_nothing_else(wheel):
    strangers = [name for name in contents(wheel) if not name.startswith(("terazi/", "terazi-"))]
    assert strangers == []
    assert not [name for name in contents(wheel) if name.endswith((".c", ".h"))]
    assert any(name.endswith("licenses/LICENSE") for name in contents(wheel))


def test_wheel_brings_the_weights_of_the_learnt_detectors(wheel):
    walks = "terazi/applications/walks/"
    assert {walks + "gru8.npz", walks + "lstm.npz"} <= set(contents(wheel))


def test_wheel_brings_the_command(wheel):
    with zipfile.ZipFile(wheel) as archive:
        (entry,) = [name for name in archive.namelist() if name.endswith("entry_points.txt")]
        assert "terazi = terazi.cli:main" in archive.read(entry).decode()


def test_wheel_filters_without_the_tree(wheel, tmp_path):
    said = used_from(wheel, tmp_path)
    assert said["from"].startswith(str(tmp_path))
    assert said["last"] == [1000, 1000]


def test_source_archive_alone_builds_the_same_package(wheel, tmp_path):
    python("-m", "hatchling", "build", "-t", "sdist", "-d", tmp_path)
    (archive,) = tmp_path.glob("terazi-*.tar.gz")
    shutil.unpack_archive(archive, tmp_path / "source", **SAFELY)
    (source,) = (tmp_path / "source").iterdir()
    python(*PIP_WHEEL, "--wheel-dir", tmp_path, ".", cwd=source)
    (built,) = tmp_path.glob("terazi-*.whl")
    assert sorted(contents(built)) == sorted(contents(wheel))
    assert used_from(built, tmp_path / "used")["last"] == [1000, 1000]
