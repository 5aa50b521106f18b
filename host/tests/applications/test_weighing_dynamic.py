# SPDX-License-Identifier: MIT
"""Dynamic weighing on the host's C: what must hold, and the judges themselves."""

import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from terazi.applications.weighing import dynamic, peers
from terazi.applications.weighing.belt import Belt, Passage, simulate
from terazi.cli import app
from terazi.link.generated.messages import Product

PRODUCTS = 400
RATE_HZ = 80.0


def weighed(belt, rate_hz=RATE_HZ, **changed):
    record, config = simulate(belt), dynamic.CONFIG | changed
    verdicts, samples = dynamic.weigh_on_host(
        record, seed=belt.seed, rate_hz=rate_hz, config=config
    )
    return dynamic.score(record, verdicts, samples, weighed_by="host C")


@pytest.fixture(scope="module")
def result():
    return weighed(Belt(seed=11, products=PRODUCTS))


@pytest.mark.parametrize("rate_hz", [78.0, 80.0, 92.0])
def test_dynamic_mean_error_and_sigma_hold_at_every_rate_of_the_converter(rate_hz):
    """Required are 0.5 e of each; the converter's noise alone would allow 0.02."""
    found = weighed(Belt(seed=12, products=PRODUCTS), rate_hz)
    assert abs(found.mean_error_e) <= 0.01
    assert found.sigma_e <= 0.03
    for part in (*found.per_load.values(), *found.per_tone.values()):
        assert abs(part.mean_error_e) <= 0.02
        assert part.sigma_e <= 0.04
    assert np.nanmax(np.abs(found.errors_e)) <= 0.2


def test_dynamic_weighs_each_product_once_at_120_a_minute(result):
    assert not np.isnan(result.errors_e).any()
    assert len(result.errors_e) == PRODUCTS
    assert result.throughput_per_min == pytest.approx(120.0, abs=0.5)
    assert sum(part.products for part in result.per_load.values()) == PRODUCTS
    assert sum(part.products for part in result.per_tone.values()) == PRODUCTS


def test_dynamic_classifies_as_far_as_the_truth_allows(result):
    """Only what lies within its error of a limit may fall to the other side."""
    weights = np.array([passage.weight_g for passage in result.passages])
    away_g = np.abs(weights[:, None] - dynamic.LIMITS_G).min(axis=1)
    doubtful = np.mean(away_g < np.abs(result.errors_e).max() * dynamic.E_G)
    assert doubtful < 0.01
    assert result.right_class_share >= 1.0 - doubtful


@pytest.mark.parametrize("seed", [11, 13])
def test_dynamic_sigma_is_a_third_of_the_best_common_filter_s_in_each_part_of_the_tones(seed):
    found = weighed(Belt(seed=seed, products=PRODUCTS))
    assert len(found.per_tone) == 4
    for tone, part in found.per_tone.items():
        for name, peer in found.peers_per_tone[tone].items():
            assert part.sigma_e <= peer.sigma_e / 3, (tone, name)
    assert found.least_ratio() >= 3.0
    assert found.sigma_e <= min(peer.sigma_e for peer in found.peers.values()) / 8


def test_dynamic_holds_for_platforms_that_swing_four_times_as_much():
    """By up to 0.3 of the weight, so that the steps of the integers count."""
    swinging = Belt(seed=14, products=200, weight_g=(700.0, 1000.0), swing_share=(0.08, 0.2))
    found = weighed(swinging, enter_mg=450_000, leave_mg=100_000)
    assert not np.isnan(found.errors_e).any()
    assert abs(found.mean_error_e) <= 0.02
    assert found.sigma_e <= 0.1


def test_dynamic_settings_of_the_peers_are_found_on_other_products(result):
    other = dynamic.tuned_peers(Belt(seed=11), length=24, rate_hz=RATE_HZ)
    assert {name: peer.setting for name, peer in other.items()} == result.settings
    assert set(result.settings) == set(peers.families(24, RATE_HZ))


def test_dynamic_takes_no_verdict_or_two_for_none():
    passage = Passage(500.0, 10.0, 0.04, 0.0, 0.05, 0.35, 0.4)
    one, other = dynamic.Verdict(0.41, 500.0, 1), dynamic.Verdict(0.45, 501.0, 1)
    late = dynamic.Verdict(0.9, 500.0, 1)
    assert dynamic.matched([one, late], [passage]) == [one]
    assert dynamic.matched([late], [passage]) == [None]
    assert dynamic.matched([one, other], [passage]) == [None]


