# SPDX-License-Identifier: MIT
"""Each law of the tree can fail: a little tree with one breach in it is told from one without."""

from pathlib import Path

import pytest

from tools.checks import holes, readme, requirements, tree

MIT = "SPDX-License-Identifier: " + "MIT"


def plant(root: Path, files: dict[str, str]) -> Path:
    for name, text in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return root


def test_a_stranger_at_the_top_is_named(tmp_path):
    plant(tmp_path, {"README.md": "", "host/a.py": ""})
    assert tree.strangers(tmp_path) == []
    plant(tmp_path, {"notes.txt": ""})
    assert [line.split(": ")[1] for line in tree.strangers(tmp_path)] == ["notes.txt"]


def test_a_source_without_its_licence_line_is_named(tmp_path):
    plant(tmp_path, {"host/a.py": f"# {MIT}\n", "dev": f"#!/bin/sh\n# {MIT}\n", "host/b.md": "x"})
    assert tree.licence_lines(tmp_path) == []
    plant(tmp_path, {"host/b.py": "x = 1\n", "hil_tests/virtual_uno/c.c": f"/* {MIT} */\n"})
    assert len(tree.licence_lines(tmp_path)) == 2


def test_a_long_line_and_a_long_file_are_named(tmp_path):
    plant(tmp_path, {"host/a.py": "x" * 100 + "\n" * 300, "shared_c/generated/t.c": "x" * 200})
    assert tree.lengths(tmp_path) == []
    plant(tmp_path, {"host/a.py": "x" * 101 + "\n" * 401})
    assert len(tree.lengths(tmp_path)) == 2


@pytest.mark.parametrize(
    "text",
    [
        "see https://pypi" + ".org/simple",
        "--find" + "-links wheels",
        "open('/" + "work/data')",
        "x = 1  # TO" + "DO: later",
        "pytest.skip" + "()",
        "@pytest.mark." + "skip\ndef test(): pass",
    ],
)
def test_what_no_other_reader_can_use_is_named(tmp_path, text):
    plant(tmp_path, {"host/a.py": "pytest.skip('no board')\nbase = '/tmp/x'\n"})
    assert tree.given_away(tmp_path) == []
    plant(tmp_path, {"host/b.py": text + "\n"})
    assert len(tree.given_away(tmp_path)) == 1


def test_a_build_product_is_named(tmp_path):
    plant(tmp_path, {"host/a.so": ""})
    assert tree.given_away(tmp_path) == ["host/a.so: a build product"]


def whole_module(name: str) -> dict[str, str]:
    places = [link.pattern.format(module=name).replace("*", "") for link in holes.LINKS]
    return {f"shared_c/include/{name}.h": "", **dict.fromkeys(places, "")}


@pytest.fixture
def no_exemptions(monkeypatch):
    monkeypatch.setattr(holes, "EXEMPT", {})


@pytest.mark.usefixtures("no_exemptions")
def test_each_missing_link_of_a_module_is_a_hole(tmp_path):
    files = whole_module("fir") | {"firmware/budget.toml": "fir = 1\n"}
    assert holes.breaches(plant(tmp_path / "whole", files)) == []
    for missing in [name for name in files if not name.endswith(".h")]:
        rest = {name: text for name, text in files.items() if name != missing}
        found = holes.breaches(plant(tmp_path / missing.replace("/", "_"), rest))
        assert len(found) == 1, missing


@pytest.mark.usefixtures("no_exemptions")
def test_a_vector_that_belongs_to_no_module_is_named(tmp_path):
    files = whole_module("fir") | {"firmware/budget.toml": "fir = 1\n"}
    plant(tmp_path, files | {"shared_c/vectors/firs_step.csv": "", "shared_c/src/lost.c": ""})
    assert len(holes.breaches(tmp_path)) == 2


def test_an_exemption_that_no_module_uses_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(holes, "EXEMPT", {("gone", "model"): "it had none"})
    assert holes.breaches(tmp_path) == ["gone: exempt of model, but there is no such module"]


LISTS = {
    "requirements/runtime.in": "numpy\n",
    "requirements/runtime.txt": "numpy==2.4.6 ; python_full_version < '3.12'\n",
    "requirements/dev.in": "-r runtime.in\nruff\n",
    "requirements/dev.txt": "numpy==2.4.6\nruff==0.17.6\n",
    "pyproject.toml": "[project]\ndependencies = ['numpy>=1.26']\n",
}


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("requirements/runtime.txt", "scipy==1.0\n"),
        ("requirements/dev.txt", "numpy==2.4.6\n"),
        ("requirements/dev.txt", "--index" + "-url x\nnumpy==2.4.6\nruff==0.17.6\n"),
        ("requirements/dev.txt", "numpy>=2.4.6\nruff==0.17.6\n"),
        ("pyproject.toml", "[project]\ndependencies = ['numpy', 'rich']\n"),
        ("pyproject.toml", "[project]\ndependencies = []\n"),
    ],
)
def test_a_pin_that_does_not_follow_its_list_is_named(tmp_path, file, text):
    assert requirements.breaches(plant(tmp_path, LISTS)) == []
    assert requirements.breaches(plant(tmp_path, {file: text})) != []


DEV = """#!/bin/sh
[ "$1" = demo ] && [ "$2" = --help ] && echo "./dev demo [--speed N]"
"""


@pytest.mark.parametrize(
    ("command", "is_fine"),
    [
        ("./dev demo", True),
        ("./dev demo --speed 0", True),
        ("git clone X && ./dev demo  # look", True),
        ("./dev dance", False),
        ("./dev demo --fast", False),
        ("cd x && curl y", False),
    ],
)
def test_a_command_that_does_not_exist_is_named(tmp_path, command, is_fine):
    plant(tmp_path, {"dev": DEV, "README.md": f"# x\n```sh\n{command}\n```\n"})
    (tmp_path / "dev").chmod(0o755)
    assert (readme.breaches(tmp_path) == []) == is_fine
