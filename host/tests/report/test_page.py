# SPDX-License-Identifier: MIT
"""The page: complete, self-contained, and honest about what it could not find."""

import html.parser
import re

import numpy as np
import pytest

from host.tests.captures import CaptureMaker
from host.tests.fake_chain import RATE_HZ
from terazi.errors import CannotWrite
from terazi.recorder import load_recording
from terazi.report import Truth, analyse, write_report
from terazi.report.figures import POINTS_SHOWN, thinned
from terazi.report.page import render


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "a <b> & c.terazi"
    return load_recording(CaptureMaker(path).hello().samples(round(9 * RATE_HZ)).end())


@pytest.fixture(scope="module")
def page(recording):
    truth = Truth(np.array([0.0, 2, 6, 9]), np.array([0.0, 500, 0, 0]))
    return render(recording, analyse(recording, truth))


class Reader(html.parser.HTMLParser):
    """Collects what a browser would load, and the text that a person would read."""

    def __init__(self):
        super().__init__()
        self.loads, self.policy, self.text, self._inside = [], "", "", ""

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self._inside = tag
        self.loads += [attributes[name] for name in ("src", "href", "action") if name in attributes]
        if attributes.get("http-equiv") == "Content-Security-Policy":
            self.policy = attributes["content"]

    def handle_endtag(self, _tag):
        self._inside = ""

    def handle_data(self, data):
        if self._inside not in ("script", "style"):
            self.text += data


@pytest.fixture(scope="module")
def read(page):
    reader = Reader()
    reader.feed(page)
    return reader


def test_page_loads_nothing_and_forbids_to(read):
    assert read.loads == []
    assert "default-src 'none'" in read.policy
    assert "http" not in read.policy
    assert "connect-src" not in read.policy


def test_page_carries_the_plotting_library_once_and_every_plot(page):
    assert len(re.findall(r"plotly\.js v\d", page)) == 1
    assert page.count("Plotly.newPlot(") == 4
    assert len(page) < 8_000_000


def test_page_says_what_a_reader_wants_to_know(read):
    for words in (
        "a <b> & c.terazi",
        "firmware 0.1.0 (build 1234abcd)",
        "82.000 SPS",
        "0.0 g → 499.9 g",
        "Kalman settles in",
        "error to the truth",
        "frames lost",
        "stack free bytes",
        "median interval",
        "mains hum of 50 Hz appears at 32.0 Hz",
    ):
        assert words in read.text


def test_page_escapes_the_files_name(page):
    assert "<b>" not in re.sub(r'<div class="card.*?</div>', "", page.split("</script>")[1][:400])
    assert "a &lt;b&gt; &amp; c.terazi" in page


def test_page_of_a_short_and_cut_recording_says_so(tmp_path):
    path = CaptureMaker(tmp_path / "short.terazi").hello().samples(5).end()
    path.write_bytes(path.read_bytes()[:-20])
    recording = load_recording(path)
    text = render(recording, analyse(recording))
    assert "This recording was cut off" in text
    assert "None was found in this recording" in text
    assert "holds no STATUS" in text


def test_page_is_written_whole_or_not_at_all(tmp_path, recording):
    page = tmp_path / "report.html"
    page.write_text("older")
    write_report(page, recording, analyse(recording))
    assert page.stat().st_size > 1_000_000
    with pytest.raises(CannotWrite, match="there is no folder"):
        write_report(tmp_path / "no" / "report.html", recording, analyse(recording))
    assert [path.name for path in tmp_path.iterdir()] == ["report.html"]


def test_thinning_keeps_every_extreme():
    values = np.zeros(100_000)
    values[[77, 50_001]] = [9.0, -7.0]
    t_s, shown = thinned(np.arange(100_000) / RATE_HZ, values)
    assert len(shown) <= POINTS_SHOWN
    assert (shown.max(), shown.min()) == (9.0, -7.0)
    assert (np.diff(t_s) > 0).all()
