# SPDX-License-Identifier: MIT
"""Moments at which two things meet, tried cycle by cycle: only the simulator can place them."""

CYCLES_S = 16_000_000
OVERFLOW_CYCLES = 8 * 65_536  # Timer1 at clk/8
HANG = b"\xff\xcf"  # rjmp to itself


def next_conversion(virtual):
    """Cycle of the next conversion, if nothing delays it."""
    return int(virtual.conversions["cycle"][-1]) + CYCLES_S // 80


def run_to(virtual, cycle):
    virtual.run_cycles(int(cycle) - virtual.cycle)


def test_a_conversion_that_falls_while_the_one_before_is_read_is_not_missed(uno):
    """Its edge is one among those of the frame's bits: only the level tells. No edge would follow,
    and the time-out would have to help."""
    virtual = uno.truth("place its conversions to the cycle")
    place = virtual.symbol("telemetry_tick")
    program = virtual.flash[place : place + 2]
    uno.link.hello()
    uno.samples(40)
    for before in range(80, 900, 6):  # from polling over the whole read to after it
        run_to(virtual, next_conversion(virtual) + 8000)
        virtual.load_flash(place, HANG)
        run_to(virtual, next_conversion(virtual) + 8000)  # this one may wake the loop: it hangs
        run_to(virtual, next_conversion(virtual) + 8000)  # the edge of this is seen, but not read
        run_to(virtual, next_conversion(virtual) - before)
        virtual.load_flash(place, program)
        uno.wait(0.12)
    status = uno.link.status()
    assert status.converter_timeouts == 0
    assert status.settling_dropped > 400, "the reads were late"


def test_a_stamp_at_the_timer_s_overflow_is_right(uno):
    virtual = uno.truth("place its conversions to the cycle")
    while virtual.peek(0x81)[0] == 0:  # TCCR1B: here the clock starts, at cycle `start`
        virtual.run_cycles(1)
    start = virtual.cycle
    uno.link.hello()
    uno.samples(40)
    edge_us = virtual.symbol("edge_us")
    for offset in range(-90, 30):
        run_to(virtual, next_conversion(virtual) + 8000)
        due = next_conversion(virtual)
        overflow = start + -(-(due - start) // OVERFLOW_CYCLES) * OVERFLOW_CYCLES
        uno.fault("late", seconds=(overflow + offset - due) / CYCLES_S)
        run_to(virtual, overflow + offset + 8000)
        true_us = (virtual.conversions["cycle"][-1] - start) / 16.0
        told_us = int.from_bytes(virtual.peek(edge_us, 4), "little")
        assert -1.0 <= told_us - true_us < 20.0, f"{offset} cycles from the overflow"
