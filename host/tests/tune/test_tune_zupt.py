# SPDX-License-Identifier: MIT
"""The chip's detectors of zero velocity agree with the host's, and the program that says so."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from terazi.applications.walks import simulator
from terazi.applications.walks.formats import find_walks, load_walk, save_walk
from terazi.design import zupt as design
from tools.tune.zupt import GRID, SHIFTS, Trial, config_of, delays, differ, runs

ROOT = Path(__file__).resolve().parents[3]
SHIPPED = {"share": 1.0, "more": 1.2, "still_blocks": 2, "stride": 1}
SHIPPED_OF = {"moving_variance": {**SHIPPED, "share": 0.5}}
AGREE = {"shoe": 0.98, "are": 0.98, "moving_variance": 0.95, "magnitude": 0.97}
LATE = 15  # samples at 500 Hz: 30 ms


def agree(name, trials):
    found = [differ(t.chip(design.config_at(name)), t.host(name), LATE) for t in trials]
    return 1 - np.mean(found)


@pytest.mark.parametrize("name", design.detectors())
def test_what_is_shipped_was_searched(name):
    setting = SHIPPED_OF.get(name, SHIPPED)
    assert all(setting[key] in values for key, values in GRID.items())
    searched, built = config_of(name, setting), design.config_at(name)
    np.testing.assert_allclose(searched.pop("begin_squares"), built.pop("begin_squares"), rtol=1e-6)
    assert searched == built
    assert LATE in SHIFTS


@pytest.mark.skipif("TERAZI_DATA" not in os.environ, reason="TERAZI_DATA is not set")
@pytest.mark.parametrize("name", design.detectors())
def test_zupt_agrees_with_the_host_on_recorded_walks(name):
    folder = Path(os.environ["TERAZI_DATA"]) / "walks" / "footprints"
    trials = [Trial(load_walk(path)) for path in find_walks(folder)]
    assert agree(name, trials) > AGREE[name]


def otherwise(name, trial):
    """Share of blocks that a limit divides otherwise where | |a| - g | is drawn by its root."""
    gyro, acc = (counts.astype(float) for counts in trial.counts)
    count = len(acc) // design.VISITS
    gyro, acc = (each[: count * design.VISITS].reshape(count, -1, 3) for each in (gyro, acc))
    gyro, acc = gyro[:, 1:-1:2], acc[:, :-1:2]
    config = design.config_at(name)
    vectors = acc if name == "magnitude" else acc.mean(axis=1, keepdims=True)
    gravity, lengths = design.GRAVITY_COUNTS, np.linalg.norm(vectors, axis=2)
    rest = 0.0
    if name == "shoe":
        rest = config["gyro_weight"] * (gyro**2).sum(axis=(1, 2))
        rest = rest + ((acc - vectors) ** 2).sum(axis=(1, 2))
    sides = [
        rest + 4 * (off**2).sum(axis=1) < -config["begin_squares"][0]
        for off in (lengths - gravity, (lengths**2 - gravity**2) / (2 * gravity))
    ]
    return np.mean(sides[0] != sides[1])


@pytest.mark.skipif("TERAZI_DATA" not in os.environ, reason="TERAZI_DATA is not set")
@pytest.mark.parametrize(("name", "share"), [("shoe", 0.001), ("magnitude", 0.01)])
def test_a_bracket_to_first_order_hardly_ever_decides_otherwise_than_a_root(name, share):
    folder = Path(os.environ["TERAZI_DATA"]) / "walks"
    paths = [*find_walks(folder / "footprints"), *find_walks(folder / "vicon", "2017-11-22")]
    found = np.mean([otherwise(name, Trial(load_walk(path))) for path in paths])
    assert found < share, found


@pytest.mark.parametrize("name", ["shoe", "are"])
def test_zupt_agrees_with_the_host_on_a_simulated_walk(name):
    walk = simulator.simulate([*simulator.stand(2.0), *simulator.strides(12)], seed=3)
    assert agree(name, [Trial(walk)]) > 0.95


def test_differences_and_delays_are_counted_with_the_shift_taken_out():
    host = np.zeros(1000, dtype=bool)
    host[100:300] = host[500:600] = host[800:820] = True
    chip = np.roll(host, 10)
    assert differ(chip, host, 0) == pytest.approx(60 / 1000)
    assert differ(chip, host, 10) == 0
    chip[500:620] = False
    begins, ends, missed = delays(chip, host)
    assert (begins, ends, missed) == ([20.0], [20.0], 1)  # ms; the third is too short to count
    assert runs(host).tolist() == [[100, 300], [500, 600], [800, 820]]


def tune(*words, data=None):
    environment = {"PATH": "/usr/bin:/bin", "PYTHONPATH": str(ROOT)}
    if data:
        environment["TERAZI_DATA"] = str(data)
    command = [sys.executable, "-m", "tools.tune.zupt", *map(str, words)]
    return subprocess.run(
        command, capture_output=True, text=True, cwd=ROOT, env=environment, timeout=300
    )


def test_the_program_tells_figures_of_any_walks(tmp_path):
    assert "TERAZI_DATA" in tune().stderr
    walk = simulator.simulate([*simulator.stand(2.0), *simulator.strides(6)], seed=4)
    save_walk(tmp_path / "one.npz", walk)
    assert "two walks" in tune("--search", tmp_path).stderr
    save_walk(tmp_path / "two.npz", walk)
    done = tune("--json", tmp_path)
    assert done.returncode == 0, done.stderr
    reports = json.loads(done.stdout)
    assert tuple(reports) == design.detectors()
    assert reports["shoe"]["agree"] > 0.95
    assert reports["shoe"]["path_m"]["chip"] < 1.0
    assert "magnitude: share of time still" in tune(tmp_path).stdout
