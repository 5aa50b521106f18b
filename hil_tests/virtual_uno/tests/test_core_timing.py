# SPDX-License-Identifier: GPL-3.0-or-later
"""What the chip costs: instructions, interrupts, flags. Figures counted by hand in programs/."""

import hashlib

import pytest

HAND_COUNTED = {
    "count_empty": 8,
    "count_loop": 308,
    "count_memory": 23,
    "count_arithmetic": 18,
    "count_bits": 20,
    "count_jumps": 17,
    "count_nested": 15,
    "count_tail": 11,
}


def test_functions_cost_what_the_instruction_set_manual_says(uno):
    board = uno("cycles.S")
    with board.profile(HAND_COUNTED) as profile:
        board.run(0.001)
    # count_empty is also reached by count_tail's jump: jmp 3 + ret 4
    assert profile.functions["count_empty"].min_cycles == 7
    assert profile.functions["count_empty"].calls == 2
    found = {name: cost.max_cycles for name, cost in profile.functions.items()}
    assert found == HAND_COUNTED


def test_rcall_costs_one_cycle_less_than_call(uno):
    board = uno("cycles.S")
    with board.profile(["count_near"]) as profile:
        board.run(0.001)
    assert profile.functions["count_near"].max_cycles == 7


def test_pin_edges_are_as_far_apart_as_the_instructions_between(uno, tmp_path, vcd_edges):
    board = uno("cycles.S")
    with board.vcd(tmp_path / "w.vcd"):
        board.run(0.001)
    (up, _), (down, _) = vcd_edges(tmp_path / "w.vcd", "SCK")
    assert down - up == 37 + 2


def test_profiling_does_not_change_time(uno, tmp_path, vcd_edges):
    edges = []
    for profiled in (False, True):
        board = uno("interrupts.S")
        with board.vcd(tmp_path / "w.vcd"):
            if profiled:
                with board.profile():
                    board.run(0.001)
            else:
                board.run(0.001)
        edges.append(vcd_edges(tmp_path / "w.vcd", "SCK"))
    assert edges[0] == edges[1]


def test_interrupt_costs_entry_4_jump_3_and_reti_4(uno, tmp_path, vcd_edges):
    board = uno("interrupts.S")
    with board.vcd(tmp_path / "w.vcd"), board.profile(["interrupted"]) as profile:
        board.run(0.001)
    assert profile.handlers["TIMER1_COMPA"].calls == 1
    assert profile.handlers["TIMER1_COMPA"].max_cycles == 4 + 3 + 4
    assert profile.handlers["PCINT0"].max_cycles == 4 + 3 + 2 + 4
    # the same seen from outside: the bracket grew by the handler and by nothing else
    (up, _), (down, _) = vcd_edges(tmp_path / "w.vcd", "SCK")
    assert down - up == 1000 + 2 + 11


def test_profile_takes_interrupts_out_of_functions(uno):
    board = uno("interrupts.S")
    with board.profile(["interrupted"]) as profile:
        board.run(0.001)
    cost = profile.functions["interrupted"]
    assert cost.max_cycles == 4 + 2 + 1000 + 2 + 4
    assert cost.gross_max_cycles == cost.max_cycles + 11


@pytest.mark.parametrize("profiled", [False, True])
def test_one_instruction_runs_after_sei_and_after_reti(uno, profiled):
    board = uno("interrupts.S")
    if profiled:
        with board.profile():
            board.run(0.001)
    else:
        board.run(0.001)
    assert list(board.peek(0x100, 2)) == [1, 2]


def test_flag_registers_clear_what_is_written_one_and_nothing_else(uno, variables):
    board = uno("flags.c")
    board.run(0.1)
    ocf1a, tov1 = 0x02, 0x01
    assert variables(board, "flags_both") == ocf1a | tov1
    assert variables(board, "flags_after_out") == ocf1a
    assert variables(board, "flags_after_sbi") == tov1


def test_enabling_an_interrupt_whose_flag_is_set_raises_it(uno, variables):
    board = uno("flags.c")
    board.run(0.1)
    assert variables(board, "masked_entries", "late_entries") == [0, 1]


def test_sbi_on_a_pin_register_toggles_one_bit(uno, variables):
    board = uno("flags.c")
    board.run(0.1)
    assert variables(board, "port_after_toggle") == 0x15 ^ 0x20


def test_port_writes_make_no_false_edges_on_int0_but_data_bits_do(uno, variables):
    board = uno("flags.c", rate_sps=1000)
    board.load(counts=-0x800000)
    board.fault("rail", side="low")  # first bit one, second bit zero
    board.run(0.1)
    assert variables(board, "done", "false_edges", "real_edges") == [1, 0, 1]


