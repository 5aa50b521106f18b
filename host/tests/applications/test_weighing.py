# SPDX-License-Identifier: MIT
"""The weighing experiment: the published order under its reading, and what the words claim."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from terazi.applications.weighing import Experiment, chains, score
from terazi.applications.weighing.score import SAME_NOISE, noise_at_rest, relative_error_pct
from terazi.cli import app


@pytest.fixture(scope="module")
def result():
    return score()


def test_published_order_of_the_three_comes_out(result):
    error = result.relative_error_pct
    assert error["kf"] > error["kf_fir"] > error["fir_kf"]


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_published_order_does_not_hang_on_the_seed(seed):
    error = score(Experiment(seed=seed, rest_s=30.0, steps=1)).relative_error_pct
    assert error["kf"] > error["kf_fir"] > error["fir_kf"]


def test_one_gain_in_either_order_is_one_system(result):
    facts = result.experiment
    # One whole count and a Q7 rounding may lie between them, behind the start-up.
    assert facts["same_gain_orders_apart_counts"] < 2.0
    assert facts["fir_kf_at_the_gain_of_kf_fir_pct"] == pytest.approx(
        result.relative_error_pct["kf_fir"], rel=0.03
    )


def test_adaptive_settles_in_a_quarter_of_the_time_of_a_constant_gain_as_quiet(result):
    noise, settling = result.noise_at_rest_counts, result.settling_s
    assert noise[SAME_NOISE] == pytest.approx(noise["adaptive"], rel=0.02)
    assert settling["adaptive"] <= settling[SAME_NOISE] / 4


def test_adaptive_is_quieter_than_every_common_filter(result):
    noise = result.noise_at_rest_counts
    assert noise["adaptive"] < min(noise[name] for name in chains.COMMON)


def test_mean_of_n_in_white_noise_meets_its_bound():
    experiment = Experiment()
    bound_counts = experiment.converter_noise_counts / np.sqrt(16)
    assert noise_at_rest(experiment, chains.mean_of(16)) == pytest.approx(bound_counts, rel=0.05)


@pytest.mark.parametrize("name", chains.COMMON)
def test_common_filters_answer_a_constant_with_itself(name):
    assert np.allclose(chains.COMMON[name](np.full(40, 1234, dtype=np.int32)), 1234.0)


def test_relative_error_counts_every_sample():
    assert relative_error_pct(np.array([1.0, 3.0]), np.array([2.0, 2.0])) == 50.0


def test_json_has_the_public_keys_and_nothing_else_is_printed(result):
    done = CliRunner().invoke(app, ["weigh", "score", "--json"])
    assert done.exit_code == 0
    plain = json.loads(done.stdout)
    assert plain == json.loads(json.dumps(result.plain()))  # seeded: the same every time
    assert set(plain) == {
        "experiment",
        "relative_error_pct",
        "settling_s",
        "noise_at_rest_counts",
        "bound_counts",
    }
    assert {"kf", "kf_fir", "fir_kf", "adaptive", *chains.COMMON} <= set(
        plain["relative_error_pct"]
    )
    assert {"adaptive", SAME_NOISE, *chains.COMMON} <= set(plain["settling_s"])


def test_table_says_where_the_order_matters():
    done = CliRunner().invoke(app, ["weigh", "score"])
    assert done.exit_code == 0
    text = " ".join(done.stdout.split())
    assert "published order comes out" in text
    assert "same linear system" in text
