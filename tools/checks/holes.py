# SPDX-License-Identifier: MIT
"""One name through all rooms: a module of shared_c without one of its links is a visible hole."""

from dataclasses import dataclass
from pathlib import Path

BUDGET = Path("firmware/budget.toml")


@dataclass(frozen=True)
class Link:
    name: str
    pattern: str  # a path with {module} in it, as a glob

    def holds(self, root: Path, module: str) -> bool:
        return any(root.glob(self.pattern.format(module=module)))


LINKS = (
    Link("source", "shared_c/src/{module}.c"),
    Link("specification", "shared_c/spec/{module}.toml"),
    Link("model", "host/src/terazi/models/{module}.py"),
    Link("vectors", "shared_c/vectors/{module}*.csv"),
    Link("test", "host/tests/shared_c/test_{module}*.py"),
    Link("derivation", "shared_c/notes/{module}.md"),
)

# What a module has no need of, and why.
EXEMPT = {
    ("checkweigher", "specification"): "its limits and times are one machine's own",
    ("frame", "specification"): "its layout is the head of messages.toml",
    ("frame", "model"): "no numbers to model: the oracle is fastcrc and a decoder in the tests",
    ("frame", "derivation"): "no error to bound",
    ("imu_cal", "specification"): "its constants are one board's own",
    ("mass", "specification"): "its span arrives as an argument",
}


def budget_line_exists(root: Path, module: str) -> bool:
    budget = root / BUDGET
    return budget.exists() and module in budget.read_text(encoding="utf-8")


def breaches(root: Path) -> list[str]:
    modules = sorted(path.stem for path in (root / "shared_c/include").glob("*.h"))
    found = []
    for module in modules:
        for link in LINKS:
            if (module, link.name) not in EXEMPT and not link.holds(root, module):
                found.append(f"{module}: no {link.name}: {link.pattern.format(module=module)}")
        if not budget_line_exists(root, module):
            found.append(f"{module}: no line in {BUDGET}")
    for folder, ending in (("src", "*.c"), ("vectors", "*.csv")):
        for path in sorted((root / "shared_c" / folder).glob(ending)):
            if not any(path.stem == name or path.stem.startswith(f"{name}_") for name in modules):
                found.append(f"{path.relative_to(root)}: belongs to no module of shared_c/include")
    unused = [pair for pair in EXEMPT if pair[0] not in modules]
    found += [f"{module}: exempt of {link}, but there is no such module" for module, link in unused]
    return found
