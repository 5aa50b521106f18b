# SPDX-License-Identifier: MIT
"""Moving means, variances and minima against what their definition says, sample by sample."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from terazi.applications.walks.windows import (
    moving_mean,
    moving_min,
    moving_variance,
    odd_length,
    spans,
)

values = st.integers(1, 60).flatmap(
    lambda count: arrays(np.float64, count, elements=st.floats(-100, 100, width=32))
)
lengths = st.integers(0, 8).map(lambda half: 2 * half + 1)


@given(values=values, length=lengths)
def test_moving_mean_is_the_mean_of_the_window(values, length):
    half = length // 2
    for at, (centred, past) in enumerate(
        zip(moving_mean(values, length), moving_mean(values, length, causal=True), strict=True)
    ):
        assert centred == pytest.approx(values[max(0, at - half) : at + half + 1].mean(), abs=1e-9)
        assert past == pytest.approx(values[max(0, at - length + 1) : at + 1].mean(), abs=1e-9)


@given(values=values, length=lengths)
def test_moving_min_is_the_least_of_the_window_which_does_not_shrink_at_edges(values, length):
    count = len(values)
    whole = min(length, count)
    for at in range(count):
        begin = min(max(0, at - length // 2), count - whole)
        assert moving_min(values, length)[at] == values[begin : begin + whole].min()
        past = values[max(0, at - length + 1) : at + 1].min()
        assert moving_min(values, length, causal=True)[at] == past


@given(values=values, length=lengths, cut=st.integers(1, 60))
def test_causal_windows_know_nothing_of_the_future(values, length, cut):
    for function in (moving_mean, moving_min):
        whole = function(values, length, causal=True)[:cut]
        assert np.array_equal(function(values[:cut], length, causal=True), whole)
    whole = moving_variance(values[:, None], length, causal=True)[:cut]
    assert np.array_equal(moving_variance(values[:cut, None], length, causal=True), whole)


def test_moving_variance_is_that_of_all_axes_together():
    rng = np.random.default_rng(2)
    vectors = rng.normal(3.0, 1.0, (40, 3))
    found = moving_variance(vectors, 9)
    assert found[20] == pytest.approx(vectors[16:25].var(axis=0).sum())


@pytest.mark.parametrize(("seconds", "length"), [(0.0, 1), (0.005, 1), (0.025, 5), (0.045, 9)])
def test_odd_length_is_odd_and_near(seconds, length):
    assert odd_length(seconds, 200.0) == length


@given(which=arrays(np.bool_, st.integers(0, 40)))
def test_spans_hold_all_that_is_true_and_nothing_else(which):
    found = spans(which)
    again = np.zeros(len(which), bool)
    for begin, end in found:
        again[begin:end] = True
    assert np.array_equal(again, which)
    assert np.all(found[1:, 0] > found[:-1, 1])  # apart, in order
