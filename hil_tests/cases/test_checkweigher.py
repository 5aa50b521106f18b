# SPDX-License-Identifier: MIT
"""The device as a checkweigher: a simulated belt under its cell, its verdicts and the truth."""

import numpy as np
import pytest

from terazi.applications.weighing import dynamic
from terazi.applications.weighing.belt import Belt, simulate
from terazi.control.products import collect, switch_on
from terazi.control.settings import apply_settings
from terazi.link.generated.messages import FaultFlag, Product, ResetCounts

LEAD_S = 4.0  # the device finds its zero and is set up
TAIL_S = 0.5


def passed_over(uno, belt):
    """The record, and what the device sent while it passed."""
    record = simulate(belt)
    uno.load(grams=record.at)
    uno.link.hello()
    switch_on(uno.link, dynamic.CONFIG)
    return record, collect(uno.link, round((record.passages[-1].leaves_s + TAIL_S) * 1e6))


@pytest.mark.board(noise_counts=dynamic.NOISE_COUNTS)
def test_device_weighs_120_products_a_minute_within_half_a_division(uno):
    belt = Belt(seed=21, products=60, lead_s=LEAD_S)
    record, passed = passed_over(uno, belt)
    verdicts, samples = dynamic.from_device(passed.products, passed.samples)
    found = dynamic.score(record, verdicts, samples, weighed_by="device")
    assert not np.isnan(found.errors_e).any()
    assert abs(found.mean_error_e) <= 0.1  # the zero that the device found in noise is in it
    assert found.sigma_e <= 0.04
    assert found.sigma_e <= min(peer.sigma_e for peer in found.peers.values()) / 3
    assert found.right_class_share == 1.0
    assert found.throughput_per_min == pytest.approx(120.0, abs=1.0)
    last = passed.products[-1][1]
    assert (last.weighed, last.unweighed) == (60, 0)
    assert last.per_minute_q8 / 256 == pytest.approx(120.0, abs=3.0)
    # A product that rings is no fault of the converter's.
    assert FaultFlag.NOISE_HIGH not in uno.link.status().faults_seen


@pytest.mark.board(noise_counts=dynamic.NOISE_COUNTS)
def test_device_weighs_as_the_host_does_from_the_samples_that_it_sends(uno):
    """Of the same counts the same weights, but for the zero that the device takes off."""
    _, passed = passed_over(uno, Belt(seed=22, products=12, lead_s=LEAD_S))
    verdicts, samples = dynamic.from_device(passed.products, passed.samples)
    host = dynamic.Checkweigher(dynamic.CONFIG)
    masses_mg = np.rint(samples.mass_g * 1000).astype(np.int32)
    events, weighed_mg = host.block(masses_mg, np.rint(samples.time_s * 1e6).astype(np.uint32))
    there_g = weighed_mg[events == dynamic.CheckweigherEvent.VERDICT] / 1000
    here_g = np.array([verdict.mass_g for verdict in verdicts])
    assert len(here_g) == 12
    zero_g = np.mean(there_g - here_g)
    assert abs(zero_g) < 0.2
    assert there_g - here_g == pytest.approx(np.full(12, zero_g), abs=0.02)  # units of 2^5 mg


@pytest.mark.board(noise_counts=dynamic.NOISE_COUNTS)
def test_device_says_of_a_product_under_which_a_conversion_was_lost_that_it_is_unweighed(uno):
    belt = Belt(seed=23, products=4, lead_s=LEAD_S)
    record = simulate(belt)
    uno.load(grams=record.at)
    uno.link.hello()
    switch_on(uno.link, dynamic.CONFIG)
    middle_s = (record.passages[1].on_s + record.passages[1].off_s) / 2
    collect(uno.link, round(middle_s * 1e6))
    uno.fault("cable_out")
    uno.wait(0.05)
    uno.clear_faults()
    passed = collect(uno.link, round((record.passages[-1].leaves_s + TAIL_S) * 1e6))
    told = [product.verdict for _, product in passed.products]
    assert told[0] == dynamic.UNWEIGHED
    assert passed.products[-1][1].unweighed >= 1
    assert passed.products[-1][1].verdict != dynamic.UNWEIGHED


@pytest.mark.board(noise_counts=dynamic.NOISE_COUNTS)
def test_device_counts_from_nothing_after_reset_counts_and_is_silent_when_off(uno):
    belt = Belt(seed=24, products=6, lead_s=LEAD_S)
    record = simulate(belt)
    uno.load(grams=record.at)
    uno.link.hello()
    switch_on(uno.link, dynamic.CONFIG)
    ends_s = [passage.leaves_s + 0.05 for passage in record.passages]
    first = collect(uno.link, round(ends_s[1] * 1e6)).products
    assert [product.weighed for _, product in first] == [1, 2]
    uno.link.command(ResetCounts())
    third = collect(uno.link, round(ends_s[2] * 1e6)).products
    assert [product.weighed for _, product in third] == [1]
    apply_settings(uno.link, {"checkweigher.on": 0})
    assert not [one for one in uno.wait(1.5) if isinstance(one.message, Product)]
