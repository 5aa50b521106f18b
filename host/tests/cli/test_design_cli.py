# SPDX-License-Identifier: MIT
"""`terazi design`, as people and scripts meet it."""

import json
import xml.etree.ElementTree as ElementTree

import pytest
from typer.testing import CliRunner

from terazi.cli import app
from terazi.cshared import Fir

MAINS_AT_91_7 = "50 Hz, folded to 41.70 Hz"


def terazi(*words):
    return CliRunner().invoke(app, [str(word) for word in words])


def test_figures_are_told_for_every_method_asked_for():
    done = terazi("design", "fir", "hamming", "lowpass32", "--rate", 91.7)
    assert done.exit_code == 0
    for words in ("hamming", "lowpass32", MAINS_AT_91_7, "group delay", "169.0 ms", "-63.5 dB"):
        assert words in done.output


def test_exported_coefficients_are_ones_that_the_filter_takes(tmp_path):
    path = tmp_path / "taps.json"
    done = terazi(
        "design", "fir", "equiripple", "--taps", 51, "--rate", 82, "--notch", 50, "--export", path
    )
    assert done.exit_code == 0, done.output
    exported = json.loads(path.read_text())
    taps = exported["taps_q15"]
    assert exported["half_q15"] == taps[:26]
    assert exported["taps"] == Fir(taps).taps == 51
    assert exported["figures"]["notches_db"]["50.0"] < -60


def test_json_is_one_list_and_nothing_else():
    done = terazi("design", "fir", "hann", "blackman", "--json", "--at", 13.7)
    hann, blackman = json.loads(done.stdout)
    assert hann["wish"]["method"] == "hann"
    assert blackman["gain_db"]["13.7"] < hann["gain_db"]["13.7"] < -40


def test_responses_are_drawn(tmp_path):
    svg, page = tmp_path / "r.svg", tmp_path / "r.html"
    for path in (svg, page):
        words = ("--notch", 50, "--stop-db", -30, "-o", path)
        assert terazi("design", "fir", "hann", "hamming", *words).exit_code == 0
    texts = [each.text for each in ElementTree.parse(svg).iter() if each.tag.endswith("text")]
    assert "hann, 32 taps, dashed: its limit" in texts
    assert "50 Hz" in texts
    assert "Plotly.newPlot" in page.read_text()


@pytest.mark.parametrize(
    ("words", "code", "complaint"),
    [
        (("sinc",), 2, "no method 'sinc'; there are frequency-sampling"),
        (("hann", "--taps", 65), 2, "2 to 64 taps"),
        (("hann", "--rate", 50, "--notch", 50), 2, "where the weight itself is"),
        (("hann", "hamming", "--export", "t.json"), 2, "one design"),
        (("hann", "-o", "t.png"), 2, ".html or .svg"),
        (("hann", "-o", "no/such/folder/t.svg"), 8, "there is no folder"),
        (("hann", "--stop-db", -60), 12, "the stop band from 7.5 Hz has"),
    ],
)
def test_what_cannot_be_done_is_one_clear_line_and_an_exit_code(words, code, complaint):
    done = terazi("design", "fir", *words)
    assert done.exit_code == code
    assert complaint in done.output.replace("\n", " ")
    assert "Traceback" not in done.output


def test_a_missing_extra_is_named(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "scipy.signal", None)
    done = terazi("design", "fir", "equiripple")
    assert done.exit_code == 2
    assert "pip install 'terazi[design]'" in done.output


def test_lms_table_for_people_and_for_machines():
    shown = terazi("design", "lms")
    assert shown.exit_code == 0
    assert "lms, rectangular" in shown.output
    assert terazi("design", "lms", "--dwell", 0).exit_code == 2
    first, *_ = json.loads(terazi("design", "lms", "--json").stdout)
    assert first["experiment"]["seed"] == 2017
    assert set(first["filters"]) >= {"hamming", "blackman", "hann", "rectangular", "lms"}
