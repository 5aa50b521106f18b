# SPDX-License-Identifier: MIT
"""terazi weigh FILE: what a capture tells of the scale, in e, beside class III."""

import json
import random

import numpy as np
import pytest
from typer.testing import CliRunner

from host.tests.captures import CaptureMaker
from host.tests.fake_chain import RATE_HZ
from terazi.applications.weighing import page
from terazi.applications.weighing.points import weigh_up
from terazi.cli import app
from terazi.design import scale as design
from terazi.link.generated.messages import Setting
from terazi.link.generated.settings import SettingKey
from terazi.recorder import load_recording
from terazi.report.analysis import analyse

LOADS_G = [0, 500, 1000, 2000, 5000, 2000, 1000, 500, 0]
DWELL_S = 4.0
COUNTS_PER_G = design.default_points()[1][0] / design.default_points()[1][1]
NOISE_COUNTS, BOW = 38.7, 2e-4


def bowed_error_e(load_g: float) -> float:
    share = load_g / 5000
    return 5000 * 4 * BOW * share * (1 - share)


def weights(t_s: float) -> int:
    """LOADS_G in turn on a cell that bows, and that creeps up by 0.1 g once it was loaded."""
    at = min(int(t_s / DWELL_S), len(LOADS_G) - 1)
    load_g = LOADS_G[at] + bowed_error_e(LOADS_G[at]) + (0.1 if at > 4 and at < 8 else 0.0)
    noise = random.Random(round(t_s * 1e6)).gauss(0.0, NOISE_COUNTS)
    return round(load_g * COUNTS_PER_G + noise)


@pytest.fixture(scope="module")
def capture(tmp_path_factory):
    path = tmp_path_factory.mktemp("weigh") / "weights.terazi"
    return CaptureMaker(path, weights).hello().samples(round(36 * RATE_HZ)).end()


@pytest.fixture(scope="module")
def weighing(capture):
    recording = load_recording(capture)
    return weigh_up(recording, analyse(recording), [0, 500, 1000, 2000, 5000])


def run(*arguments):
    return CliRunner().invoke(app, ["weigh", *map(str, arguments)])


def test_each_load_is_one_placement_read_where_it_was_stable(weighing):
    assert [one.load_g for one in weighing.points] == [0, 500, 1000, 2000, 5000]
    assert [one.placements for one in weighing.points] == [2, 2, 2, 2, 1]
    assert [one.direction for one in weighing.placements] == ["first"] + ["up"] * 4 + ["down"] * 4
    assert all(one.is_stable for one in weighing.placements)
    assert all(one.stable_after_s <= 1.0 for one in weighing.placements[1:])


def test_errors_are_those_of_the_bow_and_lie_within_class_iii(weighing):
    for point in weighing.points:
        creep_e = 0.05 if point.hysteresis_e is not None else 0.0  # the mean of up and down
        truth_e = bowed_error_e(point.load_g) + creep_e
        assert point.mean_error_e == pytest.approx(truth_e, abs=0.04)
        assert point.within_in_service
    assert weighing.points[1].limit_e == 0.5
    assert weighing.points[2].limit_e == 1.0
    assert weighing.points[4].limit_e == 1.5


def test_hysteresis_repeatability_and_noise_are_what_was_put_in(weighing):
    for point in weighing.points[1:4]:
        assert point.hysteresis_e == pytest.approx(0.1, abs=0.04)
        assert point.repeatability_e == pytest.approx(0.1, abs=0.04)
    assert weighing.points[4].hysteresis_e is None
    assert weighing.floor_e == pytest.approx(NOISE_COUNTS / COUNTS_PER_G, rel=0.01)
    for point, group in zip(weighing.points, (2, 2, 2, 2, 1), strict=True):
        mean_samples = point.samples / group
        assert point.bound_e == pytest.approx(weighing.floor_e / np.sqrt(mean_samples), rel=0.2)
        assert point.sigma_e < weighing.floor_e / 4  # filtered


