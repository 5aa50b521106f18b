# SPDX-License-Identifier: MIT
"""Learnt detectors: the forward pass of a small recurrent network in plain numpy, from an .npz.

    gru8    one layer of 8 GRU cells on two inputs, | |a| - g | and |w|: 297 numbers
    lstm    the thesis's: 6 layers of 80 LSTM cells on the six axes, softmax of two classes;
            287 522 numbers, float16

Inputs `magnitudes` are in octaves, a tenth of log2 above a floor, for a stance and a swing differ
by decades and eight bits must hold both; `axes` are m/s^2 and rad/s by the scales of `train`.
Equations and the order of gates are PyTorch's. Both see only the past.

The .npz: kind, inputs, layers, rate_hz, accept, provenance; w_ih_k, w_hh_k, b_ih_k, b_hh_k of
layer k; w_out, b_out.
"""

from __future__ import annotations

import os
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from terazi.applications.walks.record import Walk
from terazi.errors import CannotRead, CannotWrite

GRAVITY_M_S2 = 9.81
ACC_FLOOR_M_S2, RATE_FLOOR_RAD_S, OCTAVES = 0.02, 0.01, 10.0
AXES_SCALE = np.array([9.81] * 3 + [2.0] * 3)
# An LSTM decides as it was trained: on windows of 100 samples of which the second half counts, each
# half a window after the one before. Run on for seconds it remembers too much and is a bit worse.
WINDOW, ABREAST = 100, 64
HALF = WINDOW // 2
# As many are multiplied together as BLAS leaves to one thread (fewer than 2^18 multiplications):
# threads that wait for each other after every sample are ten times slower on busy cores.
TOGETHER = 16
GATES = {"gru": 3, "lstm": 4}
NAMED = {name: Path(__file__).parent / f"{name}.npz" for name in ("gru8", "lstm")}
SHIPPED = NAMED["gru8"]
"""Weights that are shipped: by name, and which where none is named."""


@dataclass(frozen=True)
class Network:
    """Weights, and what they are for."""

    kind: str  # gru, lstm
    inputs: str  # magnitudes, axes
    rate_hz: float
    accept: float  # probability of zero velocity above which the foot stands
    layers: tuple[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray], ...]
    w_out: np.ndarray
    b_out: np.ndarray
    provenance: str = ""

    @property
    def parameters(self) -> int:
        """How many numbers it is made of."""
        return sum(each.size for layer in self.layers for each in layer) + (
            self.w_out.size + self.b_out.size
        )

    def probability(self, walk: Walk) -> np.ndarray:
        """(n,) of zero velocity, each sample knowing the past alone."""
        values = features(walk, self.inputs, self.rate_hz)
        if self.kind == "gru":
            for layer in self.layers:
                values = _gru_layer(values, *layer)
            score = values @ self.w_out.T + self.b_out
        else:
            score = _lstm_stack(values, self.layers, self.w_out, self.b_out)
        if score.shape[1] == 2:  # softmax of two is the sigmoid of their difference
            score = score[:, 1:] - score[:, :1]
        found = _sigmoid(score[:, 0])
        return at_walk_rate(found, walk, self.rate_hz)


def features(walk: Walk, inputs: str, rate_hz: float) -> np.ndarray:
    """(m, 2) or (m, 6) float32 inputs at the network's rate."""
    acc, gyro = walk.acc_b_m_s2, walk.gyro_b_rad_s
    if inputs == "magnitudes":
        away = np.abs(np.linalg.norm(acc, axis=1) - GRAVITY_M_S2)
        turning = np.linalg.norm(gyro, axis=1)
        values = np.column_stack(
            [octaves(away, ACC_FLOOR_M_S2), octaves(turning, RATE_FLOOR_RAD_S)]
        )
    else:
        values = np.hstack([acc, gyro]) / AXES_SCALE
    return np.asarray(_held(values, walk, rate_hz), dtype=np.float32)


def octaves(values: np.ndarray, floor: float) -> np.ndarray:
    """0 at the floor, 1 ten octaves above it."""
    return np.minimum(np.log2(np.maximum(values / floor, 1.0)) / OCTAVES, 1.0)


def _same_rate(walk: Walk, rate_hz: float) -> bool:
    return abs(walk.rate_hz / rate_hz - 1) < 0.02


