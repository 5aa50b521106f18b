# SPDX-License-Identifier: MIT
"""zupt_gru.h's integers from the network in floats, by shared_c/spec/zupt_gru.toml.

A row of weights, one gate of one unit, is rounded as a whole: what counts is not how far each
weight is from its own, but how far the row's sum is from its own over what the network sees. With
C the covariance of that and d the row's error, the mean square of the sum's error about its mean is
d' C d. From the nearest integers on, up to three weights at a time go up or down by one while that
falls; the mean goes into the bias, which is finer, and so does the half that each product loses in
the mean by being rounded down.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from terazi.design.zupt import STANDARD_GRAVITY_M_S2

UNITS, INPUTS = 8, 2
SEEN = INPUTS + UNITS
BLOCK_STEPS, BLOCKS = 64, 3
STATE_Q13 = 1 << 13
OCTAVES_Q10 = 10 << 10
TENS = OCTAVES_Q10 / STATE_Q13  # ten octaves, where a state's one is one
SUM_SHIFT = 8
SUM_MAX = (1 << 15) - 1
WEIGHT_MAX = 127
SIGMOID_STEP, SIGMOID_PIECES = 512, 32  # in sums, which a gate halves; PORT_GRU_PIECES
HALVES = 2  # a magnitude's unit is half a count


@dataclass(frozen=True)
class Unit:
    """port_gru_unit_t; gates in the order r, z, n."""

    bias: tuple[int, ...]  # (3,)
    inputs: tuple[tuple[int, ...], ...]  # (2, 3)
    bias_u: int
    states: tuple[tuple[int, ...], ...]  # (8, 3)


@dataclass(frozen=True)
class Gate:
    """What is asked of a score; in sums for the chip, in logits for the network."""

    margin: float  # below the best of the newest blocks
    least: float  # but at least this, below accept's


@dataclass(frozen=True)
class Weights:
    """All that zupt_gru.c has in program memory or as constants."""

    units: tuple[Unit, ...]
    out: tuple[int, ...]
    out_bias: int  # in sums, accept's logit taken off
    gate: Gate
    sigmoid_q16: tuple[int, ...]
    gravity_halves: int
    acc_floor: int  # log2 in Q8 of the floor in half counts
    rate_floor: int  # of the floor's square, in counts


@dataclass(frozen=True)
class Floats:
    """The network: PyTorch's arrays of one GRU layer and an output, and what its inputs mean."""

    w_ih: np.ndarray  # (24, 2), inputs of 0..1 for ten octaves
    w_hh: np.ndarray  # (24, 8)
    b_ih: np.ndarray  # (24,)
    b_hh: np.ndarray  # (24,)
    w_out: np.ndarray  # (8,)
    b_out: float
    accept: float  # probability
    gravity_m_s2: float
    acc_floor_m_s2: float
    rate_floor_rad_s: float


def sigmoid(values):
    """1 / (1 + exp(-values))"""
    return 1 / (1 + np.exp(-np.asarray(values, dtype=float)))


def logit(share: float) -> float:
    """The sigmoid's inverse."""
    return float(np.log(share / (1 - share)))


def gate_of(network: Floats, spec: Mapping) -> Gate:
    """In logits, from the table [gate] of zupt_gru.toml."""
    least = logit(spec["least_accept"]) - logit(network.accept)
    return Gate(spec["margin_logits"], least)


def asked(scores: np.ndarray, by: Gate) -> np.ndarray:
    """(n,) the least score that is still at each step, where scores are (n,) logits above accept's:
    `margin` below the best of the newest blocks, but not above 0 nor below `least`."""
    best, found = [0.0] * BLOCKS, np.empty(len(scores))
    for step, score in enumerate(scores):
        if step and step % BLOCK_STEPS == 0:
            best = [score, *best[:-1]]
        best[0] = max(best[0], score)
        found[step] = min(max(max(best) - by.margin, by.least), 0.0)
    return found


