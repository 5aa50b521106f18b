# SPDX-License-Identifier: GPL-3.0-or-later
"""The board in lock step: time passes only while ``run`` is called, and always the same way."""

import contextlib
import os
import weakref

import numpy as np

from virtual_uno import hx711, imu, signals
from virtual_uno.core_lib import ffi, lib
from virtual_uno.profile import Profile
from virtual_uno.program import SRAM_BASE, read_hex, read_program
from virtual_uno.uart import Uart

CLOCK_HZ = lib.UNO_CLOCK_HZ
FLASH_SIZE = 0x8000
EEPROM_SIZE = 1024
RAM_END = 0x8FF
BOOT_VECTOR = 0x7E00  # BOOTSZ = 11: 256 words, as the Uno's fuses say
RUN_SLICE_CYCLES = CLOCK_HZ // 10  # between looks at Python's signals
PAINT = 0xA5
ENDLESS_LOOP = b"\xff\xcf"  # rjmp to itself
RESET_CAUSES = {
    "power_on": lib.UNO_RESET_POWER_ON,
    "external": lib.UNO_RESET_EXTERNAL,
    "brown_out": lib.UNO_RESET_BROWN_OUT,
    "watchdog": lib.UNO_RESET_WATCHDOG,
}
CONVERSION = np.dtype(
    [
        ("cycle", "u8"),
        ("time_s", "f8"),
        ("counts", "i4"),
        ("source_counts", "f8"),
        ("pulses", "u1"),
        ("gain", "u1"),
        ("settling", "?"),
        ("read", "?"),
    ]
)


class UnoCrashed(RuntimeError):
    """The program left the flash or wrote outside the address space."""


@ffi.def_extern(name="virtual_uno_source")
def _source(handle, ticks, counts, n):
    uno = ffi.from_handle(handle)()  # a weak reference: the board must not keep itself alive
    at = np.frombuffer(ffi.buffer(ticks, 8 * n), np.uint64)
    into = np.frombuffer(ffi.buffer(counts, 8 * n), np.float64)
    try:
        into[:] = uno.signal_counts(at)
    except Exception as error:  # raised again where Python called run()
        into[:] = 0.0
        uno.signal_error = error


@ffi.def_extern(name="virtual_uno_part_source")
def _part_source(handle, part, ticks, dlpf, rows, n):
    uno = ffi.from_handle(handle)()
    at = np.frombuffer(ffi.buffer(ticks, 8 * n), np.uint64)
    width = imu.WIDTHS[part]
    into = np.frombuffer(ffi.buffer(rows, 8 * n * width), np.float64).reshape(n, width)
    try:
        into[:] = imu.part_signals(uno, part, at, dlpf)
    except Exception as error:  # raised again where Python called run()
        into[:] = 0.0
        uno.signal_error = error


