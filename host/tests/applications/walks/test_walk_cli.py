# SPDX-License-Identifier: MIT
"""`terazi walk`: what is printed, what is written, what is said where it cannot be."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from terazi.applications.walks import ALL_DETECTORS, NAVIGATORS, simulator
from terazi.cli import app

WALK = simulator.simulate(simulator.square(5.0), seed=3)


@pytest.fixture
def run(monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")

    def _run(*words, code=0):
        result = CliRunner().invoke(app, ["walk", *map(str, words)])
        assert result.exit_code == code, result.output
        return result

    return _run


@pytest.fixture
def record(tmp_path):
    path = tmp_path / "walks" / "square.npz"
    path.parent.mkdir()
    at = np.arange(300, len(WALK), 200)
    np.savez(
        path,
        imu=np.hstack([WALK.acc_b_m_s2, WALK.gyro_b_rad_s]),
        ts=WALK.t_s,
        gcp=WALK.truth.pos_t_m[at, :2] * [1, -1],
        stride_index=at,
    )
    return path


def test_walk_prints_distance_strides_and_closure(run, record):
    text = run(record).stdout
    assert "strides" in text
    assert "end to start" in text
    figures = json.loads(run(record, "--json").stdout)
    assert figures["distance_m"] == pytest.approx(
        np.linalg.norm(np.diff(WALK.truth.pos_t_m[:, :2], axis=0), axis=1).sum(), rel=0.05
    )
    assert figures["rmse_2d_m"] < 0.2


def test_walk_writes_plots_and_the_path(run, record, tmp_path):
    page, table = tmp_path / "walk.html", tmp_path / "path.csv"
    run(record, "-o", page, "--csv", table)
    text = page.read_text()
    for word in ("stances", "height", "velocity", "threshold", "zero velocity", "truth"):
        assert word in text
    rows = np.genfromtxt(table, delimiter=",", names=True)
    assert len(rows) == len(WALK)
    assert set(rows["still"]) == {0, 1}
    assert rows["settled"][0] == 1


def test_walk_score_prints_the_promised_json_and_nothing_else(run, record):
    found = json.loads(run("score", record.parent, "--json").stdout)
    assert set(found) == {"trials", "mean"}
    assert set(found["trials"]) == {"square"}
    assert set(found["mean"]) == {"rmse_2d_m", "rmse_3d_m", "closure_m"}
    assert found["mean"]["rmse_3d_m"] is None
    assert found["mean"] == found["trials"]["square"]
    assert json.loads(run("score", record.parent, "--only", "squ", "--json").stdout) == found
    assert "begins with 2018" in run("score", record.parent, "--only", "2018", code=9).stderr


@pytest.mark.parametrize(
    "options",
    [
        ("--detector", "shoe"),
        ("--detector", "learnt", "--causal"),
        ("--navigator", "complementary", "--eliminate-drift"),
        ("--threshold", "0.2"),
    ],
    ids=" ".join,
)
def test_walk_score_takes_every_detector_and_navigator(run, record, options):
    found = json.loads(run("score", record.parent, "--json", *options).stdout)
    assert found["mean"]["rmse_2d_m"] < 1.0


def test_walk_warns_and_refuses_in_words(run, record, tmp_path):
    still = tmp_path / "hip.npz"
    rng = np.random.default_rng(1)
    imu = np.hstack([rng.normal([0, 0, 9.81], 2.0, (2000, 3)), rng.normal(0, 2.0, (2000, 3))])
    np.savez(still, imu=imu, ts=np.arange(2000) / 200)
    assert "never stands still" in run(still, "--detector", "shoe", code=9).stderr
    assert "no such file" in run(tmp_path / "none.npz", code=9).stderr.lower()
    refused = run(record, "--causal", "--eliminate-drift", code=2)
    assert "cannot run causally" in refused.stderr
    refused = run(record, "--weights", "lstm", code=2)
    assert "--detector learnt" in refused.stderr


def test_walk_tables_names_both_documents(run):
    found = json.loads(run("tables", "--json").stdout)
    assert set(found) == {"article_simulated", "thesis_simulated"}
    without, with_ = found["article_simulated"]
    assert with_["Y drift m"] < 0.5 * without["Y drift m"]
    assert with_["X error %"] < 1.5
    routes = {row["route"]: row for row in found["thesis_simulated"]}
    assert set(routes) == {"square 10 m", "circle 5 m", "stairs"}
    standard, lstm, gru, usual = list(routes["stairs"])[1:]
    assert ("SHOE" in standard, lstm[:4], gru[:3], usual) == (True, "LSTM", "GRU", "default")
    assert routes["stairs"][lstm] < 0.5 * routes["stairs"][standard]


def test_a_simulated_walk_is_written_and_read_again(run, tmp_path):
    path = tmp_path / "circle.npz"
    assert "written" in run("simulate", "circle", "-o", path, "--seed", "4").stdout
    figures = json.loads(run(path, "--json").stdout)
    assert figures["rmse_3d_m"] < 0.5
    assert figures["closure_m"] < 0.5
    refused = run("simulate", "circle", "-o", tmp_path / "no" / "such.npz", code=8)
    assert "such.npz" in refused.stderr


def test_every_route_of_the_simulator_has_its_name_on_the_command_line():
    from terazi.cli.walk import Detector, Navigator, Route

    assert [each.value for each in Route] == list(simulator.ROUTES)
    assert {each.value for each in Detector} == set(ALL_DETECTORS)
    assert [each.value for each in Navigator] == list(NAVIGATORS)
