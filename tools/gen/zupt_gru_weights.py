# SPDX-License-Identifier: MIT
"""Renders the weights of zupt_gru.toml from the network that `terazi walk` has."""

from __future__ import annotations

import hashlib
import json
import textwrap
from collections.abc import Mapping
from functools import cache
from importlib import metadata

from terazi.applications.walks import networks, simulator
from terazi.design import zupt_gru as design
from tools.gen.spec import Spec, c_comment_head, load


def floats() -> design.Floats:
    """The shipped network."""
    network = networks.load_network(networks.SHIPPED)
    if (network.kind, network.inputs, network.rate_hz) != ("gru", "magnitudes", 200.0):
        raise ValueError("zupt_gru.h is for a gru of magnitudes at 200 Hz")
    ((w_ih, w_hh, b_ih, b_hh),) = (
        [each.astype(float) for each in layer] for layer in network.layers
    )
    return design.Floats(
        w_ih,
        w_hh,
        b_ih,
        b_hh,
        network.w_out[0].astype(float),
        float(network.b_out[0]),
        network.accept,
        networks.GRAVITY_M_S2,
        networks.ACC_FLOOR_M_S2,
        networks.RATE_FLOOR_RAD_S,
    )


def walk_inputs(pieces: Mapping) -> networks.np.ndarray:
    """(n, 2) of the walk that the rows are rounded for."""
    walk = simulator.simulate(
        [
            *simulator.stand(pieces["stand_s"]),
            *simulator.strides(pieces["strides"]),
            *simulator.staircase(pieces["stairs"]),
            *simulator.strides(pieces["running"], simulator.RUNNING),
        ],
        seed=pieces["seed"],
    )
    return networks.features(walk, "magnitudes", 200.0).astype(float)


@cache
def weights() -> design.Weights:
    """By the spec, of the shipped network."""
    content = load("zupt_gru").content
    return design.quantise(floats(), walk_inputs(content["walk"]), content)


def _provenance() -> list[str]:
    """Comment: of which network, how that was trained, and made by which versions."""
    network = networks.load_network(networks.SHIPPED)
    told = json.loads(network.provenance)
    digest = hashlib.sha256(networks.SHIPPED.read_bytes()).hexdigest()
    made = f"by numpy {metadata.version('numpy')}"
    lines = [f"/* Of {networks.SHIPPED.name}, sha256 {digest[:16]}, {made}."]
    settings = ", ".join(f"{key} {value}" for key, value in told["training"].items())
    text = (
        f"Trained by torch {told['torch']}, numpy {told['numpy']}: {settings}. "
        f"Data: sha256 {told['sha256']}, walks {', '.join(told['walks'])}. */"
    )
    return lines + textwrap.wrap(text, 97, initial_indent=" * ", subsequent_indent=" * ",
                                 break_on_hyphens=False)  # fmt: skip


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
        f"    ZUPT_GRU_RATE_FLOOR = {found.rate_floor},",
        f"    ZUPT_GRU_OUT_BIAS = {found.out_bias} /* what is asked for is taken off */",
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