def _held(values: np.ndarray, walk: Walk, rate_hz: float) -> np.ndarray:
    """At the network's rate, each the newest value there is: nothing of the future."""
    if _same_rate(walk, rate_hz):
        return values
    times_s = np.arange(walk.t_s[0], walk.t_s[-1] + 1e-9, 1 / rate_hz)
    return values[np.searchsorted(walk.t_s, times_s + 1e-9, side="right") - 1]


def at_walk_rate(values: np.ndarray, walk: Walk, rate_hz: float) -> np.ndarray:
    """Back at the walk's own samples, likewise."""
    if _same_rate(walk, rate_hz):
        return values
    index = np.floor((walk.t_s - walk.t_s[0]) * rate_hz + 1e-9).astype(np.int64)
    return values[np.clip(index, 0, len(values) - 1)]


def _sigmoid(values):
    return 1 / (1 + np.exp(-np.clip(values, -60, 60)))


def _gru_layer(values, w_ih, w_hh, b_ih, b_hh) -> np.ndarray:
    """(n, cells): one step after another, for each needs the one before."""
    cells = w_hh.shape[1]
    given = (values @ w_ih.T + b_ih).astype(np.float64)
    given[:, : 2 * cells] += b_hh[: 2 * cells]
    back, last = np.ascontiguousarray(w_hh.T, np.float64), b_hh[2 * cells :].astype(np.float64)
    out = np.empty((len(values), cells))
    state = np.zeros(cells)
    exp, tanh = np.exp, np.tanh
    for at in range(len(values)):
        seen = state @ back
        row = given[at]
        gates = 1 / (1 + exp(-(row[: 2 * cells] + seen[: 2 * cells])))
        new = tanh(row[2 * cells :] + gates[:cells] * (seen[2 * cells :] + last))
        state = new + gates[cells:] * (state - new)
        out[at] = state
    return out