class Uno:
    """An Arduino Uno with an HX711: DOUT on PD2 (INT0), PD_SCK on PD3.

    program : path of an ELF or Intel HEX file, or None for an endless loop.
    rate_sps : the converter's rate; ``clock_ppm`` is the error of its clock on top.
    noise_counts, jitter_s : rms of white noise and of each conversion's instant; seeded.
    boot : path of a boot loader's HEX; the chip then starts at 0x7E00.
    counts_per_gram, zero_counts : how ``load(grams=...)`` becomes counts.
    update_pulse_s : DOUT high for so long before fresh data replace unread ones; 0 = never,
        the harder case for a driver that waits for an edge.
    gain_kept : the gain survives power-down (HX711 datasheet V2.0) or not (V1).
    """

    def __init__(
        self,
        program=None,
        *,
        rate_sps=80.0,
        clock_ppm=0.0,
        noise_counts=0.0,
        jitter_s=0.0,
        seed=1,
        boot=None,
        counts_per_gram=hx711.COUNTS_PER_GRAM,
        zero_counts=0.0,
        update_pulse_s=0.0,
        gain_kept=False,
    ):
        self._handle = ffi.new_handle(weakref.ref(self))
        config = hx711.make_config(
            rate_sps * (1.0 + clock_ppm * 1e-6),
            jitter_s=jitter_s,
            noise_counts=noise_counts,
            seed=seed,
            update_pulse_s=update_pulse_s,
            gain_kept=gain_kept,
        )
        core = lib.uno_new(self._handle, config, seed)
        if core == ffi.NULL:
            raise MemoryError("no memory for a simulated Uno")
        self.core = ffi.gc(core, lib.uno_free)
        self.counts_per_gram = float(counts_per_gram)
        self.zero_counts = float(zero_counts)
        self.signal_error = None
        self.uart = Uart(self.core)
        self.eeprom = Eeprom(self.core)
        self.imu, self.mag, self.bus = imu.Imu(self), imu.Magnetometer(self), imu.Bus(self)
        self.program = None
        self._counts_at = None
        if program is not None:
            self.load_program(program)
        elif boot is None:
            self.load_flash(0, ENDLESS_LOOP)
        if boot is not None:
            for address, data in read_hex(boot):
                lib.uno_flash_write(self.core, address, data, len(data))
            lib.uno_set_reset_vector(self.core, BOOT_VECTOR)
        self.load(grams=0.0)

    # --- program and memory ---

    def load_program(self, path):
        """Put a program into flash (and EEPROM, if the ELF has contents for it)."""
        self.program = read_program(path)
        for address, data in self.program.flash:
            lib.uno_flash_write(self.core, address, data, len(data))
        for address, data in self.program.eeprom:
            self.eeprom.set(address, data)

    @property
    def flash(self):
        """The whole flash as bytes."""
        image = bytearray(FLASH_SIZE)
        lib.uno_flash_read(self.core, 0, ffi.from_buffer("uint8_t[]", image), len(image))
        return bytes(image)

    def load_flash(self, address, data):
        """Write bytes into flash directly."""
        if address < 0 or address + len(data) > FLASH_SIZE:
            raise ValueError("outside the flash")
        lib.uno_flash_write(self.core, address, bytes(data), len(data))

    def symbol(self, name):
        """Address of a symbol: flash byte address of code, SRAM address of data."""
        try:
            value = self.program.symbols[name]
        except (AttributeError, KeyError):
            raise KeyError(f"the program has no symbol {name!r}") from None
        return value - SRAM_BASE if value >= SRAM_BASE else value

    def peek(self, address, n=1):
        """``n`` bytes of the data space (registers, I/O, SRAM), without side effects."""
        _check_span("data space", address, n, RAM_END + 1)
        data = bytearray(n)
        lib.uno_peek(self.core, address, ffi.from_buffer("uint8_t[]", data), n)
        return bytes(data)

    def poke(self, address, data):
        """Write bytes into the data space, without side effects."""
        _check_span("data space", address, len(data), RAM_END + 1)
        lib.uno_poke(self.core, address, bytes(data), len(data))

    @property
    def pc(self):
        """Flash byte address of the next instruction."""
        return lib.uno_pc(self.core)

    @property
    def sp(self):
        """Stack pointer."""
        return lib.uno_sp(self.core)

    def paint_stack(self):
        """Fill the free SRAM between the program's data and the stack with a pattern."""
        start = self.symbol("_end")
        self.poke(start, bytes([PAINT]) * (self.sp - start))

    def stack_free(self):
        """Bytes above the program's data that still bear the paint: never used as stack."""
        start = self.symbol("_end")
        area = self.peek(start, RAM_END + 1 - start)
        return len(area) - len(area.lstrip(bytes([PAINT])))

    # --- time ---

    @property
    def cycle(self):
        """CPU cycles since construction; never goes back."""
        return lib.uno_cycle(self.core)

    @property
    def seconds(self):
        """Simulated seconds since construction."""
        return self.cycle / CLOCK_HZ

    @property
    def seconds_since_reset(self):
        """Simulated seconds since the program last started."""
        return (self.cycle - lib.uno_reset_cycle(self.core)) / CLOCK_HZ

    def run(self, seconds):
        """Let simulated time pass."""
        self.run_cycles(round(seconds * CLOCK_HZ))

    def run_cycles(self, n):
        """Run ``n`` cycles, and the few by which the last instruction goes beyond."""
        until = self.cycle + n
        while (now := self.cycle) < until:
            state = lib.uno_run(self.core, min(until, now + RUN_SLICE_CYCLES))
            if self.signal_error is not None:
                error, self.signal_error = self.signal_error, None
                raise error
            if state == lib.UNO_CRASHED:
                where = self.program.function_at(self.pc) if self.program else hex(self.pc)
                raise UnoCrashed(f"the program crashed at {where} after {self.seconds:.6f} s")

    def run_until(self, predicate, timeout_s, step_s=0.001):
        """Run until ``predicate()`` holds; TimeoutError after ``timeout_s`` simulated seconds."""
        until = self.cycle + round(timeout_s * CLOCK_HZ)
        while not predicate():
            if self.cycle >= until:
                raise TimeoutError(f"not reached within {timeout_s} simulated seconds")
            self.run(step_s)

    def reset(self, cause="external"):
        """Restart the program. Power-on and brown-out also restart the HX711 and lose SRAM."""
        if cause not in RESET_CAUSES:
            raise ValueError(f"no reset cause {cause!r}; there are {', '.join(RESET_CAUSES)}")
        lib.uno_reset(self.core, RESET_CAUSES[cause])

    # --- the load cell ---

    def load(self, grams=None, counts=None):
        """What lies on the cell: a number, ``(array, rate_hz)`` or a function of seconds.

        Seconds count from the last reset. A function is asked for blocks of instants ahead.
        """
        if (grams is None) == (counts is None):
            raise TypeError("load() takes either grams or counts")
        scale, zero = (1.0, 0.0) if grams is None else (self.counts_per_gram, self.zero_counts)
        load = counts if grams is None else grams
        if not callable(load) and not isinstance(load, tuple):
            self._counts_at = None
            lib.uno_load_constant(self.core, zero + scale * float(load))
            return
        function = signals.as_function(load)
        self._counts_at = lambda t_s: zero + scale * function(t_s)
        lib.uno_load_source(self.core)

    def signal_counts(self, cycles):
        """The load at those cycles, in counts; asked for by the core."""
        since = cycles.astype(np.int64) - lib.uno_reset_cycle(self.core)
        return self._counts_at(since / CLOCK_HZ)

    def fault(self, name, **how):
        """Make the HX711 or its wiring misbehave; see ``virtual_uno.hx711.FAULTS``."""
        fault = ffi.new("hx711_fault_t *")
        lib.uno_get_fault(self.core, fault)
        hx711.apply_fault(fault, name, CLOCK_HZ, **how)
        lib.uno_fault(self.core, fault)

    def clear_faults(self):
        """All is well again; a cable put back powers the HX711 up anew."""
        lib.uno_fault(self.core, ffi.new("hx711_fault_t *"))

    @property
    def conversions(self):
        """The HX711's own truth: one CONVERSION record for each since construction."""
        return self.conversions_since(0)

    @property
    def conversion_count(self):
        """How many there have been since construction."""
        return lib.hx711_record_count(lib.uno_hx711(self.core))

    def conversions_since(self, first):
        """The same from index ``first`` on."""
        records = hx711.read_records(lib.uno_hx711(self.core), first)
        out = np.empty(len(records), CONVERSION)
        out["cycle"] = records["tick"]
        out["time_s"] = records["tick"] / CLOCK_HZ
        out["source_counts"] = records["source"]
        for name in ("counts", "pulses", "gain", "settling", "read"):
            out[name] = records[name]
        return out

    # --- looking on ---

    @property
    def stats(self):
        """Counters of the chip and, under "hx711", of the converter (see core/uno.h)."""
        raw = ffi.new("uno_stats_t *")
        lib.uno_get_stats(self.core, raw)
        stats = {name: getattr(raw, name) for name, _ in ffi.typeof("uno_stats_t").fields}
        stats["hx711"] = hx711.read_stats(lib.uno_hx711(self.core))
        return stats

    def profile(self, functions=()):
        """Context manager that measures the named functions, all handlers and critical sections."""
        return Profile(self, functions)

    @contextlib.contextmanager
    def vcd(self, path):
        """Record SCK, DOUT, TX and RX into a VCD file while the context is open."""
        lib.uno_vcd_start(self.core)
        try:
            yield
        finally:
            error = lib.uno_vcd_stop(self.core, os.fsencode(path))
        if error:
            raise OSError(error, os.strerror(error), str(path))


class Eeprom:
    """The chip's EEPROM; survives every reset."""

    def __init__(self, core):
        self._core = core

    def get(self, address=0, n=EEPROM_SIZE):
        """``n`` bytes from ``address``."""
        _check_span("EEPROM", address, n, EEPROM_SIZE)
        data = bytearray(n)
        lib.uno_eeprom_get(self._core, address, ffi.from_buffer("uint8_t[]", data), n)
        return bytes(data)

    def set(self, address, data):
        """Put bytes there."""
        _check_span("EEPROM", address, len(data), EEPROM_SIZE)
        lib.uno_eeprom_set(self._core, address, bytes(data), len(data))


def _check_span(what, address, n, size):
    if address < 0 or n < 0 or address + n > size:
        raise ValueError(f"0x{address:x} + {n} is outside the {what}")
