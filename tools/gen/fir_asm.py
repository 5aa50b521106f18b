# SPDX-License-Identifier: MIT
"""Renders port_fir_default.S: the default FIR design as straight code, its coefficients in it.

What a loop must do for any coefficient, this does only where the coefficient at hand needs it: a
byte of it that is zero costs nothing, one that is 1 no multiplication, and none is read from ROM.
"""

from __future__ import annotations

from terazi.design import specs
from tools.gen.spec import Spec

COLUMN_BITS = 24
SAMPLE_BYTES = 3
DISPLACEMENT_MAX = 63  # of LDD, AVR instruction set manual

X_LOW, X_HIGH, Z_LOW, Z_HIGH = "r26", "r27", "r30", "r31"
SAMPLE = ("r18", "r19", "r20")
LOW, HIGH, ZERO = "r21", "r22", "r23"  # the coefficient's bytes; LOW is also the mirrored byte
# Three columns of three bytes; those that start with a value other than 0 take it by LDI.
COLUMNS = {0: ("r11", "r12", "r13"), 8: ("r24", "r14", "r15"), 16: ("r16", "r17", "r25")}
START = {"r24": "0x40", "r25": "0xC0"}
SAVED = ("r11", "r12", "r13", "r14", "r15", "r16", "r17")

HEAD = """\
/* {origin} */
/* SPDX-License-Identifier: MIT */
/* port_fir_default - the fold of design {name}, its coefficients in the code.
 * Contract: shared_c/src/port_fir.h; derivation: firmware/port/port_fir.S, shared_c/notes/fir.md
 *
 *   int32_t port_fir_fold_default(const uint8_t row[], const fir_config_t *config)
 *                                 r25:r24              r23:r22, which is not looked at
 *
 * Modulo 2^40, in the three columns of port_fir.S; a negative coefficient's products are taken off.
 * Bounds of the columns, all samples at their worst:
 *   column 0   {column_0}
 *   column 8   {column_8}
 * X: older samples, upwards.  Z: the middle; newer samples are read at a displacement from it.
 */

        .section .text.port_fir_fold_default, "ax", @progbits
        .global port_fir_fold_default
        .type   port_fir_fold_default, @function
port_fir_fold_default:"""


class _Code:
    def __init__(self) -> None:
        self.lines: list[str] = []
        self.high: int | None = None  # what is in HIGH
        self.labels = 0

    def __call__(self, operation: str, *operands: str) -> None:
        self.lines.append(f"        {operation:<8}{', '.join(operands)}".rstrip())

    def label(self) -> str:
        self.labels += 1
        return f".Lno_carry_{self.labels}"