def states(network: Floats, inputs: np.ndarray) -> np.ndarray:
    """(n, 8) float64: the state after each row of the (n, 2) inputs. Cho et al. 2014, PyTorch's
    order of gates r, z, n."""
    state, found = np.zeros(UNITS), np.empty((len(inputs), UNITS))
    for at, row in enumerate(inputs):
        given = network.w_ih @ row + network.b_ih
        back = network.w_hh @ state + network.b_hh
        reset = sigmoid(given[:UNITS] + back[:UNITS])
        update = sigmoid(given[UNITS : 2 * UNITS] + back[UNITS : 2 * UNITS])
        fresh = np.tanh(given[2 * UNITS :] + reset * back[2 * UNITS :])
        state = fresh + update * (state - fresh)
        found[at] = state
    return found


def moments(network: Floats, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(10,) mean and (10, 10) covariance of what the rows are multiplied with, where these (n, 2)
    inputs come: two inputs in a state's unit, then the states before each step."""
    before = np.vstack([np.zeros((1, UNITS)), states(network, inputs)[:-1]])
    seen = np.hstack([inputs * TENS, before])
    return seen.mean(axis=0), np.cov(seen.T)


def scores(network: Floats, inputs: np.ndarray) -> np.ndarray:
    """(n,) float64 logit of stillness, less that of `accept`, after each row of the inputs."""
    return states(network, inputs) @ network.w_out + network.b_out - logit(network.accept)


def rounded_row(row, scale: float, mean, covariance) -> tuple[np.ndarray, float]:
    """Integers for scale * row, and what to add to the bias, in the row's own unit.

    mean, covariance : (m,), (m, m) of what the row is multiplied with.
    """
    wanted = np.asarray(row, dtype=float) * scale
    width = len(wanted)
    # Where columns hardly differ, any split between them would do: the nearest is preferred.
    spread = np.asarray(covariance) + 1e-6 * np.eye(width)
    moves = np.array(
        [
            np.bincount(at, signs, width)
            for count in (1, 2, 3)
            for at in itertools.combinations(range(width), count)
            for signs in itertools.product((1, -1), repeat=count)
        ]
    )

    def cost(rows):
        error = rows - wanted
        return np.where(
            np.abs(rows).max(axis=1) <= WEIGHT_MAX,
            np.einsum("ni,ij,nj->n", error, spread, error),
            np.inf,
        )

    best = np.clip(np.rint(wanted), -WEIGHT_MAX, WEIGHT_MAX)
    least = cost(best[None])[0]
    while True:
        costs = cost(best + moves)
        at = int(costs.argmin())
        if not costs[at] < least - 1e-9:
            return best.astype(int), float((wanted - best) @ np.asarray(mean)) / scale
        best, least = best + moves[at], costs[at]


def sigmoid_table(step: float, pieces: int) -> tuple[int, ...]:
    """Points of the sigmoid's right half in Q16, `step` apart, straight lines between which are
    nearest to it in the mean square: chords alone would lie below it everywhere."""
    fine = np.linspace(0, pieces, 64 * pieces + 1)
    hats = np.maximum(0, 1 - np.abs(fine[:, None] - np.arange(pieces + 1)))
    # Through 1/2, so that both halves meet.
    wanted = sigmoid(fine * step) - 0.5 * hats[:, 0]
    points = [0.5, *np.linalg.lstsq(hats[:, 1:], wanted, rcond=None)[0]]
    return tuple(int(point) for point in np.minimum(np.rint(np.array(points) * 65536), 65535))


def floats(fields: Mapping, spec: Mapping) -> Floats:
    """The network from the arrays of an .npz as terazi.applications.walks.networks writes it."""
    told = tuple(fields[name].item() for name in ("kind", "inputs", "layers", "rate_hz"))
    if told != ("gru", "magnitudes", 1, 200.0):
        raise ValueError(
            f"zupt_gru.h is for one layer of a gru of magnitudes at 200 Hz, not {told}"
        )
    layer = (fields[f"{name}_0"].astype(float) for name in ("w_ih", "w_hh", "b_ih", "b_hh"))
    w_out, b_out = (fields[name].astype(float) for name in ("w_out", "b_out"))
    return Floats(*layer, w_out[0], float(b_out[0]), fields["accept"].item(), **spec["inputs"])


def quantise(network: Floats, spec: Mapping) -> Weights:
    """Everything; `spec` is zupt_gru.toml.

    Raises ValueError where a sum might leave what port_gru.h allows.
    """
    scale = spec["format"]["weights_per_unit"]
    units_per_sum = scale * STATE_Q13 / (1 << SUM_SHIFT)  # sums of one
    mean, lower = np.array(spec["seen"]["mean"]), spec["seen"]["covariance"]
    spread = np.zeros((INPUTS + UNITS, INPUTS + UNITS))
    for n, row in enumerate(lower):
        spread[n, : n + 1] = spread[: n + 1, n] = row

    def rounded(row, of: slice):
        return rounded_row(row, scale, mean[of], spread[of, of])

    of_all, of_inputs, of_states = slice(None), slice(INPUTS), slice(INPUTS, None)
    rows = np.hstack([network.w_ih / TENS, network.w_hh])
    units = []
    for n in range(UNITS):
        parts = []
        for gate in range(2):
            at = gate * UNITS + n
            weights, more = rounded(rows[at], of_all)
            parts.append((weights, network.b_ih[at] + network.b_hh[at] + more))
        at = 2 * UNITS + n
        given, more = rounded(rows[at, of_inputs], of_inputs)
        back, more_u = rounded(rows[at, of_states], of_states)
        parts.append((np.concatenate([given, back]), network.b_ih[at] + more))
        columns = np.array([weights for weights, _ in parts]).T
        units.append(
            Unit(
                tuple(
                    round(float(bias) * units_per_sum + count / 2)
                    for (_, bias), count in zip(parts, (SEEN, SEEN, INPUTS), strict=True)
                ),
                tuple(tuple(row) for row in columns[:INPUTS].tolist()),
                round(float(network.b_hh[at] + more_u) * units_per_sum + UNITS / 2),
                tuple(tuple(row) for row in columns[INPUTS:].tolist()),
            )
        )
    out, more = rounded(network.w_out, of_states)
    out_bias = round(
        float(network.b_out + more - logit(network.accept)) * units_per_sum + UNITS / 2
    )
    asked = gate_of(network, spec["gate"])
    table = sigmoid_table(SIGMOID_STEP / units_per_sum, SIGMOID_PIECES)
    check(units)
    if largest_sum(out_bias, (), out) > SUM_MAX:
        raise ValueError("the output's sum leaves 16 bits")
    acc_halves = HALVES * spec["sensor"]["acc_counts_per_g"] / STANDARD_GRAVITY_M_S2
    gyro_counts = np.degrees(spec["sensor"]["gyro_counts_per_deg_s"])
    return Weights(
        tuple(units),
        tuple(out.tolist()),
        out_bias,
        replace(
            asked,
            margin=round(asked.margin * units_per_sum),
            least=round(asked.least * units_per_sum),
        ),
        table,
        round(network.gravity_m_s2 * acc_halves),
        round(float(np.log2(network.acc_floor_m_s2 * acc_halves)) * 256),
        round(2 * float(np.log2(network.rate_floor_rad_s * gyro_counts)) * 256),
    )


def largest_sum(bias: int, inputs: Sequence[int], states: Sequence[int]) -> int:
    """Bound of |sum| over all that may be seen, the bounds of which are multiples of 256."""
    products = OCTAVES_Q10 * sum(map(abs, inputs)) + STATE_Q13 * sum(map(abs, states))
    return abs(bias) + products // (1 << SUM_SHIFT)


def check(units: Sequence[Unit]) -> None:
    """port_gru.h's demand on the weights."""
    for n, unit in enumerate(units):
        inputs, states = (tuple(zip(*rows, strict=True)) for rows in (unit.inputs, unit.states))
        sums = [largest_sum(unit.bias[gate], inputs[gate], states[gate]) for gate in range(2)]
        sums.append(largest_sum(unit.bias[2], inputs[2], ()))
        sums[2] += largest_sum(unit.bias_u, (), states[2])
        if max(sums) > SUM_MAX:
            raise ValueError(f"unit {n}: a sum of {max(sums)} leaves 16 bits")
