# SPDX-License-Identifier: MIT
"""Where a recording may be cut for replay."""

import numpy as np
import pytest

from terazi.link.generated.messages import SampleFlag
from terazi.replay import Segment, segments_of

PLAIN, RESTARTED, GAP = 0, int(SampleFlag.RESTARTED), int(SampleFlag.GAP)


def samples(*rows):
    """Rows of (conversion, flags, lost_before, boot)."""
    conversion, flags, lost_before, boot = np.array(rows).T
    return {
        "conversion": conversion.astype(np.uint16),
        "flags": flags.astype(np.uint8),
        "lost_before": lost_before.astype(np.int32),
        "boot": boot.astype(np.int32),
    }


def test_segments_of_an_undisturbed_recording_are_one():
    rows = [(5, RESTARTED, 0, 0), (6, PLAIN, 0, 0), (7, PLAIN, 0, 0)]
    assert segments_of(samples(*rows)) == [Segment(0, 3, True)]


def test_segments_begin_unprimed_in_mid_stream():
    assert segments_of(samples((9, PLAIN, 3, 0), (10, PLAIN, 0, 0))) == [Segment(0, 2, False)]


def test_segments_are_cut_where_a_frame_is_lost():
    rows = [(1, RESTARTED, 0, 0), (2, PLAIN, 0, 0), (4, PLAIN, 1, 0), (5, PLAIN, 0, 0)]
    assert segments_of(samples(*rows)) == [Segment(0, 2, True), Segment(2, 4, False)]


def test_segments_run_on_over_a_conversion_that_the_device_itself_lost():
    rows = [(1, RESTARTED, 0, 0), (2, PLAIN, 0, 0), (4, GAP, 0, 0), (5, PLAIN, 0, 0)]
    assert segments_of(samples(*rows)) == [Segment(0, 4, True)]


def test_segments_do_not_trust_a_gap_where_frames_are_missing_too():
    rows = [(1, RESTARTED, 0, 0), (2, PLAIN, 0, 0), (5, GAP, 1, 0), (6, PLAIN, 0, 0)]
    assert segments_of(samples(*rows)) == [Segment(0, 2, True), Segment(2, 4, False)]


def test_segments_run_on_over_a_lost_frame_that_was_no_sample():
    rows = [(1, RESTARTED, 0, 0), (2, PLAIN, 1, 0), (3, PLAIN, 0, 0)]
    assert segments_of(samples(*rows)) == [Segment(0, 3, True)]


def test_segments_start_anew_where_the_filters_do():
    rows = [(1, RESTARTED, 0, 0), (2, PLAIN, 0, 0), (9, RESTARTED, 0, 0), (10, PLAIN, 0, 0)]
    assert segments_of(samples(*rows)) == [Segment(0, 2, True), Segment(2, 4, True)]


def test_segments_start_anew_with_the_device():
    rows = [(1, RESTARTED, 0, 0), (2, PLAIN, 0, 0), (3, PLAIN, 0, 1)]
    assert segments_of(samples(*rows)) == [Segment(0, 2, True), Segment(2, 3, False)]


@pytest.mark.parametrize("flags", [PLAIN, GAP])
def test_segments_follow_the_conversion_counter_over_its_end(flags):
    rows = [(65534, RESTARTED, 0, 0), (65535, PLAIN, 0, 0), (0, flags, 0, 0), (1, PLAIN, 0, 0)]
    assert segments_of(samples(*rows)) == [Segment(0, 4, True)]
