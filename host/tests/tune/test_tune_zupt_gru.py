# SPDX-License-Identifier: MIT
"""The chip's learnt detector decides as the network in floats, and the program that says so."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from terazi.applications.walks import simulator
from terazi.applications.walks.formats import find_walks, load_walk, save_walk
from tools.tune.zupt import Trial
from tools.tune.zupt_gru import FOLDERS, agree_500hz, chip, counts_of, host, newest, summary

ROOT = Path(__file__).resolve().parents[3]


def simulated(seed, rate_hz=200.0):
    """Not the walk that rows are rounded for: another person, and a staircase more."""
    rng = np.random.default_rng(seed)
    pieces = [*simulator.stand(2.0), *simulator.strides(10, rng=rng), *simulator.staircase(8)]
    return simulator.simulate(pieces, seed=seed, rate_hz=rate_hz)


@pytest.mark.parametrize("rate_hz", [200.0, 256.0, 392.0])
def test_the_chip_decides_as_the_network_on_simulated_walks(rate_hz):
    for seed in (7, 8):
        walk = simulated(seed, rate_hz)
        assert np.mean(chip(walk) == host(walk)) >= 0.995
        assert 0.1 < host(walk).mean() < 0.9


def test_the_chip_at_the_devices_rate_decides_as_the_model_on_simulated_walks():
    assert agree_500hz(Trial(simulated(9))) >= 0.995


@pytest.mark.skipif("TERAZI_DATA" not in os.environ, reason="TERAZI_DATA is not set")
def test_the_chip_decides_as_the_network_on_recorded_walks():
    """Of all samples of all walks, and of each walk's own."""
    folder = Path(os.environ["TERAZI_DATA"]) / "walks"
    alike, samples = 0, 0
    for path in (path for name in FOLDERS for path in find_walks(folder / name)):
        same = chip(walk := load_walk(path)) == host(walk)
        assert same.mean() >= 0.995, path.name
        alike, samples = alike + same.sum(), samples + len(same)
    assert samples > 300_000
    assert alike / samples >= 0.998


def test_what_the_chip_is_given_is_the_newest_sample_in_whole_counts():
    walk = simulated(3, 500.0)
    at = newest(walk)
    assert at[:5].tolist() == [0, 2, 5, 7, 10]
    gyro, acc = counts_of(walk, at)
    np.testing.assert_allclose(np.degrees(walk.gyro_b_rad_s[at]) * 16.384, gyro, atol=0.5 + 1e-9)
    np.testing.assert_allclose(walk.acc_b_m_s2[at] * 2048 / 9.80665, acc, atol=0.5 + 1e-9)
    assert newest(simulated(3)).tolist() == list(range(len(simulated(3).t_s)))


def test_a_summary_weighs_by_samples_and_names_the_worst():
    rows = [
        {"walk": name, "samples": samples, "agree": agree, "agree_500hz": 1.0,
         "path_m": {"chip": path, "float": 1.0}}
        for name, samples, agree, path in (("a", 100, 1.0, None), ("b", 300, 0.9, 2.0))
    ]  # fmt: skip
    found = summary(rows)
    means = {"mean": pytest.approx(0.95), "samples": pytest.approx(0.925)}
    assert found["agree"] == {**means, "worst": 0.9, "worst_walk": "b"}
    assert found["path_m"] == {"chip": 2.0, "float": 1.0}


def tune(*words):
    environment = {"PATH": "/usr/bin:/bin", "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "tools.tune.zupt_gru", *map(str, words)]
    return subprocess.run(
        command, capture_output=True, text=True, cwd=ROOT, env=environment, timeout=300
    )


def test_the_program_tells_figures_of_any_walks(tmp_path):
    assert "TERAZI_DATA" in tune().stderr
    save_walk(tmp_path / "one.npz", simulated(4))
    done = tune("--json", tmp_path)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["all"]["agree"]["worst"] == found["walks"][0]["agree"] >= 0.995
    path_m = found["walks"][0]["path_m"]
    assert path_m["chip"] == pytest.approx(path_m["float"], abs=0.05)
    assert "worst" in tune(tmp_path).stdout
