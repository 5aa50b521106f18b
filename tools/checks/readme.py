# SPDX-License-Identifier: MIT
"""Every command in a page exists: its own ``--help`` knows the verb and each option shown."""

import re
import shlex
import subprocess
from functools import cache
from pathlib import Path

from tools.checks.files import text_of, with_suffix

SNIPPET = re.compile(r"^```sh\n(.*?)^```", re.MULTILINE | re.DOTALL)
OURS = ("./dev", "terazi")
# Tools that a page may name without our being able to ask them.
OTHERS = {
    "git",
    "cd",
    "pip",
    "uv",
    "for",
    "do",
    "done",
    "sudo",
    "python",
    "pio",
    "screen",
    "pytest",
}
ESCAPES = re.compile(r"\x1b\[[0-9;]*m")


@cache
def help_text(root: Path, command: tuple[str, ...]) -> str | None:
    """What ``command --help`` prints; None if there is no such command."""
    done = subprocess.run([*command, "--help"], cwd=root, capture_output=True, text=True)
    return ESCAPES.sub("", done.stdout) if done.returncode == 0 else None


def commands_in(page: str) -> list[list[str]]:
    """The commands of a page's sh blocks, as words, continued lines joined."""
    lines = "".join(SNIPPET.findall(page)).replace("\\\n", " ").splitlines()
    told = [re.sub(r"(^|\s)#.*", "", line) for line in lines]
    parts = [part for line in told for part in re.split(r"&&|\|\||;|\|", line)]
    return [words for part in parts if (words := shlex.split(part))]


def complaint(root: Path, words: list[str]) -> str | None:
    shown = shlex.join(words)
    if words[:2] == ["./dev", "run"] and len(words) > 2:
        words = words[2:]
    if words[0] not in OURS:
        return None if words[0] in OTHERS else f"not a command of this project: {shown}"
    verb = tuple(words[:2])
    if len(verb) < 2 or verb[1].startswith("-"):
        verb = verb[:1]
    text = help_text(root, verb)
    if text is None:
        return f"no such command: {shown}"
    options = [word.split("=")[0] for word in words if word.startswith("--")]
    unknown = [option for option in options if option != "--help" and option not in text]
    return f"{' '.join(unknown)} is not in the help of: {shown}" if unknown else None


def breaches(root: Path) -> list[str]:
    found = []
    for path in with_suffix(root, ".md"):
        for words in commands_in(text_of(root, path) or ""):
            if problem := complaint(root, words):
                found.append(f"{path}: {problem}")
    return found
