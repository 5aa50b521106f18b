# SPDX-License-Identifier: MIT
"""Renders the weights of zupt_gru.toml from the network that `terazi walk` has."""

from __future__ import annotations

import hashlib
import json
import textwrap
from functools import cache

import numpy as np

from terazi.design import zupt_gru as design
from tools.gen.spec import ROOT, Spec, c_comment_head, load

# Read here and not by `terazi walk`, which stands on the C that is made here.
NETWORK = ROOT / "host/src/terazi/applications/walks/gru8.npz"


@cache
def _fields() -> dict[str, np.ndarray]:
    with np.load(NETWORK, allow_pickle=False) as archive:
        return dict(archive)


@cache
def floats() -> design.Floats:
    """The shipped network."""
    return design.floats(_fields(), load("zupt_gru").content)


def gate() -> design.Gate:
    """What is asked of its output, in logits."""
    return design.gate_of(floats(), load("zupt_gru").content["gate"])


@cache
def weights() -> design.Weights:
    """By the spec, of the shipped network."""
    return design.quantise(floats(), load("zupt_gru").content)


def _provenance() -> list[str]:
    """Comment: of which network, and how that was trained."""
    told = json.loads(_fields()["provenance"].item())
    digest = hashlib.sha256(NETWORK.read_bytes()).hexdigest()
    settings = ", ".join(f"{key} {value}" for key, value in told["training"].items())
    text = (
        f"Trained by torch {told['torch']}, numpy {told['numpy']}: {settings}. "
        f"Data: sha256 {told['sha256']}, walks {', '.join(told['walks'])}. */"
    )
    return [
        f"/* Of {NETWORK.name}, sha256 {digest}.",
        *textwrap.wrap(
            text, 97, initial_indent=" * ", subsequent_indent=" * ", break_on_hyphens=False
        ),
    ]


def header(spec: Spec) -> str:
    """Text of zupt_gru_weights.h."""
    found = weights()
    lines = [
        "/* zupt_gru_weights - the network of shared_c/spec/zupt_gru.toml. */",
        "#ifndef ZUPT_GRU_WEIGHTS_H",
        "#define ZUPT_GRU_WEIGHTS_H",
        "",
        '#include "port_gru.h"',
        "",
        "enum {",
        f"    ZUPT_GRU_GRAVITY_HALVES = {found.gravity_halves}, /* half counts */",
        f"    ZUPT_GRU_ACC_FLOOR = {found.acc_floor}, /* log2 in Q8 of half counts */",
        f"    ZUPT_GRU_RATE_FLOOR = {found.rate_floor}, /* log2 in Q8 of counts^2 */",
        f"    ZUPT_GRU_OUT_BIAS = {found.out_bias}, /* accept's is taken off */",
        f"    ZUPT_GRU_MARGIN = {found.gate.margin}, /* sums */",
        f"    ZUPT_GRU_LEAST = {found.gate.least}",
        "};",
        "",
        "/* ROM, all of them. */",
        f"extern const port_gru_unit_t zupt_gru_units[{design.UNITS}];",
        f"extern const int8_t zupt_gru_out[{design.UNITS}];",
        "",
        "#endif",
        "",
    ]
    return c_comment_head(spec) + "\n".join(lines)


def _braces(values) -> str:
    return "{" + ", ".join(map(str, values)) + "}"


def source(spec: Spec) -> str:
    """Text of zupt_gru_weights.c."""
    found = weights()
    lines = [*_provenance(), '#include "zupt_gru_weights.h"', "", '#include "port_rom.h"', ""]
    lines.append(f"const port_gru_unit_t zupt_gru_units[{design.UNITS}] PORT_ROM = {{")
    for unit in found.units:
        lines += [
            "    {",
            f"        .bias = {_braces(unit.bias)},",
            f"        .inputs = {_braces(map(_braces, unit.inputs))},",
            f"        .bias_u = {unit.bias_u},",
            "        .states = {",
            *(f"            {_braces(row)}," for row in unit.states),
            "        },",
            "    },",
        ]
    lines += ["};", ""]
    out = _braces(found.out)
    lines += [f"const int8_t zupt_gru_out[{design.UNITS}] PORT_ROM = {out};", ""]
    lines.append("const uint16_t port_gru_sigmoid_q16[PORT_GRU_PIECES + 1] PORT_ROM = {")
    points = ", ".join(f"{point}U" for point in found.sigmoid_q16) + ","
    lines += textwrap.wrap(points, 96, initial_indent="    ", subsequent_indent="    ")
    return c_comment_head(spec) + "\n".join([*lines, "};", ""])
