# SPDX-License-Identifier: MIT
"""The search for settings: what is left out is left out, and the program runs on any trials."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from host.tests.applications.synthetic import write
from tools.tune.attitude import SEARCHES, leave_one_out, shipped, split

ROOT = Path(__file__).resolve().parents[3]

tables = arrays(
    np.float64,
    st.tuples(st.integers(1, 6), st.integers(2, 6)),
    elements=st.floats(0, 10, allow_subnormal=False),
)


def test_a_setting_that_only_its_own_trial_likes_is_not_chosen_for_it():
    """The second setting is the best on average thanks to trial 2 alone."""
    errors = np.array([[1.0, 1.0, 9.0], [2.0, 2.0, 0.0]])
    chosen, left_out = leave_one_out(errors)
    assert chosen.tolist() == [1, 1, 0]
    assert left_out.tolist() == [2.0, 2.0, 9.0]


@given(errors=tables, trial=st.data(), spoilt=st.floats(0, 10))
def test_the_trial_left_out_has_no_part_in_the_choice(errors, trial, spoilt):
    at = trial.draw(st.integers(0, errors.shape[1] - 1))
    others = np.delete(errors, at, axis=1).mean(axis=1)
    chosen, left_out = leave_one_out(errors)
    assert others[chosen[at]] <= others.min() + 1e-9
    assert left_out[at] == errors[chosen[at], at]
    assert left_out.mean() >= errors.min(axis=0).mean()


def test_settings_that_the_chip_cannot_hold_are_never_chosen():
    chosen, left_out = leave_one_out(np.array([[np.inf, np.inf], [1.0, 2.0]]))
    assert chosen.tolist() == [1, 1]
    assert np.isfinite(left_out).all()


@pytest.mark.parametrize("name", SEARCHES)
def test_what_is_shipped_was_searched(name):
    """Else the program could not say how good it is."""
    assert shipped(SEARCHES[name]) in SEARCHES[name].settings()


def test_keys_go_to_the_module_that_has_them():
    of_mahony, of_rest = split({"tau_s": 3.0, "limits": 2.0, "bias_s": 5.0})
    assert of_mahony == {"tau_s": 3.0}
    assert of_rest["bias_s"] == 5.0
    assert of_rest["leave_acc_m_s2"] == pytest.approx(1.5)


def tune(*words, data=None):
    environment = {"PATH": "/usr/bin:/bin", "PYTHONPATH": str(ROOT)}
    if data:
        environment["TERAZI_DATA"] = str(data)
    command = [sys.executable, "-m", "tools.tune.attitude", *map(str, words)]
    return subprocess.run(
        command, capture_output=True, text=True, cwd=ROOT, env=environment, timeout=300
    )


def test_the_program_says_what_it_lacks(tmp_path):
    assert "TERAZI_DATA" in tune().stderr
    write(tmp_path / "one.npz", rest_s=0.5, move_s=1.0)
    few = tune(tmp_path)
    assert few.returncode == 2
    assert "three trials" in few.stderr


def test_the_program_finds_settings_on_trials_of_any_length(tmp_path):
    folder = tmp_path / "attitude" / "broad"
    folder.mkdir(parents=True)
    for seed in range(3):
        write(folder / f"{seed}.npz", rate_hz=100.0, rest_s=2.0, move_s=1.0, seed=seed)
    done = tune("--json", data=tmp_path)
    assert done.returncode == 0, done.stderr
    reports = json.loads(done.stdout)
    assert list(reports) == list(SEARCHES)
    for report in reports.values():
        assert sum(choice["times"] for choice in report["left_out"]["chosen"]) == 3
        assert report["best"]["mean"] <= report["shipped"]["mean"]
        assert report["best"]["mean"] <= report["left_out"]["mean"]
    assert "left out" in tune(folder).stdout
