# SPDX-License-Identifier: MIT
"""The chain on the chip against the same C on this machine, bit for bit."""

import numpy as np
import pytest

from terazi.cshared import Scale, fir_block, weight_kf_adaptive_block, weight_kf_block
from terazi.link.generated.messages import ChainOrder, KfKind, Sample, SampleFlag


def chain_of(raw, hello):
    """FIR, Kalman filter and what comes last (Q7), in the order that HELLO tells."""
    kalman = weight_kf_adaptive_block if hello.kf_kind == KfKind.ADAPTIVE else weight_kf_block
    if hello.chain_order == ChainOrder.FIR_KF:
        fir = fir_block(raw)
        kf = kalman(fir)
        return fir, kf, kf
    kf = kalman(raw)
    fir = fir_block((kf + 64) >> 7)
    return fir, kf, fir * 128


def assert_chain_agrees(samples, hello):
    """Every answer of the device computed again from its raw counts, each run by itself."""
    starts = [n for n, one in enumerate(samples) if SampleFlag.RESTARTED in one.flags]
    assert starts[0] == 0, "the first sample must say that the filters were primed with it"
    for start, end in zip(starts, [*starts[1:], len(samples)], strict=True):
        run = samples[start:end]
        fir, kf, last = chain_of(np.array([one.raw_counts for one in run], np.int32), hello)
        mass = Scale().masses(last)
        assert [one.fir_counts for one in run] == list(fir)
        assert [one.kf_counts_q7 for one in run] == list(kf)
        assert [one.mass_mg for one in run] == list(mass)
    return len(starts)


@pytest.mark.board(noise_counts=38.7)
def test_filters_on_the_device_are_bit_identical_to_those_of_the_host(uno):
    hello = uno.link.hello()
    samples = [one.message for one in uno.samples(400)]
    assert assert_chain_agrees(samples, hello) == 1


@pytest.mark.board(noise_counts=5000.0, seed=7)
def test_filters_agree_under_steps_ramps_and_hum(uno):
    hello = uno.link.hello()
    uno.load(
        counts=lambda t_s: (
            3_000_000 * np.sign(np.sin(2.1 * t_s))
            + 900_000 * np.sin(2 * np.pi * 21.3 * t_s)
            - 200_000 * t_s
        )
    )
    samples = [one.message for one in uno.samples(1200)]
    assert assert_chain_agrees(samples, hello) > 1, "such noise is a fault that comes and goes"
    assert max(one.raw_counts for one in samples) - min(one.raw_counts for one in samples) > 6e6


@pytest.mark.board(noise_counts=60_000.0, seed=11)
def test_filters_agree_at_the_rails(uno):
    hello = uno.link.hello()
    uno.load(counts=lambda t_s: 9_000_000 * np.sin(3.0 * t_s))
    samples = [one.message for one in uno.samples(800)]
    assert assert_chain_agrees(samples, hello) == 1
    for one in samples:
        assert (SampleFlag.AT_RAIL in one.flags) == (one.raw_counts in (-(2**23), 2**23 - 1))
    assert {one.raw_counts for one in samples} >= {-(2**23), 2**23 - 1}
    assert uno.link.status().at_rail >= sum(SampleFlag.AT_RAIL in one.flags for one in samples)


@pytest.mark.board(noise_counts=38.7)
def test_filters_start_anew_after_a_fault_and_agree_in_every_run(uno):
    hello = uno.link.hello()
    uno.load(grams=100.0)
    received = uno.samples(50)
    for grams, fault in ((700.0, "cable_out"), (-300.0, "dout_low"), (20.0, "dout_high")):
        uno.fault(fault)
        uno.load(grams=grams)
        received += uno.wait(0.8)
        uno.clear_faults()
        received += uno.samples(50)
    samples = [one.message for one in received if isinstance(one.message, Sample)]
    # Each fault ends with a restart of the filters, and one more when the weight is trusted again.
    assert assert_chain_agrees(samples, hello) == 7
