# SPDX-License-Identifier: MIT
"""`terazi attitude score` as people and scripts meet it: output and exit codes."""

import json
import subprocess
import sys

import pytest

from host.tests.applications.synthetic import write

KEYS = ["inclination_rmse_deg", "heading_rmse_deg", "total_rmse_deg"]


def score(*words):
    command = [sys.executable, "-m", "terazi", "attitude", "score", *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, timeout=60)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("trials")
    for name, seed in {"one": 1, "two": 2}.items():
        write(folder / f"{name}.npz", rest_s=3.0, move_s=6.0, seed=seed)
    return folder


@pytest.mark.parametrize("mode", [[], ["--mode", "6"], ["--mode", "9"]], ids=str)
def test_score_prints_one_json_object_and_nothing_else(folder, mode):
    done = score(folder, *mode, "--json")
    assert done.returncode == 0, done.stderr
    plain = json.loads(done.stdout)
    assert list(plain) == ["trials", "mean", "worst"]
    assert list(plain["trials"]) == ["one", "two"]
    rows = list(plain["trials"].values())
    for row in (*rows, plain["mean"], plain["worst"]):
        assert list(row) == KEYS
    for key in KEYS:
        figures = [row[key] for row in rows]
        assert plain["mean"][key] == pytest.approx(sum(figures) / 2)
        assert plain["worst"][key] == max(figures)
        assert 0 < plain["worst"][key] < 3


def test_score_is_the_same_each_time(folder):
    assert score(folder, "--json").stdout == score(folder, "--json").stdout


def test_filters_differ(folder):
    said = {score(folder, "--json", "--filter", name).stdout for name in ("second_order", "linear")}
    assert len(said) == 2


def test_score_of_one_file_is_a_table_for_people(folder):
    done = score(folder / "one.npz")
    assert done.returncode == 0, done.stderr
    assert "one" in done.stdout
    assert "two" not in done.stdout
    assert "worst" in done.stdout
    assert "no north" in done.stdout
    assert "no north" not in score(folder / "one.npz", "--mode", "9").stdout


def fails(words, code, said):
    done = score(*words)
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout == ""
    (line,) = [line for line in done.stderr.splitlines() if line.startswith("error: ")]
    assert said in line


def test_what_cannot_be_read_is_named_with_exit_code_9(folder, tmp_path):
    fails([tmp_path / "absent", "--json"], 9, "no such folder")
    fails([tmp_path, "--json"], 9, "holds no file that ends in .npz")
    (tmp_path / "broken.npz").write_bytes(b"PK")
    fails([tmp_path], 9, "broken.npz")
    write(tmp_path / "broken.npz", without=("gyr",), rest_s=1.0, move_s=1.0)
    fails([tmp_path, "--json"], 9, "lacks gyr")


def test_unknown_modes_and_filters_are_usage_errors(folder):
    for words in (["--mode", "7"], ["--filter", "best"], ["--what"]):
        assert score(folder, *words).returncode == 2
