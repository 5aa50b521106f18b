# SPDX-License-Identifier: MIT
"""Learnt detectors: the forward pass, the file, and that nothing but training needs PyTorch."""

import importlib.util
import json
import subprocess
import sys

import numpy as np
import pytest

from terazi.applications.walks import Options, estimate, path_errors, simulator
from terazi.applications.walks.networks import (
    SHIPPED,
    Network,
    features,
    load_network,
    octaves,
    save_network,
)
from terazi.errors import CannotRead

WALK = simulator.simulate([*simulator.stand(2), *simulator.strides(4)], seed=2)
GATES = {"gru": 3, "lstm": 4}

needs_torch = pytest.mark.skipif(
    importlib.util.find_spec("torch") is None, reason="PyTorch, the extra [train], is not installed"
)


def network(kind="gru", inputs="magnitudes", cells=5, layers=2, classes=1, seed=1):
    """One at random."""
    rng = np.random.default_rng(seed)
    wide = 2 if inputs == "magnitudes" else 6
    made = []
    for _ in range(layers):
        rows = GATES[kind] * cells
        shapes = ((rows, wide), (rows, cells), (rows,), (rows,))
        made.append(tuple(rng.normal(0, 0.5, shape).astype(np.float32) for shape in shapes))
        wide = cells
    out = rng.normal(0, 1, (classes, cells)).astype(np.float32)
    return Network(kind, inputs, 200.0, 0.5, tuple(made), out, np.zeros(classes, np.float32), "{}")


def sigmoid(x):
    return 1 / (1 + np.exp(-x))


def slow(net, values):
    """PyTorch's documented equations, one gate at a time, in float64."""
    for w_ih, w_hh, b_ih, b_hh in net.layers:
        cells = w_hh.shape[1]
        state = memory = np.zeros(cells)
        rows = []
        for x in values:
            given, seen = w_ih @ x + b_ih, w_hh @ state + b_hh
            part = [slice(k * cells, (k + 1) * cells) for k in range(4)]
            if net.kind == "gru":
                reset, update = (sigmoid(given[part[k]] + seen[part[k]]) for k in (0, 1))
                new = np.tanh(given[part[2]] + reset * seen[part[2]])
                state = (1 - update) * new + update * state
            else:
                total = given + seen
                memory = sigmoid(total[part[1]]) * memory + sigmoid(total[part[0]]) * np.tanh(
                    total[part[2]]
                )
                state = sigmoid(total[part[3]]) * np.tanh(memory)
            rows.append(state)
        values = np.array(rows)
    score = values @ net.w_out.T + net.b_out
    if score.shape[1] == 1:
        return sigmoid(score[:, 0])
    both = np.exp(score)
    return both[:, 1] / both.sum(axis=1)


@pytest.mark.parametrize(
    ("kind", "inputs", "classes"), [("gru", "magnitudes", 1), ("lstm", "axes", 2)]
)
def test_the_forward_pass_is_the_documented_equations(kind, inputs, classes):
    net = network(kind, inputs, classes=classes)
    short = WALK.cut(300)
    expected = slow(net, features(short, inputs, 200.0))
    assert np.allclose(net.probability(short), expected, atol=2e-6 if kind == "gru" else 1e-5)


def test_stretches_of_an_lstm_join_without_a_seam():
    """Cells forget: 100 samples of warming up are as good as the whole past."""
    net = network("lstm", "axes", classes=2)
    expected = slow(net, features(WALK, "axes", 200.0))
    assert len(WALK) > 800
    assert np.allclose(net.probability(WALK), expected, atol=1e-3)


@pytest.mark.parametrize("count", [300, 555])
def test_a_network_knows_nothing_of_the_future(count):
    net = network()
    assert np.array_equal(net.probability(WALK.cut(count)), net.probability(WALK)[:count])


def test_a_network_saved_is_the_network_loaded(tmp_path):
    net = network("lstm", "axes", classes=2)
    save_network(tmp_path / "n.npz", net)
    again = load_network(tmp_path / "n.npz")
    assert np.array_equal(again.probability(WALK), net.probability(WALK))
    assert (again.kind, again.rate_hz, again.accept, again.parameters) == (
        *(net.kind, net.rate_hz, net.accept, net.parameters),
    )


def test_octaves_run_from_the_floor_to_a_thousandfold():
    assert octaves(np.array([0.0, 0.02, 0.04, 20.48, 99.0]), 0.02) == pytest.approx(
        [0, 0, 0.1, 1, 1]
    )


def test_the_shipped_network_is_the_one_that_fits_the_chip():
    net = load_network(SHIPPED)
    assert (net.kind, net.inputs, net.parameters) == ("gru", "magnitudes", 297)
    assert json.loads(net.provenance)["training"]["seed"] >= 0


def test_the_shipped_network_brings_a_walker_home():
    walk = simulator.simulate(simulator.square(10.0), seed=11)
    path = estimate(walk, Options(detector="learnt")).path
    assert path_errors(walk, path.pos_w_m).rmse_2d_m < 1.0


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda f: f.pop("w_out"), "w_out"),
        (lambda f: f.update(kind="cnn"), "kind 'cnn'"),
        (lambda f: f.update(w_hh_0=np.zeros((3, 2))), "a layer of the shape"),
        (lambda f: f.update(accept=1.5), "accept 1.5"),
        (lambda f: f.update(w_out=np.zeros((1, 99))), "an output of the shape"),
    ],
)
def test_spoilt_weights_are_refused_with_what_is_wrong(tmp_path, spoil, words):
    path = tmp_path / "n.npz"
    save_network(path, network())
    with np.load(path) as archive:
        fields = dict(archive)
    spoil(fields)
    np.savez(path, **fields)
    with pytest.raises(CannotRead, match=words) as refused:
        load_network(path)
    assert "train" in refused.value.remedy


def test_importing_terazi_and_walking_never_imports_torch():
    program = (
        "import sys; sys.modules['torch'] = None\n"
        "import terazi.cli\n"
        "from terazi.applications import walks\n"
        "from terazi.applications.walks import simulator, training, tables, page\n"
        "walk = simulator.simulate(simulator.circle(3.0), seed=1)\n"
        "walks.estimate(walk, walks.Options(detector='learnt'))\n"
        "try: training.train([walk], training.GRU8)\n"
        "except Exception as error: print(error.remedy)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "terazi[train]" in done.stdout


@needs_torch
def test_training_repeats_with_its_seed_and_learns_the_labels():
    from dataclasses import replace

    from terazi.applications.walks import training

    walk = simulator.simulate([*simulator.stand(2), *simulator.strides(12)], seed=5)
    asked = replace(training.GRU8, epochs=25, windows_per_epoch=128)
    first, again = (training.train([walk], asked) for _ in range(2))
    assert all(np.array_equal(a, b) for a, b in zip(first.layers[0], again.layers[0], strict=True))
    agreed = (first.probability(walk) > 0.5) == walk.zero_velocity
    assert agreed.mean() > 0.9
