# SPDX-License-Identifier: MIT
"""The worst stack is read off the disassembly as the chip would take it."""

import pytest

from tools.measure.stack import UnboundedStack, parse_disassembly, worst_stack

LEAF = """\
00000090 <leaf>:
  90:\tpush\tr28
  92:\tpush\tr29
  94:\tin\tr28, 0x3d\t; 61
  96:\tin\tr29, 0x3e\t; 62
  98:\tsubi\tr28, 0x2C\t; 44
  9a:\tsbci\tr29, 0x01\t; 1
  9c:\tin\tr0, 0x3f\t; 63
  9e:\tcli
  a0:\tout\t0x3e, r29\t; 62
  a2:\tout\t0x3f, r0\t; 63
  a4:\tout\t0x3d, r28\t; 61
  a6:\tsubi\tr28, 0xD4\t; 212
  a8:\tret
"""
PUSHED_FRAME = """\
00000150 <pushed_frame>:
 150:\tpush\tr28
 152:\tpush\tr29
 154:\tpush\tr1
 156:\tin\tr28, 0x3d\t; 61
 158:\tin\tr29, 0x3e\t; 62
 15a:\tsbci\tr23, 0xFF\t; 255
 15c:\tsbiw\tr28, 0x01\t; 1
 15e:\tret
"""
MAIN = """\
000000c0 <main>:
  c0:\trcall\t.+0      \t; 0xc2 <main+0x2>
  c2:\tcall\t0x90\t; 0x90 <leaf>
  c6:\trjmp\t.-6      \t; 0xc2 <main+0x2>
"""
HANDLER = """\
00000100 <__vector_1>:
 100:\tpush\tr1
 102:\tpush\tr0
 104:\tjmp\t0x120\t; 0x120 <tail>
00000120 <tail>:
 120:\tpush\tr24
 122:\treti
"""


def test_frame_pushes_and_reserved_bytes_are_counted():
    functions = parse_disassembly(LEAF + MAIN)
    assert functions["leaf"].own_bytes == 2 + 300
    assert functions["main"].own_bytes == 2


def test_frame_pointer_that_is_not_written_back_takes_no_room():
    assert parse_disassembly(PUSHED_FRAME)["pushed_frame"].own_bytes == 3


@pytest.mark.parametrize("label", [".LVL7", ".Loc.1", "L0^A"])
def test_labels_do_not_end_a_function(label):
    labelled = LEAF.replace("  a6:", f"\n000000a6 <{label}>:\n  a6:\tpush\tr2\n  a8:", 1)
    assert parse_disassembly(labelled)["leaf"].own_bytes == 2 + 300 + 1


SHARED_PROLOGUE = """
00000be6 <weighs>:
     be6:\tldi\tr26, 0x22\t; 34
     be8:\tldi\tr27, 0x01\t; 1
     bea:\tldi\tr30, 0xF9\t; 249
     bec:\tldi\tr31, 0x05\t; 5
     bee:\tjmp\t0x5c70\t; 0x5c70 <__prologue_saves__SKIPPED>
     bf2:\tldi\tr26, 0x07\t; 7
     bf4:\tjmp\t0x5c44\t; 0x5c44 <__tablejump2__>
00005c70 <__prologue_saves__>:
    5c70:\tpush\tr2
    5ca6:\tijmp
"""


@pytest.mark.parametrize(("skipped", "pushes"), [("", 18), ("+0x2", 17), ("+0x1e", 3)])
def test_the_shared_prologue_takes_what_it_saves_and_the_frame(skipped, pushes):
    functions = parse_disassembly(SHARED_PROLOGUE.replace("SKIPPED", skipped))
    assert functions["weighs"].own_bytes == pushes + 0x122
    assert not functions["weighs"].indirect_call
    assert not functions["weighs"].tail_jumps


def test_worst_case_is_main_path_and_deepest_handler():
    depth = worst_stack(parse_disassembly(LEAF + MAIN + HANDLER))
    assert depth.main_path == ("main", "leaf")
    assert depth.main_bytes == 2 + 2 + 2 + 302
    assert depth.interrupt_path == ("__vector_1", "tail")
    assert depth.interrupt_bytes == 2 + 2 + 1
    assert depth.total_bytes == depth.main_bytes + depth.interrupt_bytes


@pytest.mark.parametrize(
    ("code", "why"),
    [
        ("00000000 <main>:\n   0:\tcall\t0x0\t; 0x0 <main>\n", "recursion"),
        ("00000000 <main>:\n   0:\ticall\n", "indirect call in main"),
        (MAIN + LEAF + HANDLER.replace("push\tr24", "sei"), "tail enables interrupts"),
    ],
)
def test_what_has_no_bound_is_refused_by_name(code, why):
    with pytest.raises(UnboundedStack, match=why):
        worst_stack(parse_disassembly(code))
