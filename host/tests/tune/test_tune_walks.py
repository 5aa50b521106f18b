# SPDX-License-Identifier: MIT
"""The search for the walks' settings: who chooses is not judged, and what ships is."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from terazi.applications.walks import Errors, Options, estimate, path_errors, simulator
from terazi.applications.walks.formats import save_walk
from tools.tune import walks as tune

ROOT = Path(__file__).resolve().parents[3]
ROUTE = [*simulator.stand(1.5), *simulator.strides(5), *simulator.stand(0.5)]
WALKS = [simulator.simulate(ROUTE, seed=seed, name=f"walk {seed}") for seed in range(4)]


def nothing():
    """Nobody watches."""


def test_what_is_shipped_is_within_what_is_searched():
    now = tune.shipped()
    assert set(now) == set(tune.RANGES) == set(tune.START)
    for setting in (now, tune.START):
        assert all(low <= setting[key] <= high for key, (low, high) in tune.RANGES.items())


@pytest.mark.parametrize("causal", [False, True], ids=["recorded", "causal"])
def test_the_shipped_setting_is_judged_as_it_runs(causal):
    default = estimate(WALKS[0], Options(causal=causal))
    expected = path_errors(WALKS[0], default.path.pos_w_m)
    assert tune.errors_m(WALKS[0], tune.shipped(), causal=causal) == expected


def test_an_unrested_copy_begins_where_the_foot_moves_and_keeps_its_truth():
    walk = WALKS[0]
    copy = tune.unrested(walk)
    assert 1.2 < walk.t_s[-1] - walk.t_s[0] - (copy.t_s[-1] - copy.t_s[0]) < 1.6
    late = len(walk) - len(copy)
    assert np.array_equal(copy.truth.pos_t_m[-1], walk.truth.pos_t_m[-1])
    assert copy.truth.at[-1] == walk.truth.at[-1] - late
    assert np.array_equal(copy.gyro_b_rad_s, walk.gyro_b_rad_s[late:])


def test_a_change_stays_within_its_ranges_and_touches_no_more_than_asked():
    rng = np.random.default_rng(1)
    for _ in range(50):
        found = tune.changed(tune.START, rng, 3)
        assert sum(found[key] != tune.START[key] for key in found) <= 3
        assert all(low <= found[key] <= high for key, (low, high) in tune.RANGES.items())


def test_each_half_is_judged_by_what_the_other_half_chose(monkeypatch):
    """Errors as large as a walk's half wants: half 0 likes short windows, half 1 long ones."""

    trials = tune.trials_of(WALKS)
    halves = {trial.walk.name: trial.half for trial in trials}

    def liked(walk, setting, **_):
        error_m = 3 - setting["near_s"] if halves[walk.name] else setting["near_s"]
        return Errors(error_m, error_m, None)

    monkeypatch.setattr(tune, "errors_m", liked)
    assert [trial.half for trial in trials] == [0, 0, 1, 1, 0, 0, 1, 1]  # copies with originals
    for steps in (None, 60):
        found = tune.report(trials, steps, 1, nothing)["left_out"]
        short, long = (each["near_s"] for each in found["settings"])
        assert short < long
        assert found["mean_m"]["footprints"] == pytest.approx((long + 3 - short) / 2)


def test_a_search_only_betters_and_its_seed_repeats_it():
    trials = tune.trials_of(WALKS[:2])
    best, costs = tune.searched(trials, 4, 7, nothing)
    assert costs == sorted(costs, reverse=True)
    assert tune.cost(tune.means_m(trials, tune.run(trials, best, causal=True))) == costs[-1]
    assert tune.searched(trials, 4, 7, nothing) == (best, costs)


def test_the_program_tells_figures_of_any_walks(tmp_path):
    def run(*words):
        return subprocess.run(
            [sys.executable, "-m", "tools.tune.walks", *map(str, words)],
            capture_output=True,
            text=True,
            cwd=ROOT,
            env={"PATH": "/usr/bin:/bin", "PYTHONPATH": str(ROOT)},
            timeout=300,
        )

    assert "TERAZI_DATA" in run().stderr
    save_walk(tmp_path / "one.npz", WALKS[0])
    assert "two walks" in run(tmp_path).stderr
    save_walk(tmp_path / "two.npz", WALKS[1])
    done = run("--json", "--search", 2, tmp_path)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert 0 < found["shipped"]["recorded"]["mean_m"]["cameras"] < 0.3
    assert len(found["left_out"]["settings"]) == 2
    shown = run(tmp_path).stdout
    assert "cameras" in shown
    assert "half 1 chose" in shown
