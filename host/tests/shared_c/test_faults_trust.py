# SPDX-License-Identifier: MIT
"""Faults injected at random into the device's chain: no wrong weight is ever called stable."""

import numpy as np
import pytest

from terazi.cshared import Fault, FaultsEvent, weigh_events
from terazi.design import scale
from tools.measure.fault_stories import KINDS, NAMED, story, wrong_by_mg

E_MG = 1000.0
LAG = 64  # conversions: the FIR's 32 and the Kalman filter's settling
LIVES = [(80.0, 1_000_000, 1), (92.0, 200_000, 2), (78.0, 200_000, 3), (10.8, 300_000, 4)]
SLOW_STABLE_US = 3_000_000  # at 10 SPS: the time must span the FIR, or it cannot see what is in it


def settings(rate_sps):
    return scale.config() if rate_sps > 40 else scale.config() | {"stable_us": SLOW_STABLE_US}


@pytest.fixture(scope="module", params=LIVES, ids=lambda life: f"{life[0]:g}_sps")
def life(request):
    rate_sps, samples, seed = request.param
    told = story(samples, rate_sps=rate_sps, seed=seed)
    weighed = weigh_events(told.events, told.counts, told.device_us, settings(rate_sps))
    return told, weighed


def test_no_wrong_stable_weight_with_random_faults(life):
    told, weighed = life
    stable = weighed.stable
    wrong_mg = wrong_by_mg(weighed.mass_mg, told.load_mg, LAG)
    assert len(told.events) >= 200_000
    assert {episode.kind for episode in told.episodes} == set(KINDS)
    assert stable.mean() > 0.3, "or it would be easy"
    assert not np.any(stable & (weighed.held != 0)), "a fault that spoils leaves nothing stable"
    assert wrong_mg[stable].max() <= E_MG


def test_without_what_faults_finds_weights_would_be_wrong(life):
    """The test above can fail: the same conversions, called good one and all."""
    told, _ = life
    arrived = told.events == FaultsEvent.CONVERSION
    arrived |= np.isin(told.events, [FaultsEvent.DROPPED, FaultsEvent.OFF_BEAT])
    kept = np.flatnonzero(arrived)
    good = np.full(len(kept), int(FaultsEvent.CONVERSION))
    alone = weigh_events(good, told.counts[kept], told.device_us[kept], watched=False)
    wrong_mg = wrong_by_mg(alone.mass_mg, told.load_mg[kept], LAG)
    assert wrong_mg[alone.stable].max() > E_MG


def test_every_plain_fault_is_named_by_its_second_event(life):
    told, weighed = life
    for episode in told.episodes:
        if episode.kind in NAMED:
            soon = weighed.held[episode.begin : episode.begin + 2]
            assert np.any(soon & NAMED[episode.kind]), episode


def test_every_fault_is_forgotten_within_eleven_good_conversions(life):
    """A second at 10.8 SPS; what ends a run settles for 4 more, which are in the episode."""
    told, weighed = life
    begins = [*(episode.begin for episode in told.episodes[1:]), len(told.events)]
    looked = 0
    for episode, next_begin in zip(told.episodes, begins, strict=True):
        quiet = slice(episode.end + 11, min(next_begin, episode.end + 30))
        quiet_load = told.load_mg[episode.end : quiet.stop]
        if quiet.start < quiet.stop and np.ptp(quiet_load) == 0:
            assert not np.any(weighed.held[quiet] & ~Fault.NOISE), episode
            assert not weighed.held[quiet][-1], episode
            looked += 1
    assert looked > 500
