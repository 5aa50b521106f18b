# SPDX-License-Identifier: MIT
"""./dev: helps, refuses what it does not know, and installs or names what a machine lacks."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
VERBS = re.findall(r"^  (\w+)  ", subprocess.run(
    [ROOT / "dev"], capture_output=True, text=True, check=True
).stdout, re.MULTILINE)  # fmt: skip
# What ./dev itself calls before it knows what the machine has.
BASICS = ("sh", "cat", "cksum", "dirname", "flock", "grep", "head", "mkdir", "rm", "tail")


@pytest.fixture
def bare(tmp_path):
    """A machine with nothing but the basics, in which ./dev is run by `maker`."""
    tools = tmp_path / "bin"
    tools.mkdir()
    for name in BASICS:
        (tools / name).symlink_to(shutil.which(name))
    shutil.copy(ROOT / "dev", tmp_path)

    class Machine:
        def has(self, name, script):
            (tools / name).write_text(f"#!/bin/sh\n{script}\n")
            (tools / name).chmod(0o755)

        def dev(self, *arguments, cwd=None):
            return subprocess.run(
                [tmp_path / "dev", *arguments],
                env={"PATH": str(tools), "HOME": str(tmp_path)},
                cwd=cwd or tmp_path,
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
            )

    machine = Machine()
    machine.has("id", "echo 1000")
    machine.has("apt-get", 'echo "$@" >>asked; exit 100')
    return machine


def test_dev_is_plain_posix_sh():
    subprocess.run(["dash", "-n", ROOT / "dev"], check=True)


def test_dev_knows_its_verbs():
    wanted = "setup demo test check hil budget gen flash bench run clean"
    assert sorted(VERBS) == sorted(wanted.split())


@pytest.mark.parametrize("verb", VERBS)
def test_each_verb_helps_without_installing_anything(bare, verb):
    done = bare.dev(verb, "--help")
    assert done.returncode == 0
    assert done.stdout.startswith(f"./dev {verb}")
    assert done.stderr == ""


def test_an_unknown_verb_is_refused_with_the_list(bare):
    done = bare.dev("dance")
    assert done.returncode == 2
    assert "no such verb: dance" in done.stderr
    assert "budget" in done.stderr


def test_without_root_the_missing_packages_are_named_and_nothing_is_tried(bare, tmp_path):
    done = bare.dev("setup")
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert "apt-get install --no-install-recommends " in line
    assert {"gcc-avr", "avrdude", "make", "python3-venv"} <= set(line.split())
    assert not (tmp_path / "asked").exists()


def test_a_sudo_that_would_ask_for_a_password_is_not_called_without_a_terminal(bare, tmp_path):
    bare.has("sudo", '[ "$1" = -n ] && exit 1; echo "$@" >>asked')
    assert bare.dev("setup").returncode == 2
    assert not (tmp_path / "asked").exists()


def test_what_the_machine_has_is_not_asked_for(bare):
    bare.has("make", "exit 0")
    bare.has("avrdude", "exit 0")
    words = bare.dev("setup").stderr.split()
    assert "gcc-avr" in words
    assert not {"make", "avrdude"} & set(words)


def test_with_root_they_are_installed_and_a_failure_shows_its_log(bare, tmp_path):
    bare.has("id", "echo 0")
    bare.has("apt-get", 'echo "$@" >>asked; echo no such package >&2; [ "$1" = update ]')
    done = bare.dev("setup")
    assert done.returncode == 1
    update, install = (tmp_path / "asked").read_text().splitlines()
    assert update == "update"
    assert install.startswith("install -y --no-install-recommends ")
    assert "no such package" in done.stderr
    assert ".build/log/apt-install.log" in done.stderr


def test_without_apt_the_debian_names_are_given(bare, tmp_path):
    (tmp_path / "bin/apt-get").unlink()
    done = bare.dev("setup")
    assert done.returncode == 2
    assert "gcc-avr" in done.stderr


def test_a_folder_with_spaces_and_another_working_folder_do(tmp_path):
    tree = tmp_path / "a tree"
    tree.mkdir()
    shutil.copy(ROOT / "dev", tree)
    done = subprocess.run([tree / "dev", "clean"], cwd="/", env={"PATH": os.environ["PATH"]})
    assert done.returncode == 0
