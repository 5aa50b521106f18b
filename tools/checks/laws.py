# SPDX-License-Identifier: MIT
"""The laws by name, in the order in which they are told."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from tools.checks import compiled, form, holes, layers, readme, requirements, tree


@dataclass(frozen=True)
class Law:
    claim: str
    breaches: Callable[[Path], list[str]]


LAWS = (
    Law("C is formatted", form.c_format),
    Law("Python is formatted", form.python_format),
    Law("Python has no lint", form.python_lint),
    Law("C layers include only what they may", layers.breaches),
    Law("Python layers import only what they may", form.python_layers),
    Law("every module is in all rooms", holes.breaches),
    Law("generated files are those of the specification", form.generated_stale),
    Law("pins and lists agree", requirements.breaches),
    Law("nothing strange at the top", tree.strangers),
    Law("every source names its licence", tree.licence_lines),
    Law("lines and files are short", tree.lengths),
    Law("no machine's paths, no products, nothing undone", tree.given_away),
    Law("commands in pages exist", readme.breaches),
    Law("shared_c compiles without warnings on the host", compiled.host_warnings),
    Law("no heap, float or divide in the image", compiled.image_laws),
)
