# SPDX-License-Identifier: MIT
"""What pages are made of: one HTML file with everything inlined. Its content policy forbids every
access to a network."""

import html
import os
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib import resources
from pathlib import Path

from terazi import __version__
from terazi.recorder.files import cannot_write

POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; base-uri 'none'; form-action 'none'"
)
PLOT_CONFIG = {
    "displaylogo": False,
    "responsive": True,
    "modeBarButtons": [["zoom2d", "pan2d", "resetScale2d", "toImage"]],
}


def write_page(path: Path, text: str) -> None:
    """Write a page, whole or not at all. Raises CannotWrite."""
    part = path.with_name(path.name + ".part")
    try:
        part.write_text(text, encoding="utf-8")
        os.replace(part, path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise cannot_write(path, error) from error


def page_of(title: str, body: Sequence[str]) -> str:
    """The page's text; empty parts are left out."""
    return _PAGE.format(
        policy=POLICY,
        title=html.escape(title),
        style=resources.files("terazi.report").joinpath("page.css").read_text("utf-8"),
        plotly=_plotly(),
        body="\n".join(part for part in body if part),
    )


_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{title}</title>
<style>
{style}</style>
<script>{plotly}</script>
</head>
<body>
<main>
{body}
</main>
</body>
</html>
"""


def _plotly() -> str:
    from plotly.offline import get_plotlyjs

    return get_plotlyjs()


def plot(figure) -> str:
    """A plotly figure."""
    return figure.to_html(
        full_html=False, include_plotlyjs=False, include_mathjax=False, config=PLOT_CONFIG
    )


def section(title: str, *content: str) -> str:
    return "\n".join([f"<section><h2>{title}</h2>", *content, "</section>"])


def note(text: str) -> str:
    return f'<p class="note">{text}</p>'


def table(head: list[str], rows: list[list[str]]) -> str:
    """Cells are HTML already."""
    lines = ["<table><thead><tr>", *(f"<th>{cell}</th>" for cell in head), "</tr></thead><tbody>"]
    for row in rows:
        lines.append("<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>")
    return "".join([*lines, "</tbody></table>"])


def footer() -> str:
    now = datetime.now(UTC)
    return f"<footer>terazi {html.escape(__version__)} · made {now:%Y-%m-%d %H:%M} UTC</footer>"