def test_interrupt_pending_before_sei_wakes_the_sleep_that_follows(uno, variables):
    board = uno("flags.c")
    board.run(0.1)
    assert variables(board, "woke", "done") == [1, 1]


def test_waking_takes_four_cycles_more_than_entry(uno):
    # windows.c sleeps until TIMER0_OVF, every 2048 cycles: the handler's share is constant, so
    # what is awake must be too, and the sleep is the rest
    board = uno("windows.c")
    board.run(0.01)
    slept = board.stats["sleep_cycles"]
    board.run_cycles(2048 * 100)
    awake = 2048 * 100 - (board.stats["sleep_cycles"] - slept)
    with board.profile(["section_of_21", "section_of_6"]) as profile:
        board.run_cycles(2048 * 100)
    handler = profile.handlers["TIMER0_OVF"].max_cycles
    assert profile.cpu_load == pytest.approx(awake / (2048 * 100), abs=1e-4)
    assert handler < awake / 100 < handler + 150


def test_windows_are_measured_from_end_to_end_and_named(uno):
    board = uno("windows.c")
    with board.profile(["section_of_21"]) as profile:
        board.run(0.05)
    by_place = {window.begin.split("+")[0]: window for window in profile.windows}
    assert by_place["section_of_21"].max_cycles == 21
    assert by_place["section_of_6"].max_cycles == 6
    assert profile.irq_off_max.begin.startswith("section_of_21")
    # from reset to the first SEI is start-up, no window
    assert "main" not in by_place
    assert by_place["section_of_21"].count == profile.functions["section_of_21"].calls


def test_paint_and_lowest_stack_pointer_agree(uno):
    board = uno("windows.c")
    board.paint_stack()
    with board.profile(["deep"]) as profile:
        board.run(0.05)
    assert profile.functions["deep"].calls == 9
    free = board.stack_free()
    # SP points below the last byte pushed; compiled frames may leave bytes untouched
    assert 0 <= board.symbol("_end") + free - (profile.stack_min + 1) <= 16


def test_the_same_run_gives_the_same_bytes_at_the_same_cycles(uno):
    def digest():
        board = uno("reader.c", noise_counts=40.0, jitter_s=1e-6, seed=7)
        board.load(grams=lambda t: 10.0 * t)
        board.run(1.0)
        data, cycles = board.uart.read_stamped()
        return hashlib.sha256(data + cycles.tobytes()).hexdigest(), len(data)

    first = digest()
    assert first[1] > 300
    assert digest() == first == digest()


def test_slices_of_running_do_not_change_what_happens(uno):
    whole, sliced = (uno("reader.c", noise_counts=40.0) for _ in range(2))
    whole.run(0.5)
    while sliced.cycle < whole.cycle:
        sliced.run_cycles(min(997, whole.cycle - sliced.cycle))
    assert whole.uart.read() == sliced.uart.read() != b""


def test_a_run_ends_within_an_instruction_of_what_was_asked(uno):
    board = uno("reader.c")
    for _ in range(100):
        before = board.cycle
        board.run_cycles(333)
        assert 333 <= board.cycle - before < 333 + 8


def test_seed_changes_noise(uno):
    streams = []
    for seed in (1, 2):
        board = uno("reader.c", noise_counts=40.0, seed=seed)
        board.run(0.5)
        streams.append(board.uart.read())
    assert streams[0] != streams[1]


def compare_program(uno, first):
    board = uno("compare.c")
    board.run(0.0001)
    board.poke(board.symbol("first"), first.to_bytes(2, "little"))
    board.poke(board.symbol("go"), b"\1")
    return board


@pytest.mark.parametrize("first", [0, 1, 777, 2047])
def test_a_compare_set_anew_by_its_interrupt_keeps_its_pace_through_every_turn(
    uno, variables, first
):
    board = compare_program(uno, first)
    board.run(1.0)
    calls, at_zero, late_most, overflows = (
        int.from_bytes(bytes(variables(board, name, n=2)), "little")
        for name in ("calls", "at_zero", "late_most", "overflows")
    )
    assert calls == pytest.approx(2_000_000 / 2048, abs=2)
    assert overflows == pytest.approx(2_000_000 / 65536, abs=1)
    assert at_zero == (overflows if first == 0 else 0)
    assert (
        late_most <= 14
    )  # 7 us: entry and pushes 40 cycles, the other handler 55, no interrupts 15


def test_a_compare_that_is_put_off_does_not_fire(uno, variables):
    board = compare_program(uno, 0)
    board.run(0.01)
    board.poke(board.symbol("put_off"), b"\1")
    board.run(0.001)
    before = variables(board, "calls", n=2)
    board.run(0.5)
    assert variables(board, "calls", n=2) == before
    board.poke(board.symbol("put_off"), b"\0")
    board.run(0.01)
    assert variables(board, "calls", n=2) != before
