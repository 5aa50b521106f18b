# SPDX-License-Identifier: MIT
"""The recorded temperature run, in lock step with the test double."""

import csv

import pytest

from host.tests.fake_bench import Bench, Script
from terazi.calibration.temperature import Plan, calibrate_temperature
from terazi.control import Balance
from terazi.errors import Aborted, CalibrationRefused, CannotWrite
from terazi.link.generated.settings import SettingKey

COUNTS_PER_G = 429.55
ZERO, SPAN = 25.0, 60.0  # counts/K, ppm/K
KEYS = {
    "origin": SettingKey.TEMPERATURE_ORIGIN_COUNTS,
    "reference": SettingKey.TEMPERATURE_REFERENCE_CENTI,
    "zero": SettingKey.TEMPERATURE_ZERO_COUNTS_PER_K_Q4,
    "span": SettingKey.TEMPERATURE_SPAN_PPM_PER_K_Q4,
    "on": SettingKey.TEMPERATURE_ON,
}


def warm_and_cool(t_s):
    """Up by 8 K in 200 s, and down again, for ever."""
    return 20.0 + 8.0 * abs((t_s / 200.0 + 1) % 2 - 1)


def drift(degrees, load_g):
    above_k = degrees - 20.0
    return ZERO * above_k + SPAN * 1e-6 * above_k * COUNTS_PER_G * load_g


def warm_bench(**more):
    return Bench(**{"warm": warm_and_cool, "drift": drift, "noise_counts": 5.0} | more)


def held(bench):
    return {name: bench.chain.values[key] for name, key in KEYS.items()}


class Hand(Script):
    """Puts two kilogram on when it is asked to."""

    def __init__(self, bench, *answers):
        super().__init__(*answers)
        self._bench = bench

    def tell(self, text, *, tone=""):
        super().tell(text, tone=tone)
        if text.startswith("Put one mass on"):
            self._bench.load_g = 2000.0


def run(bench, terminal, **plan):
    return calibrate_temperature(Balance(bench.link), terminal, Plan(**plan))


def test_a_run_finds_the_drifts_of_zero_and_span_and_the_board_keeps_them():
    bench = warm_bench()
    hand = Hand(bench)
    fit = run(bench, hand, asks=False, span_k=6.0)
    assert fit.zero_counts_per_k == pytest.approx(ZERO, abs=0.7)
    assert fit.span_ppm_per_k == pytest.approx(SPAN, abs=2.0)
    bench.reset()
    kept = held(bench)
    assert kept["on"] == 1
    assert kept["zero"] == round(fit.zero_counts_per_k * 16)
    assert kept["span"] == round(fit.span_ppm_per_k * 16)
    assert "saved, and read back" in hand.text
    rows = [line.split("  ") for line in hand.said if line.startswith("with ")]
    assert [float(row[1]) > 5 * float(row[2]) for row in rows] == [True, True]


def test_a_person_ends_each_series_and_decides():
    bench = warm_bench()

    def with_mass():
        bench.load_g = 2000.0

    script = Script("", "", with_mass, "", "save")
    script.turns = 600  # 150 s
    assert run(bench, script).helps
    assert held(bench)["on"] == 1
    assert any("K at least" in live for live in script.lives)


@pytest.mark.parametrize("end", ["leave", "abort"])
def test_without_consent_the_board_stays_as_it_was(end):
    bench = warm_bench()
    bench.chain.values[KEYS["on"]] = 1  # an older compensation
    before = held(bench)
    script = Script("", "", end)
    script.turns = 600
    if end == "abort":
        with pytest.raises(Aborted):
            run(bench, script, with_mass=False)
    else:
        assert run(bench, script, with_mass=False) is None
    assert held(bench) == before


def test_the_device_does_not_correct_while_it_is_recorded():
    bench = warm_bench()
    bench.chain.values[KEYS["on"]] = 1
    seen = set()
    script = Script("", lambda: seen.add(held(bench)["on"]), "save")
    script.turns = 600
    run(bench, script, with_mass=False)
    assert seen == {0}


def test_a_run_that_hardly_moved_is_refused_with_what_to_do():
    bench = warm_bench(warm=lambda t_s: 20.0 + t_s / 400)
    script = Script("", "")
    script.turns = 200
    with pytest.raises(
        CalibrationRefused, match=r"moved by .* K, at least 3 K are needed"
    ) as caught:
        run(bench, script, with_mass=False)
    assert "slowly" in caught.value.remedy
    assert held(bench)["on"] == 0


def test_a_board_without_a_thermometer_is_told_apart():
    with pytest.raises(CalibrationRefused, match="no thermometer") as caught:
        run(Bench(), Script())
    assert "SDA at A4" in caught.value.remedy


def test_the_run_lies_in_a_table_also_if_it_breaks_off(tmp_path):
    path = tmp_path / "run.csv"
    bench = warm_bench()

    def interrupt():
        raise KeyboardInterrupt

    script = Script("", "", interrupt)
    script.turns = 100
    with pytest.raises(KeyboardInterrupt):
        run(bench, script, output=path)
    rows = list(csv.DictReader(path.read_text().splitlines()))
    assert 20 <= len(rows) <= 26
    assert {row["series"] for row in rows} == {"with nothing on"}
    assert float(rows[0]["raw_counts"]) == pytest.approx(84_000, abs=200)
    with pytest.raises(CannotWrite, match="exists already"):
        run(warm_bench(), Script(""), output=path)