def _lstm_stack(values, layers, w_out, b_out) -> np.ndarray:
    """(n, classes): windows half of which overlap, ABREAST of them side by side, all layers a
    sample. Before the record its first sample is held.

    Every product has the same shape however long the record is, so that the sums' order and with
    it the last bit do not depend on what comes later.
    """
    count = len(values)
    blocks = max(1, -(-count // (ABREAST * HALF)))
    padded = np.zeros((HALF + blocks * ABREAST * HALF, values.shape[1]), np.float32)
    padded[:HALF] = values[0]
    padded[HALF : HALF + count] = values
    layers = [_by_gates(*layer) for layer in layers]
    found = []
    for block in range(blocks):
        out = _lstm_block(padded, (block * ABREAST + np.arange(ABREAST)) * HALF, layers)
        found.append((out @ w_out.T + b_out).transpose(1, 0, 2).reshape(-1, len(b_out)))
    return np.concatenate(found)[:count]


def _by_gates(w_ih, w_hh, b_ih, b_hh) -> tuple[np.ndarray, np.ndarray]:
    """(4, inputs + cells, cells) and (4, 1, cells): each gate's one matrix of inputs and state, and
    its bias. Three gates' are halved: sigmoid(x) = (1 + tanh(x / 2)) / 2, so one tanh serves all.
    """
    cells = w_hh.shape[1]
    share = np.array([0.5, 0.5, 1.0, 0.5], np.float32)[:, None, None]
    both = np.hstack([w_ih, w_hh]).reshape(4, cells, -1) * share
    bias = (b_ih + b_hh).reshape(4, 1, cells) * share
    return np.ascontiguousarray(both.transpose(0, 2, 1)), bias


def _lstm_block(padded, begin, layers) -> np.ndarray:
    """(HALF, ABREAST, cells) of the second halves of the windows that begin there."""
    states = []
    shape = (len(begin) // TOGETHER, 1, TOGETHER)
    for both, bias in layers:
        _, wide, cells = both.shape
        feed = np.zeros((*shape, wide), np.float32)  # inputs, then the layer's state
        memory = np.zeros((*shape, cells), np.float32)
        states.append((both, bias, feed, memory, np.empty((shape[0], 4, TOGETHER, cells), "f4")))
    out = np.empty((HALF, len(begin), cells), np.float32)
    for at in range(WINDOW):
        given = padded[begin + at].reshape(*shape, -1)
        for both, bias, feed, memory, gates in states:
            cells = memory.shape[-1]
            feed[..., :-cells] = given
            np.matmul(feed, both, out=gates)
            gates += bias
            np.tanh(gates, out=gates)
            into, forget, fresh, outward = (gates[:, k : k + 1] for k in range(4))
            for gate in (into, forget, outward):
                gate += 1
                gate *= 0.5
            memory *= forget
            into *= fresh
            memory += into
            given = np.multiply(outward, np.tanh(memory), out=feed[..., -cells:])
        if at >= HALF:
            out[at - HALF] = given.reshape(len(begin), -1)
    return out


def load_network(path: Path) -> Network:
    """Read and check an .npz, or what is shipped by that name; CannotRead says what is wrong."""
    path = NAMED.get(str(path), path)
    try:
        with path.open("rb") as stream:
            archive = np.load(stream, allow_pickle=False)
            if not isinstance(archive, np.lib.npyio.NpzFile):
                raise CannotRead(f"{path}: no .npz archive")
            fields = {name: archive[name] for name in archive.files}
    except OSError as error:
        raise CannotRead(
            f"{path}: {error.strerror or error}",
            remedy=f"Shipped are {' and '.join(NAMED)}; `terazi walk train` writes others.",
        ) from None
    except (ValueError, EOFError, zipfile.BadZipFile) as error:
        raise CannotRead(f"{path}: {error}") from None
    try:
        return _network(fields)
    except (KeyError, ValueError, TypeError) as error:
        raise CannotRead(
            f"{path}: no weights of a detector: {error}",
            remedy="`terazi walk train` writes such a file.",
        ) from None


def _network(fields: dict) -> Network:
    kind, inputs = str(fields["kind"]), str(fields["inputs"])
    if kind not in GATES or inputs not in ("magnitudes", "axes"):
        raise ValueError(f"kind {kind!r} with inputs {inputs!r}")
    count = int(fields["layers"])
    layers = tuple(
        tuple(np.asarray(fields[f"{name}_{k}"], np.float32) for name in
              ("w_ih", "w_hh", "b_ih", "b_hh"))
        for k in range(count)
    )  # fmt: skip
    wide = 2 if inputs == "magnitudes" else 6
    for w_ih, w_hh, b_ih, b_hh in layers:
        cells = w_hh.shape[1]
        rows = GATES[kind] * cells
        if (w_ih.shape, w_hh.shape) != ((rows, wide), (rows, cells)) or (
            (b_ih.shape, b_hh.shape) != ((rows,), (rows,))
        ):
            raise ValueError(f"a layer of the shape {w_ih.shape}, {w_hh.shape}")
        wide = cells
    w_out, b_out = (np.asarray(fields[name], np.float32) for name in ("w_out", "b_out"))
    if w_out.shape not in ((1, wide), (2, wide)) or b_out.shape != w_out.shape[:1]:
        raise ValueError(f"an output of the shape {w_out.shape}")
    accept, rate_hz = float(fields["accept"]), float(fields["rate_hz"])
    if not (0 < accept < 1 and rate_hz > 0):
        raise ValueError(f"accept {accept}, rate_hz {rate_hz}")
    return Network(
        kind, inputs, rate_hz, accept, layers, w_out, b_out, str(fields.get("provenance", ""))
    )


def save_network(path: Path, network: Network) -> None:
    """Write what load_network reads; in half the bytes where that loses nothing."""
    fields = {}
    for k, layer in enumerate(network.layers):
        for name, values in zip(("w_ih", "w_hh", "b_ih", "b_hh"), layer, strict=True):
            half = values.astype(np.float16)
            fields[f"{name}_{k}"] = half if np.array_equal(half, values) else values
    with _opened(path) as stream:
        np.savez_compressed(
            stream,
            kind=network.kind,
            inputs=network.inputs,
            rate_hz=network.rate_hz,
            accept=network.accept,
            layers=len(network.layers),
            w_out=network.w_out,
            b_out=network.b_out,
            provenance=network.provenance,
            **fields,
        )


def check_place(path: Path) -> None:
    """CannotWrite where save_network could not write: training lasts too long to learn it then."""
    if path.is_dir() or not os.access(path if path.exists() else path.absolute().parent, os.W_OK):
        raise CannotWrite(f"{path}: cannot be written there")


def _opened(path: Path):
    try:
        return path.open("wb")
    except OSError as error:
        raise CannotWrite(f"{path}: {error.strerror or error}") from None
