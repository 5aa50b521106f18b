# SPDX-License-Identifier: MIT
"""The list of generated files, and the program that writes or checks them."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from tools.gen import (
    faults_limits,
    filters,
    fir_asm,
    fir_response,
    mahony_configs,
    messages_c,
    messages_py,
    messages_spec,
    protocol_md,
    rest_configs,
    scale_units,
    settings_c,
    settings_md,
    settings_py,
    settings_spec,
    temperature_limits,
    zupt_configs,
    zupt_gru_weights,
)
from tools.gen.spec import ROOT, load

GENERATED_C = "shared_c/generated"


def outputs() -> dict[str, str]:
    """Path below the root -> text, for everything that comes from shared_c/spec."""
    messages, fir, weight_kf = load("messages"), load("fir"), load("weight_kf")
    adaptive = load("weight_kf_adaptive")
    rest, mahony, scale = load("rest"), load("mahony"), load("scale")
    zupt, zupt_gru = load("zupt"), load("zupt_gru")
    wire = messages_spec.parse(messages)
    settings_file = load("settings")
    settings = settings_spec.parse(settings_file, wire)
    return {
        f"{GENERATED_C}/messages.h": messages_c.header(messages, wire),
        f"{GENERATED_C}/messages.c": messages_c.source(messages, wire),
        "host/src/terazi/link/generated/messages.py": messages_py.module(messages, wire),
        "shared_c/PROTOCOL.md": protocol_md.page(messages, wire)
        + settings_md.section(settings_file, settings),
        f"{GENERATED_C}/fir_designs.h": filters.fir_header(fir),
        f"{GENERATED_C}/fir_designs.c": filters.fir_source(fir),
        f"{GENERATED_C}/fir_response.svg": fir_response.page(fir),
        "firmware/port/generated/port_fir_default.S": fir_asm.source(fir),
        f"{GENERATED_C}/weight_kf_gains.h": filters.kf_header(weight_kf),
        f"{GENERATED_C}/weight_kf_gains.c": filters.kf_source(weight_kf),
        f"{GENERATED_C}/rest_configs.h": rest_configs.header(rest),
        f"{GENERATED_C}/rest_configs.c": rest_configs.source(rest),
        f"{GENERATED_C}/weight_kf_adaptive_variants.h": filters.kf_adaptive_header(adaptive),
        f"{GENERATED_C}/weight_kf_adaptive_variants.c": filters.kf_adaptive_source(adaptive),
        f"{GENERATED_C}/mahony_configs.h": mahony_configs.header(mahony),
        f"{GENERATED_C}/mahony_configs.c": mahony_configs.source(mahony),
        f"{GENERATED_C}/zupt_configs.h": zupt_configs.header(zupt),
        f"{GENERATED_C}/zupt_configs.c": zupt_configs.source(zupt),
        f"{GENERATED_C}/zupt_gru_weights.h": zupt_gru_weights.header(zupt_gru),
        f"{GENERATED_C}/zupt_gru_weights.c": zupt_gru_weights.source(zupt_gru),
        f"{GENERATED_C}/faults_limits.h": faults_limits.header(load("faults")),
        f"{GENERATED_C}/scale_units.h": scale_units.header(scale),
        f"{GENERATED_C}/scale_units.c": scale_units.source(scale),
        f"{GENERATED_C}/settings_table.h": settings_c.header(settings_file, settings),
        f"{GENERATED_C}/settings_table.c": settings_c.source(settings_file, settings),
        "host/src/terazi/link/generated/settings.py": settings_py.module(settings_file, settings),
        f"{GENERATED_C}/temperature_limits.h": temperature_limits.header(load("temperature")),
    }


def stale(root: Path = ROOT) -> list[str]:
    """Paths whose content is not what the specs give now."""
    return [
        path
        for path, text in outputs().items()
        if not (root / path).is_file() or (root / path).read_text(encoding="utf-8") != text
    ]


def main(arguments: list[str] | None = None) -> int:
    """Write what is stale, or with --check only name it (exit code 1)."""
    parser = argparse.ArgumentParser(prog="gen", description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; 1 if stale")
    parser.add_argument(
        "--vectors",
        action="store_true",
        help="also write shared_c/vectors (moves the truth: say why)",
    )
    options = parser.parse_args(arguments)
    late = stale()
    for path in late:
        if options.check:
            print(f"stale: {path}: run ./dev gen", file=sys.stderr)
        else:
            (ROOT / path).parent.mkdir(parents=True, exist_ok=True)
            (ROOT / path).write_text(outputs()[path], encoding="utf-8")
            print(f"wrote {path}")
    if options.vectors and not options.check:
        from tools.gen import golden  # needs the design library of the host only here

        for path in golden.write_all():
            print(f"wrote {path.relative_to(ROOT)}")
    return 1 if options.check and late else 0
