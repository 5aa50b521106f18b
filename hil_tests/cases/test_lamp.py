# SPDX-License-Identifier: MIT
"""The LED on D13, watched at its pin: it beats when all is well and counts out what is wrong."""

import pytest

PORTB, LED = 0x25, 1 << 5
LOOK_S = 0.01
FLASH_S, PAUSE_S = 0.197, 1.18
SLACK_S = 0.075  # the lamp sees 65 ms of the clock, and so do we


def levels(virtual, seconds):
    """(level, how long) of the LED, without the first and the last, which are cut."""
    runs = []
    for _ in range(round(seconds / LOOK_S)):
        virtual.run(LOOK_S)
        level = bool(virtual.peek(PORTB)[0] & LED)
        if runs and runs[-1][0] == level:
            runs[-1][1] += LOOK_S
        else:
            runs.append([level, LOOK_S])
    return [tuple(run) for run in runs[1:-1]]


def flashes(runs):
    """Numbers of flashes between pauses."""
    counted, now = [], None
    for is_lit, length_s in runs:
        if not is_lit and length_s > PAUSE_S:
            counted.append(now)
            now = 0
        elif is_lit and now is not None:
            assert length_s == pytest.approx(FLASH_S, abs=SLACK_S)
            now += 1
    return counted[1:]


@pytest.mark.board(noise_counts=38.7)
def test_the_lamp_beats_when_all_is_well(uno):
    virtual = uno.truth("show its LED")
    virtual.run(1.0)
    runs = levels(virtual, 8.0)
    assert len(runs) >= 13
    assert all(length_s == pytest.approx(0.52, abs=SLACK_S) for _, length_s in runs)


@pytest.mark.board(noise_counts=38.7)
@pytest.mark.parametrize(
    ("fault", "how", "number"),
    [
        ("cable_out", {}, 1),
        ("dout_low", {}, 2),
        ("rail", {}, 3),
        ("rate", {"factor": 4.0}, 4),
        ("noise", {"counts": 1e6}, 6),
    ],
)
def test_the_lamp_counts_out_the_fault(uno, fault, how, number):
    virtual = uno.truth("break its own wires")
    virtual.run(1.0)
    uno.fault(fault, **how)
    virtual.run(0.5)
    told = flashes(levels(virtual, 12.0 + 0.8 * number))
    assert len(told) >= 2
    assert set(told) == {number}
    uno.clear_faults()
    virtual.run(6.0)
    assert all(length_s < 0.7 for _, length_s in levels(virtual, 5.0))


@pytest.mark.board(noise_counts=38.7)
def test_a_fault_that_is_over_at_once_is_still_shown(uno):
    """Five flashes: conversions lost. It held for a tenth of a second."""
    virtual = uno.truth("lose a conversion")
    virtual.run(1.0)
    uno.fault("conversion_lost", count=1)
    runs = levels(virtual, 6.0)
    begin = next(at for at, (lit, length_s) in enumerate(runs) if lit and length_s < 0.35)
    shown = runs[begin : begin + 9]
    assert [lit for lit, _ in shown] == [True, False] * 4 + [True]
    assert all(length_s == pytest.approx(FLASH_S, abs=SLACK_S) for _, length_s in shown)
    assert runs[begin + 9][1] > PAUSE_S - SLACK_S