def test_dynamic_reads_a_device_s_messages_as_it_reads_the_host_s_c():
    told = [
        (500_000, Product(412_345, 1, 20, 1, 0, 0)),
        (1_000_000, Product(0, 255, 3, 1, 1, 30_720)),
    ]
    verdicts, samples = dynamic.from_device(told, [(12_500, 0), (25_000, 2_147_766)])
    assert verdicts == [dynamic.Verdict(0.5, 412.345, 1), dynamic.Verdict(1.0, None, None)]
    assert samples.time_s == pytest.approx([0.0125, 0.025])
    assert samples.mass_g == pytest.approx([0.0, 5000.0], abs=0.01)


def test_dynamic_counts_what_was_not_weighed_as_wrongly_classed():
    belt = Belt(seed=15, products=20)
    record = simulate(belt)
    verdicts, samples = dynamic.weigh_on_host(record, seed=15)
    verdicts[3] = replace(verdicts[3], mass_g=None, class_at=None)
    found = dynamic.score(record, verdicts, samples, weighed_by="host C")
    assert found.right_class_share == pytest.approx(0.95)
    assert np.isnan(found.errors_e).sum() == 1


@pytest.mark.parametrize("family", list(peers.families(24, RATE_HZ)))
def test_peers_of_every_setting_are_true_for_a_load_that_rests(family):
    for peer in peers.families(24, RATE_HZ)[family]:
        assert peer.run(np.full((2, 24), 321.0)) == pytest.approx([321.0, 321.0])


@pytest.mark.parametrize(("name", "design"), [("butterworth", "butter"), ("bessel", "bessel")])
@pytest.mark.parametrize("order", [2, 4])
def test_peers_recursive_filters_are_those_of_the_books(name, design, order):
    signal = pytest.importorskip("scipy.signal", reason="scipy is the oracle here")
    poles = {"butterworth": peers.BUTTERWORTH, "bessel": peers.BESSEL}[name][order]
    options = {"norm": "mag"} if design == "bessel" else {}
    book = getattr(signal, design)(order, 2.7, fs=RATE_HZ, output="sos", **options)
    masses = np.random.default_rng(1).normal(0, 1, (3, 24))
    start = signal.sosfilt_zi(book)
    wanted = [signal.sosfilt(book, row, zi=start * row[0])[0][-1] for row in masses]
    assert peers.recursive(poles, 2.7, RATE_HZ, 0)(masses) == pytest.approx(wanted, abs=1e-6)


def test_weigh_dynamic_prints_one_json_object_and_nothing_else():
    options = ["weigh", "dynamic", "--host", "--products", "24", "--seed", "5", "--json"]
    ran = CliRunner().invoke(app, options)
    assert ran.exit_code == 0
    found = json.loads(ran.stdout)
    assert found["e_g"] == 1.0
    assert found["weighed_by"] == "host C"
    assert found["sigma_e"] < 0.05
    assert found["throughput_per_min"] == pytest.approx(120, abs=2)
    assert set(found["peers"]["fir_lowpass"]) == {"mean_error_e", "sigma_e"}
    assert sum(part["products"] for part in found["per_load"].values()) == 24


def test_weigh_dynamic_shows_a_table_and_writes_a_page_that_needs_no_network(tmp_path):
    page = tmp_path / "belt.html"
    options = ["weigh", "dynamic", "--host", "--products", "24", "--page", str(page)]
    ran = CliRunner().invoke(app, options, env={"COLUMNS": "140"})
    assert ran.exit_code == 0
    assert "checkweigher" in ran.stdout
    assert "fir_lowpass" in ran.stdout
    text = page.read_text(encoding="utf-8")
    assert "Products on a simulated belt" in text
    assert 'src="http' not in text


def test_weigh_dynamic_writes_the_belt_for_a_simulated_uno(tmp_path):
    path = tmp_path / "belt.npz"
    ran = CliRunner().invoke(app, ["weigh", "dynamic", "--products", "8", "--scenario", str(path)])
    assert ran.exit_code == 0
    with np.load(path) as held:
        assert held["load_g"].shape == held["truth_g"].shape
        assert held["rate_hz"] == 4000.0
        assert held["truth_g"].max() > 200.0
