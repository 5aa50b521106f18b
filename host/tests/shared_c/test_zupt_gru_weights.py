# SPDX-License-Identifier: MIT
"""zupt_gru's integers: how they come from the network in floats, and reproducibly."""

import dataclasses
import subprocess
import sys
import tomllib

import numpy as np
import pytest

from terazi.applications.walks import networks, simulator
from terazi.design import zupt as sensors
from terazi.design import zupt_gru as design
from tools.gen.spec import ROOT, load
from tools.gen.zupt_gru_weights import floats, weights
from tools.tune.zupt_gru import seen_table


def test_zupt_gru_rows_rounded_as_a_whole_err_less_than_weight_by_weight():
    rng = np.random.default_rng(3)
    source = rng.normal(size=(500, 3))
    seen = source @ rng.normal(size=(3, 8)) + 0.05 * rng.normal(size=(500, 8)) + 0.4
    mean, covariance = seen.mean(axis=0), np.cov(seen.T)
    for seed in range(5):
        row = np.random.default_rng(seed).uniform(-1, 1, 8)
        found, more = design.rounded_row(row, 51.2, mean, covariance)
        nearest = np.rint(row * 51.2)
        apart = [seen @ (each / 51.2 - row) for each in (found, nearest)]
        assert np.std(apart[0]) < 0.5 * np.std(apart[1])
        assert abs(np.mean(apart[0]) + more) < 1e-6
        assert np.abs(found - row * 51.2).max() < 3.5
    most = design.rounded_row([9.0] * 8, 51.2, mean, covariance)[0]
    assert np.abs(most).max() == design.WEIGHT_MAX


def test_zupt_gru_gates_err_by_a_quarter_of_what_nearest_weights_would():
    """Over another walk than the one that they are rounded for."""
    pieces = [*simulator.stand(2.0), *simulator.strides(15, rng=np.random.default_rng(5))]
    inputs = networks.features(simulator.simulate(pieces, seed=5), "magnitudes", 200.0)
    before = np.vstack([np.zeros((1, 8)), design.states(floats(), inputs.astype(float))[:-1]])
    seen = np.hstack([inputs * 1.25, before])
    rows = np.hstack([floats().w_ih / 1.25, floats().w_hh])
    apart, nearest = [], []
    for n, unit in enumerate(weights().units):
        for gate in range(2):
            at = gate * 8 + n
            column = np.array([row[gate] for row in (*unit.inputs, *unit.states)])
            # Less half a sum of each of the ten products, which lose that by being rounded down.
            bias = (unit.bias[gate] - 5) / (51.2 * 32) - floats().b_ih[at] - floats().b_hh[at]
            apart.append(seen @ (column / 51.2 - rows[at]) + bias)
            nearest.append(seen @ (np.rint(rows[at] * 51.2) / 51.2 - rows[at]))
    error, other = (np.sqrt(np.mean(np.square(each))) for each in (apart, nearest))
    assert error < 0.003
    assert error < 0.25 * other


def test_zupt_gru_weights_that_would_overflow_are_refused():
    spec = load("zupt_gru").content
    wild = dataclasses.replace(floats(), b_ih=floats().b_ih + 15.0)
    with pytest.raises(ValueError, match="leaves 16 bits"):
        design.quantise(wild, spec)
    with pytest.raises(ValueError, match="output's sum leaves 16 bits"):
        design.quantise(dataclasses.replace(floats(), b_out=15.0), spec)


def test_zupt_gru_takes_no_other_network():
    with np.load(networks.SHIPPED) as archive:
        fields = dict(archive)
    spec = load("zupt_gru").content
    assert design.floats(fields, spec).accept == 0.7
    for name, other in (("kind", "lstm"), ("inputs", "axes"), ("layers", 2), ("rate_hz", 100.0)):
        with pytest.raises(ValueError, match="one layer of a gru of magnitudes at 200 Hz"):
            design.floats({**fields, name: np.array(other)}, spec)


def test_zupt_gru_spec_has_the_inputs_of_the_network_and_what_the_tool_prints():
    """Of sums over thousands of steps the last digit may differ on another machine."""
    spec = load("zupt_gru").content
    assert spec["inputs"] == {
        "gravity_m_s2": networks.GRAVITY_M_S2,
        "acc_floor_m_s2": networks.ACC_FLOOR_M_S2,
        "rate_floor_rad_s": networks.RATE_FLOOR_RAD_S,
    }
    assert spec["sensor"] == sensors.spec()["sensor"]
    printed = tomllib.loads(seen_table())["seen"]
    np.testing.assert_allclose(spec["seen"]["mean"], printed["mean"], atol=2e-5)
    for row, wanted in zip(spec["seen"]["covariance"], printed["covariance"], strict=True):
        np.testing.assert_allclose(row, wanted, atol=2e-5)


def test_zupt_gru_weights_are_made_without_the_c_that_they_are_for():
    code = (
        "import sys; from tools.gen import run; run.outputs();"
        "sys.exit(any(name.startswith('terazi.cshared') for name in sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=False).returncode == 0


def test_zupt_gru_weights_are_made_again_byte_for_byte_by_another_process():
    code = (
        "from tools.gen import zupt_gru_weights as z; from tools.gen.spec import load;"
        "import sys; s = load('zupt_gru'); sys.stdout.write(z.header(s) + z.source(s))"
    )
    made = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    files = [ROOT / f"shared_c/generated/zupt_gru_weights.{ending}" for ending in "hc"]
    assert made.stdout == "".join(path.read_text(encoding="utf-8") for path in files)
    assert "sha256" in files[1].read_text()
    assert "learning_rate" in files[1].read_text()
