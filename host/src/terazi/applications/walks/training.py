# SPDX-License-Identifier: MIT
"""Trains a learnt detector: PyTorch, which only this needs (the extra [train]), on one thread.

As the thesis has it: Adam, cross-entropy, windows of 100 samples at 200 Hz; each window turned at
random, scaled by 0.9 to 1.1, with noise of sigma 0.075 (m/s^2 and, a tenth of that, rad/s). Labels
are those of a classical detector whose threshold was chosen trial by trial: the record's own
(`zv_*_opt`), or SHOE's with the threshold whose path lies nearest to the truth. A window's first
half only warms the cells up. Same seed, same machine, same weights.

Six layers of LSTM learn next to nothing at first at a learning rate of 1e-3 that only sinks. Two
things help: three times that rate, which rises and then sinks (one cycle; Smith 2018), and first
weights that let a signal through (orthogonal recurrences, Xavier's for inputs, a bias of 1 for the
forget gates; Jozefowicz, Zaremba, Sutskever 2015). Loss after 50 steps of 64 windows: 0.65 without,
0.53 to 0.54 with either or both; the rate matters more later on.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np

from terazi.applications.walks import detectors
from terazi.applications.walks.navigator import KalmanSettings, kalman
from terazi.applications.walks.networks import Network, features
from terazi.applications.walks.record import Walk
from terazi.applications.walks.score import path_errors
from terazi.errors import CannotRead, UsageError

RATE_HZ = 200.0
SHOE_GRID_RAD_S = tuple(np.geomspace(0.15, 2.5, 13))


@dataclass(frozen=True)
class Training:
    """What is trained and how."""

    kind: str = "gru"
    cells: int = 8
    layers: int = 1
    inputs: str = "magnitudes"
    window: int = 100
    epochs: int = 300
    windows_per_epoch: int = 512
    batch: int = 128
    learning_rate: float = 5e-3
    noise: float = 0.075
    accept: float = 0.7  # the thesis's 0.85 misses whole stances of other walkers
    seed: int = 1
    rise: float = 0.0  # share of the steps in which the learning rate rises; then it only sinks
    stored: str = "float32"  # what the weights are rounded to at the end


GRU8 = Training(epochs=400)
LSTM = Training(
    kind="lstm",
    cells=80,
    layers=6,
    inputs="axes",
    windows_per_epoch=1280,
    batch=64,
    learning_rate=3e-3,
    rise=0.1,
    stored="float16",
)
KINDS = {"gru8": GRU8, "lstm": LSTM}


def labels_of(walk: Walk) -> np.ndarray:
    """(n,) bool: the record's own, or SHOE's with the threshold that suits this walk best."""
    if walk.zero_velocity is not None:
        return walk.zero_velocity
    if walk.truth is None:
        raise CannotRead(f"{walk.name}: neither labels nor a path from which to choose them")
    best = None
    for threshold in SHOE_GRID_RAD_S:
        settings = replace(detectors.SHOE, threshold=float(threshold))
        detection = detectors.shoe_detector(walk, settings, causal=False)
        if detection.still.mean() < 0.02:
            continue
        path = kalman(walk, detection, KalmanSettings(), causal=True)
        error_m = path_errors(walk, path.pos_w_m).rmse_2d_m
        if best is None or error_m < best[0]:
            best = (error_m, detection.still)
    if best is None:
        raise CannotRead(f"{walk.name}: no threshold finds a stance")
    return best[1]


def turned_scaled_noisy(acc, gyro, rng: np.random.Generator, noise: float):
    """(b, w, 3) twice, each window augmented by itself; float32."""
    count = len(acc)
    quats = rng.standard_normal((count, 4))
    quats /= np.linalg.norm(quats, axis=1, keepdims=True)
    w, x, y, z = quats.T
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    ).transpose(2, 0, 1)
    scale = rng.uniform(0.9, 1.1, (count, 1, 1))
    found = []
    for values, sigma in ((acc, noise), (gyro, noise / 10)):
        values = np.einsum("bij,bwj->bwi", turn, values) * scale
        found.append(values + sigma * rng.standard_normal(values.shape))
    return found


def pytorch():
    """The library; UsageError with what to do where there is none."""
    try:
        import torch
    except ImportError:
        raise UsageError(
            "training needs PyTorch", remedy="Install it: pip install 'terazi[train]'"
        ) from None
    torch.set_num_threads(1)  # two threads of so small a net wait for each other: ten times slower
    return torch


def train(
    walks: Sequence[Walk],
    training: Training,
    *,
    progress: Callable[[float, float], None] | None = None,
) -> Network:
    """The trained network; progress is told the share done and the loss of the last 20 steps."""
    torch = pytorch()
    for walk in walks:
        if abs(walk.rate_hz / RATE_HZ - 1) > 0.02:
            raise CannotRead(f"{walk.name}: {walk.rate_hz:.0f} samples a second, not {RATE_HZ:g}")
    if not walks:
        raise UsageError("nothing to train on")
    labels = [labels_of(walk) for walk in walks]
    rng = np.random.default_rng(training.seed)
    torch.manual_seed(training.seed)
    wide = 2 if training.inputs == "magnitudes" else 6
    core = (torch.nn.GRU if training.kind == "gru" else torch.nn.LSTM)(
        wide, training.cells, training.layers, batch_first=True
    )
    if training.kind == "lstm":
        _open_gates(torch, core)
    classes = 1 if training.kind == "gru" else 2
    head = torch.nn.Linear(training.cells, classes)
    weights = [*core.parameters(), *head.parameters()]
    optimiser = torch.optim.Adam(weights, lr=training.learning_rate)
    steps = training.epochs * max(1, training.windows_per_epoch // training.batch)
    schedule = _schedule(torch, optimiser, training, steps)
    half, seen = training.window // 2, None
    for step in range(steps):
        inputs, wanted = _batch(walks, labels, training, rng)
        out = head(core(torch.from_numpy(inputs))[0])[:, half:]
        goal = torch.from_numpy(wanted[:, half:])
        if classes == 1:
            loss = torch.nn.functional.binary_cross_entropy_with_logits(out[..., 0], goal.float())
        else:
            loss = torch.nn.functional.cross_entropy(out.reshape(-1, 2), goal.long().reshape(-1))
        optimiser.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(weights, 1.0)
        optimiser.step()
        schedule.step()
        seen = float(loss.detach()) if seen is None else 0.95 * seen + 0.05 * float(loss.detach())
        if progress:
            progress((step + 1) / steps, seen)

    def rounded(tensor):
        return tensor.detach().numpy().astype(training.stored).astype(np.float32)

    layers = tuple(
        tuple(rounded(getattr(core, f"{name}_l{k}"))
              for name in ("weight_ih", "weight_hh", "bias_ih", "bias_hh"))
        for k in range(training.layers)
    )  # fmt: skip
    return Network(
        training.kind,
        training.inputs,
        RATE_HZ,
        training.accept,
        layers,
        rounded(head.weight),
        rounded(head.bias),
        _provenance(walks, labels, training, torch.__version__),
    )


def _open_gates(torch, core) -> None:
    """First weights through which a signal passes at its own size."""
    cells = core.hidden_size
    with torch.no_grad():
        for name, values in core.named_parameters():
            if name.startswith("bias"):
                values.zero_()
                if name.startswith("bias_ih"):
                    values[cells : 2 * cells] = 1.0  # the forget gate's, second of four
                continue
            begin = torch.nn.init.orthogonal_ if "hh" in name else torch.nn.init.xavier_uniform_
            for gate in values.chunk(4):
                begin(gate)


def _schedule(torch, optimiser, training: Training, steps: int):
    """How the learning rate changes, step by step."""
    if not training.rise:
        return torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, steps)
    return torch.optim.lr_scheduler.OneCycleLR(
        optimiser,
        training.learning_rate,
        total_steps=steps + 1,  # it is asked for one more than it takes
        pct_start=training.rise,
        cycle_momentum=False,
    )


def _batch(walks, labels, training: Training, rng) -> tuple[np.ndarray, np.ndarray]:
    """(b, w, inputs) float32 and (b, w) bool; every trial as likely as another."""
    acc, gyro, wanted = [], [], []
    for pick in rng.integers(len(walks), size=training.batch):
        walk = walks[pick]
        begin = int(rng.integers(max(1, len(walk) - training.window)))
        span = slice(begin, begin + training.window)
        acc.append(walk.acc_b_m_s2[span])
        gyro.append(walk.gyro_b_rad_s[span])
        wanted.append(labels[pick][span])
    acc, gyro = turned_scaled_noisy(np.array(acc), np.array(gyro), rng, training.noise)
    flat = Walk("", np.arange(acc[..., 0].size) / RATE_HZ, acc.reshape(-1, 3), gyro.reshape(-1, 3))
    inputs = features(flat, training.inputs, RATE_HZ).reshape(training.batch, training.window, -1)
    return inputs, np.array(wanted)


def _provenance(walks, labels, training: Training, version: str) -> str:
    """JSON: on what, with what, how; the digest says whether it is the same data."""
    digest = hashlib.sha256()
    for walk, known in zip(walks, labels, strict=True):
        for array in (walk.acc_b_m_s2, walk.gyro_b_rad_s, known):
            digest.update(np.ascontiguousarray(array).tobytes())
    return json.dumps(
        {
            "training": asdict(training),
            "walks": [walk.name for walk in walks],
            "sha256": digest.hexdigest(),
            "torch": version,
            "numpy": np.__version__,
        }
    )
