# SPDX-License-Identifier: MIT
"""Learnt detectors: the forward pass, the file, and that nothing but training needs PyTorch."""

import importlib.util
import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from terazi.applications.walks import (
    Options,
    estimate,
    find_walks,
    load_walk,
    path_errors,
    score,
    simulator,
)
from terazi.applications.walks.networks import (
    HALF,
    NAMED,
    SHIPPED,
    WINDOW,
    Network,
    check_place,
    features,
    load_network,
    octaves,
    save_network,
)
from terazi.errors import CannotRead, CannotWrite

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


def in_windows(net, values, run):
    """What `run` finds; of an LSTM in windows, the first one begun by the first sample, held."""
    if net.kind == "gru":
        return run(net, values)
    count = len(values)
    padded = np.concatenate([np.repeat(values[:1], HALF, axis=0), values, np.zeros((WINDOW, 6))])
    found = [
        run(net, padded[at : at + WINDOW].astype(np.float32))[HALF:] for at in range(0, count, HALF)
    ]
    return np.concatenate(found)[:count]


@pytest.mark.parametrize(
    ("kind", "inputs", "classes"), [("gru", "magnitudes", 1), ("lstm", "axes", 2)]
)
def test_the_forward_pass_is_the_documented_equations(kind, inputs, classes):
    net = network(kind, inputs, classes=classes)
    short = WALK.cut(333)
    expected = in_windows(net, features(short, inputs, 200.0), slow)
    assert np.allclose(net.probability(short), expected, atol=2e-6 if kind == "gru" else 1e-5)


@pytest.mark.parametrize("count", [300, 555])
@pytest.mark.parametrize(
    "net", [network(), network("lstm", "axes", classes=2)], ids=lambda n: n.kind
)
def test_a_network_knows_nothing_of_the_future(net, count):
    assert np.array_equal(net.probability(WALK.cut(count)), net.probability(WALK)[:count])


def test_what_comes_later_changes_no_bit_of_a_long_record():
    """One more block of stretches, and the products' shapes are still the same."""
    net = network("lstm", "axes", cells=3, classes=2)
    long = simulator.simulate([*simulator.stand(2), *simulator.strides(45)], seed=2)
    assert len(long) > 7000
    assert np.array_equal(net.probability(long.cut(6500)), net.probability(long)[:6500])


@pytest.mark.parametrize("half", [False, True])
def test_a_network_saved_is_the_network_loaded(tmp_path, half):
    net = network("lstm", "axes", classes=2)
    if half:
        layers = tuple(tuple(np.float32(np.float16(a)) for a in layer) for layer in net.layers)
        net = replace(net, layers=layers)
    path = tmp_path / "n.npz"
    save_network(path, net)
    again = load_network(path)
    assert np.array_equal(again.probability(WALK), net.probability(WALK))
    assert (again.kind, again.rate_hz, again.accept, again.parameters) == (
        *(net.kind, net.rate_hz, net.accept, net.parameters),
    )
    with np.load(path) as archive:
        assert archive["w_hh_1"].dtype == (np.float16 if half else np.float32)


def test_shipped_weights_are_known_by_name():
    assert load_network(Path("lstm")).parameters == load_network(NAMED["lstm"]).parameters
    with pytest.raises(CannotRead, match="lsmt") as refused:
        load_network(Path("lsmt"))
    assert "gru8 and lstm" in refused.value.remedy


def test_octaves_run_from_the_floor_to_a_thousandfold():
    assert octaves(np.array([0.0, 0.02, 0.04, 20.48, 99.0]), 0.02) == pytest.approx(
        [0, 0, 0.1, 1, 1]
    )


def test_the_shipped_network_is_the_one_that_fits_the_chip():
    net = load_network(SHIPPED)
    assert (net.kind, net.inputs, net.parameters) == ("gru", "magnitudes", 297)
    assert json.loads(net.provenance)["training"]["seed"] >= 0


def test_the_shipped_lstm_is_the_one_of_the_thesis():
    net = load_network(NAMED["lstm"])
    assert (net.kind, net.inputs, net.parameters, len(net.layers)) == ("lstm", "axes", 287522, 6)
    assert net.w_out.shape == (2, 80)
    assert json.loads(net.provenance)["training"]["window"] == 100
    assert NAMED["lstm"].stat().st_size <= 600_000


@pytest.mark.parametrize("name", NAMED)
def test_a_shipped_network_brings_a_walker_home(name):
    walk = simulator.simulate(simulator.square(10.0), seed=11)
    path = estimate(walk, Options(detector="learnt", weights=NAMED[name])).path
    assert path_errors(walk, path.pos_w_m).rmse_2d_m < 1.0


