# SPDX-License-Identifier: GPL-3.0-or-later
"""What the running program costs: functions, handlers, critical sections, stack, sleep."""

import dataclasses

from virtual_uno.core_lib import ffi, lib

# Table 12-6 of the ATmega328P datasheet, by vector number.
VECTOR_NAMES = [
    "RESET",
    "INT0",
    "INT1",
    "PCINT0",
    "PCINT1",
    "PCINT2",
    "WDT",
    "TIMER2_COMPA",
    "TIMER2_COMPB",
    "TIMER2_OVF",
    "TIMER1_CAPT",
    "TIMER1_COMPA",
    "TIMER1_COMPB",
    "TIMER1_OVF",
    "TIMER0_COMPA",
    "TIMER0_COMPB",
    "TIMER0_OVF",
    "SPI_STC",
    "USART_RX",
    "USART_UDRE",
    "USART_TX",
    "ADC",
    "EE_READY",
    "ANALOG_COMP",
    "TWI",
    "SPM_READY",
]


@dataclasses.dataclass(frozen=True)
class Cost:
    """Cycles of all calls of one function or handler, interrupts within it taken out.

    A function counts from the first cycle of the instruction that enters it (CALL 4, RCALL 3,
    ICALL 3) to the last of its RET; a handler its entry (4), the jump in the vector table, its
    body and RETI. ``gross_max_cycles`` leaves interrupts in (functions only, else None).
    """

    calls: int
    min_cycles: int
    max_cycles: int
    total_cycles: int
    gross_max_cycles: int | None = None

    @property
    def mean_cycles(self):
        """Average of a call; NaN when there was none."""
        return self.total_cycles / self.calls if self.calls else float("nan")


@dataclasses.dataclass(frozen=True)
class Window:
    """A stretch outside handlers with the I flag clear.

    Measured from the end of the instruction that cleared I to the end of the one that set it;
    ``begin`` and ``end`` name these two. The I flag clear since reset is no window.
    """

    begin_pc: int
    end_pc: int
    begin: str
    end: str
    count: int
    max_cycles: int
    total_cycles: int


@dataclasses.dataclass(frozen=True)
class Figures:
    """All that one profile found."""

    functions: dict  # name -> Cost
    handlers: dict  # vector name -> Cost, of those that ran
    windows: list  # of Window, the longest first
    windows_dropped: int
    cycles: int
    sleep_cycles: int
    stack_min: int  # lowest stack pointer seen

    @property
    def irq_off_max(self):
        """The longest window, or None."""
        return self.windows[0] if self.windows else None

    @property
    def cpu_load(self):
        """Share of the time that the core was awake."""
        return 1.0 - self.sleep_cycles / self.cycles if self.cycles else float("nan")


class Profile:
    """Context manager: profiles while it is open; the figures are there afterwards."""

    def __init__(self, uno, names):
        self._uno = uno
        self._entries = {}
        for name in names:
            address = uno.symbol(name) if isinstance(name, str) else int(name)
            self._entries[name] = address

    def __enter__(self):
        entries = list(self._entries.values())
        if lib.uno_profile_start(self._uno.core, entries, len(entries)):
            raise ValueError(f"at most {lib.UNO_FUNCTIONS_MAX} functions at a time")
        return self

    def __exit__(self, *_):
        lib.uno_profile_stop(self._uno.core)
        self._figures = self._read()

    @property
    def figures(self):
        """Figures of the profile, once its context has been left."""
        return self._figures

    def _read(self):
        core, describe = self._uno.core, self._uno.program.function_at
        functions = ffi.new("uno_function_t[]", lib.UNO_FUNCTIONS_MAX)
        lib.uno_profile_functions(core, functions)
        vectors = ffi.new("uno_vector_t[]", lib.UNO_VECTORS)
        lib.uno_profile_vectors(core, vectors)
        raw = ffi.new("uno_window_t[]", lib.UNO_WINDOWS_MAX)
        windows = [
            Window(
                w.begin_pc,
                w.end_pc,
                describe(w.begin_pc),
                describe(w.end_pc),
                w.count,
                w.max_cycles,
                w.total_cycles,
            )
            for w in raw[0 : lib.uno_profile_windows(core, raw)]
        ]
        totals = ffi.new("uint64_t[4]")
        lib.uno_profile_totals(core, totals)
        return Figures(
            functions={
                name: Cost(f.calls, f.min_cycles, f.max_cycles, f.total_cycles, f.gross_max_cycles)
                for name, f in zip(self._entries, functions, strict=False)
            },
            handlers={
                name: Cost(v.calls, v.min_cycles, v.max_cycles, v.total_cycles)
                for name, v in zip(VECTOR_NAMES, vectors, strict=True)
                if v.calls
            },
            windows=sorted(windows, key=lambda w: -w.max_cycles),
            windows_dropped=totals[3],
            cycles=totals[1],
            sleep_cycles=totals[2],
            stack_min=totals[0],
        )

    def __getattr__(self, name):
        # profile.functions, profile.handlers, ... without a detour
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self.figures, name)