def column_bounds(taps: list[int]) -> dict[int, tuple[int, int]]:
    """Least and greatest value of columns 0 and 8, which must be told apart from their sign."""
    bounds = {0: [0, 0], 8: [64, 64]}
    count = len(taps)
    for k in range((count + 1) // 2):
        low, high = abs(taps[k]) & 255, abs(taps[k]) >> 8
        side = 0 if taps[k] < 0 else 1
        sign = -1 if taps[k] < 0 else 1
        bounds[0][side] += sign * 255 * low
        bounds[8][side] += sign * 255 * (low + high)
    return {column: (least, most) for column, (least, most) in bounds.items()}


def is_signed(bounds: tuple[int, int]) -> bool:
    """Whether a column must be read with its sign; ValueError where its bytes cannot tell."""
    least, most = bounds
    if least >= 0 and most < 1 << COLUMN_BITS:
        return False
    if least >= -(1 << COLUMN_BITS - 1) and most < 1 << COLUMN_BITS - 1:
        return True
    raise ValueError(f"a column of 24 bits cannot hold {least} to {most}")


def _gather(code: _Code, sample: str, factor: int, held_in: str, column: tuple, minus: bool):
    """column +-= sample * factor; two bytes of a column are enough where the third drops out."""
    first, then = ("sub", "sbc") if minus else ("add", "adc")
    if factor == 1:
        product = (sample, ZERO, ZERO)
    else:
        code("mul", sample, held_in)
        product = ("r0", "r1", ZERO)
    for place, (target, source) in enumerate(zip(column, product, strict=False)):
        code(first if place == 0 else then, target, source)


def _load_folded(code: _Code, displacement: int | None) -> None:
    for byte in SAMPLE:
        code("ld", byte, "X+")
    if displacement is None:
        return
    for place, byte in enumerate(SAMPLE):
        code("ldd", LOW, f"Z + {displacement + place}")
        code("add" if place == 0 else "adc", byte, LOW)


def _tap(code: _Code, k: int, tap: int, displacement: int | None) -> None:
    code.lines.append(f"        /* c[{k}] = {tap} */")
    if tap == 0:
        code("adiw", X_LOW, "3")
        return
    low, high, minus = abs(tap) & 255, abs(tap) >> 8, tap < 0
    _load_folded(code, displacement)
    code("ldi", LOW, str(low))  # touches no flag
    if high != code.high:
        code("ldi", HIGH, str(high))
        code.high = high
    if displacement is not None:
        no_carry = code.label()
        code("brcc", no_carry)
        code("sub" if minus else "add", COLUMNS[16][1], LOW)
        code("sbc" if minus else "adc", COLUMNS[16][2], HIGH)
        code.lines.append(f"{no_carry}:")
    s0, s1, s2 = SAMPLE
    if low:
        _gather(code, s0, low, LOW, COLUMNS[0], minus)
        _gather(code, s1, low, LOW, COLUMNS[8], minus)
        _gather(code, s2, low, LOW, COLUMNS[16], minus)
    if high:
        _gather(code, s0, high, HIGH, COLUMNS[8], minus)
        _gather(code, s1, high, HIGH, COLUMNS[16], minus)
        _gather(code, s2, high, HIGH, COLUMNS[16][1:], minus)


def _begin(code: _Code, middle: int) -> None:
    for register in SAVED:
        code("push", register)
    code("movw", X_LOW, "r24")
    code("movw", Z_LOW, "r24")
    code("adiw", Z_LOW, str(middle))
    for register in (ZERO, *(byte for column in COLUMNS.values() for byte in column)):
        if register in START:
            code("ldi", register, START[register])
        else:
            code("clr", register)


def _end(code: _Code, signed: dict[int, bool]) -> None:
    code.lines.append(
        "        /* bytes 1..4 of the columns' sum, then twice that, shifted by 16 */"
    )
    byte2, byte3, byte4, sign8 = "r22", "r18", "r19", "r20"
    code("mov", byte2, COLUMNS[0][2])
    if signed[0]:
        code("mov", byte3, COLUMNS[0][2])
        code("lsl", byte3)
        code("sbc", byte3, byte3)
        code("mov", byte4, byte3)
    else:
        code("clr", byte3)
        code("clr", byte4)
    if signed[8]:
        code("mov", sign8, COLUMNS[8][2])
        code("lsl", sign8)
        code("sbc", sign8, sign8)
    code("add", COLUMNS[0][1], COLUMNS[8][0])
    code("adc", byte2, COLUMNS[8][1])
    code("adc", byte3, COLUMNS[8][2])
    code("adc", byte4, sign8 if signed[8] else ZERO)
    code("add", byte2, COLUMNS[16][0])
    code("adc", byte3, COLUMNS[16][1])
    code("adc", byte4, COLUMNS[16][2])
    code("lsl", COLUMNS[0][1])
    code("rol", byte2)
    code("rol", byte3)
    code("rol", byte4)
    code("sbc", "r25", "r25")
    code("mov", "r24", byte4)
    code("mov", "r23", byte3)
    code("clr", "r1")
    for register in reversed(SAVED):
        code("pop", register)
    code("ret")


def source(spec: Spec) -> str:
    """Text of port_fir_default.S, for the first design of fir.toml."""
    design = spec.content["design"][0]
    return text_of(specs.fir_taps_q15(design["name"]).tolist(), design["name"], spec.origin)


def text_of(taps: list[int], name: str, origin: str) -> str:
    """Assembler for any coefficients that have room twice in the window."""
    pairs, alone = divmod(len(taps), 2)
    if SAMPLE_BYTES * pairs - 1 > DISPLACEMENT_MAX:
        raise ValueError(f"{len(taps)} taps are out of reach of one pointer")
    bounds = column_bounds(taps)
    code = _Code()
    _begin(code, SAMPLE_BYTES * (pairs + alone))
    for k in range(pairs):
        _tap(code, k, taps[k], SAMPLE_BYTES * (pairs - 1 - k))
    if alone:
        _tap(code, pairs, taps[pairs], None)
    _end(code, {column: is_signed(each) for column, each in bounds.items()})
    words = {f"column_{column}": f"{a} to {b}" for column, (a, b) in bounds.items()}
    head = HEAD.format(origin=origin, name=name, **words)
    foot = "        .size   port_fir_fold_default, . - port_fir_fold_default"
    return "\n".join([head, *code.lines, foot, ""])