@pytest.mark.parametrize(("folder", "limit_m"), [("vicon", 0.12), ("footprints", 1.0)])
def test_the_shipped_lstm_serves_walkers_it_saw_and_walkers_it_never_saw(folder, limit_m):
    """It was trained on the first folder alone."""
    data = os.environ.get("TERAZI_DATA")
    if data is None:
        pytest.skip("TERAZI_DATA is unset: no recorded walks to score")
    options = Options(detector="learnt", weights=NAMED["lstm"], causal=True)
    walks = [load_walk(path) for path in find_walks(Path(data) / "walks" / folder)]
    found = score(walks, lambda walk: estimate(walk, options).path.pos_w_m)
    assert found.mean.rmse_2d_m <= limit_m


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


WATCHED = """
import sys
class Watch:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] == "torch":
            print("asked for torch")
            raise ImportError(name)
sys.meta_path.insert(0, Watch())
import terazi
import terazi.cli
from terazi.applications.walks import training, tables, page
sys.argv = ["terazi", "walk", *sys.argv[1:]]
terazi.cli.main()
"""


def watched(*words):
    """(exit code, what is told, what is complained of) of `terazi walk` where torch is missed."""
    done = subprocess.run(
        [sys.executable, "-c", WATCHED, *map(str, words)], capture_output=True, text=True
    )
    return done.returncode, done.stdout, done.stderr


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("walks")
    np.savez(made / "short.npz", imu=np.hstack([WALK.acc_b_m_s2, WALK.gyro_b_rad_s]), ts=WALK.t_s)
    return made


@pytest.mark.parametrize("name", NAMED)
def test_importing_terazi_and_walking_never_imports_torch(folder, name):
    code, told, complaint = watched(
        "score", folder, "--detector", "learnt", "--weights", name, "--json"
    )
    assert code == 0, complaint
    assert set(json.loads(told)["trials"]) == {"short"}


def test_training_without_torch_is_refused_with_what_to_install(folder, tmp_path):
    code, told, complaint = watched("train", folder, "-o", tmp_path / "n.npz")
    assert (code, told) == (2, "asked for torch\n")
    assert complaint.splitlines() == [
        "error: training needs PyTorch",
        "Install it: pip install 'terazi[train]'",
    ]
    assert not (tmp_path / "n.npz").exists()


def test_where_weights_cannot_be_written_is_known_before_training(tmp_path):
    check_place(tmp_path / "n.npz")
    assert not (tmp_path / "n.npz").exists()
    for place in (tmp_path, tmp_path / "none" / "n.npz"):
        with pytest.raises(CannotWrite, match=place.name):
            check_place(place)


@needs_torch
def test_training_repeats_with_its_seed_and_learns_the_labels():
    from terazi.applications.walks import training

    walk = simulator.simulate([*simulator.stand(2), *simulator.strides(12)], seed=5)
    asked = replace(training.GRU8, epochs=25, windows_per_epoch=128)
    first, again = (training.train([walk], asked) for _ in range(2))
    assert all(np.array_equal(a, b) for a, b in zip(first.layers[0], again.layers[0], strict=True))
    agreed = (first.probability(walk) > 0.5) == walk.zero_velocity
    assert agreed.mean() > 0.9


@needs_torch
def test_six_layers_of_lstm_begin_to_learn_at_once():
    from terazi.applications.walks import training

    walk = simulator.simulate([*simulator.stand(2), *simulator.strides(12)], seed=5)
    asked = replace(training.LSTM, cells=20, epochs=120, windows_per_epoch=32, batch=32)
    losses = []
    net = training.train([walk], asked, progress=lambda _share, loss: losses.append(loss))
    assert len(losses) == 120
    assert losses[0] > 0.6  # ln 2: it knows nothing yet
    assert losses[-1] < 0.4
    assert all(np.array_equal(a, np.float16(a)) for layer in net.layers for a in layer)


@needs_torch
@pytest.mark.parametrize("name", NAMED)
def test_plain_numpy_is_torch(name):
    import torch

    net = load_network(NAMED[name])
    gru = net.kind == "gru"
    wide, cells = net.layers[0][0].shape[1], net.layers[0][1].shape[1]
    core = (torch.nn.GRU if gru else torch.nn.LSTM)(wide, cells, len(net.layers))
    with torch.no_grad():
        for k, layer in enumerate(net.layers):
            for part, array in zip(
                ("weight_ih", "weight_hh", "bias_ih", "bias_hh"), layer, strict=True
            ):
                getattr(core, f"{part}_l{k}").copy_(torch.from_numpy(array))

    def run(_net, values):
        with torch.no_grad():
            found = core(torch.from_numpy(values)[:, None])[0][:, 0]
            score = found @ torch.from_numpy(net.w_out.T) + torch.from_numpy(net.b_out)
            return (torch.sigmoid(score[:, 0]) if gru else torch.softmax(score, 1)[:, 1]).numpy()

    expected = in_windows(net, features(WALK, net.inputs, net.rate_hz), run)
    assert np.allclose(net.probability(WALK), expected, atol=1e-4)