def test_e_comes_from_the_capture_or_the_command(tmp_path):
    maker = CaptureMaker(tmp_path / "e.terazi", weights).hello()
    maker.say(Setting(SettingKey.SCALE_INTERVAL_MG, 2000))
    recording = load_recording(maker.samples(round(9 * RATE_HZ)).end())
    assert weigh_up(recording, analyse(recording)).e_g == 2.0
    assert weigh_up(recording, analyse(recording), e_g=0.5).e_g == 0.5


def test_without_loads_equal_readings_are_put_together_and_no_error_is_told(capture):
    recording = load_recording(capture)
    found = weigh_up(recording, analyse(recording))
    assert [point.placements for point in found.points] == [2, 2, 2, 2, 1]
    assert all(point.mean_error_e is None for point in found.points)
    assert found.within is None


def test_an_error_beyond_the_limits_is_called_so(capture):
    recording = load_recording(capture)
    found = weigh_up(recording, analyse(recording), [0, 499.6, 1000, 2000, 5000])
    assert [point.within for point in found.points] == [True, False, True, False, True]
    assert found.points[1].within_in_service
    assert found.within is False


def test_command_prints_a_table_one_json_object_and_a_page(capture, tmp_path):
    loads = "0,500,1000,2000,5000"
    shown = run(capture, "--load-g", loads)
    assert shown.exit_code == 0
    assert "class III" in shown.output
    told = json.loads(run("file", capture, "--load-g", loads, "--json").stdout)
    assert [point["load_g"] for point in told["points"]] == [0, 500, 1000, 2000, 5000]
    assert len(told["placements"]) == 9
    target = tmp_path / "page.html"
    assert run(capture, "--load-g", loads, "-o", target).exit_code == 0
    text = target.read_text()
    assert "Errors and class III" in text
    assert "default-src 'none'" in text


def test_command_takes_a_truth_instead(capture, tmp_path):
    truth = tmp_path / "truth.csv"
    rows = [f"{DWELL_S * at},{load}" for at, load in enumerate(LOADS_G)]
    truth.write_text("\n".join(["t_s,load_g", *rows, f"{DWELL_S * len(LOADS_G)},0"]) + "\n")
    told = json.loads(run(capture, "--truth", truth, "--json").stdout)
    assert [point["load_g"] for point in told["points"]] == [0, 500, 1000, 2000, 5000]
    assert told["points"][2]["mean_error_e"] == pytest.approx(0.69, abs=0.05)


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["--load-g", "0,500,1000"], 2, "none of the loads given"),
        (["--load-g", "0,500,1000,2000,3500,5000"], 2, "nothing was read near 3500 g"),
        (["--load-g", "0,five"], 2, "no list of weights"),
        (["--load-g", "0,inf"], 2, "no list of weights"),
        (["--e-g", "0"], 2, "more than nothing"),
        (["--load-g", "0", "--truth", "x.csv"], 2, "say the same"),
    ],
)
def test_command_refuses_by_name(capture, arguments, code, words):
    refused = run(capture, *arguments)
    assert refused.exit_code == code
    assert words in " ".join(refused.stderr.split())


def test_command_overwrites_no_capture_and_names_its_verbs_where_there_is_no_file(capture):
    assert run(capture, "-o", capture).exit_code == 2
    refused = run("scroe")
    assert refused.exit_code == 9
    assert "static" in refused.stderr
    assert "score" in refused.stderr


def test_a_capture_too_short_to_read_is_refused(tmp_path):
    maker = CaptureMaker(tmp_path / "short.terazi", weights).hello()
    refused = run(maker.samples(5).end())
    assert refused.exit_code == 2
    assert "long enough" in refused.stderr


def test_limit_of_class_iii_is_drawn_with_its_corners():
    loads, limits = page.limit_steps(5000.0)
    assert loads.tolist() == [0, 500, 500, 2000, 2000, 5000]
    assert limits.tolist() == [0.5, 0.5, 1.0, 1.0, 1.5, 1.5]
    loads, limits = page.limit_steps(300.0)
    assert loads.tolist() == [0, 300]
    assert limits.tolist() == [0.5, 0.5]
