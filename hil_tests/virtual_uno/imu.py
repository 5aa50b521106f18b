# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts on the two-wire bus as tests see them: an MPU-6050, a magnetometer, the bus itself."""

import numpy as np

from virtual_uno.core_lib import ffi, lib
from virtual_uno.signals import as_vectors

AXES = 3
REGISTERS = 128
MAG_REGISTERS = 16
WIDTHS = {lib.UNO_PART_IMU: 7, lib.UNO_PART_MAG: 3}
NOWHERE = 255
# DLPF_CFG 0..7: bandwidth in Hz and delay in s of accelerometer and gyroscope, register map p. 13;
# 7 is reserved and behaves as 0.
ACC_DLPF = ((260, 0.0), (184, 2.0e-3), (94, 3.0e-3), (44, 4.9e-3),
            (21, 8.5e-3), (10, 13.8e-3), (5, 19.0e-3), (260, 0.0))  # fmt: skip
GYRO_DLPF = ((256, 0.98e-3), (188, 1.9e-3), (98, 2.8e-3), (42, 4.8e-3),
             (20, 8.3e-3), (10, 13.4e-3), (5, 18.6e-3), (256, 0.98e-3))  # fmt: skip
ACC_RATE_HZ = 1000.0
ACC_NOISE_G_RTHZ = 400e-6  # product specification p. 13
GYRO_NOISE_DEG_S_RTHZ = 0.005  # p. 12
BUS_FAULTS = ("sda_stuck", "scl_stuck", "deaf")
MAGNETOMETERS = {"qmc5883l": lib.UNO_MAG_QMC5883L, "hmc5883l": lib.UNO_MAG_HMC5883L}
# What a MEMS part in the hand shows: mid-range trim codes for all six axes.
TRIM = (0x6C, 0x6C, 0x6C, 0x2A)


class Imu:
    """An MPU-6050 at 0x68 of the board ``uno``; nothing answers there until ``fit``.

    True signals are numbers, ``(array, rate_hz)`` or functions of seconds since the last reset;
    what the part makes of them, ``errors`` and the register settings tell.
    """

    def __init__(self, uno):
        self._core = uno.core
        self._rows = None
        self._rng = np.random.default_rng(0)
        self._noise = (0.0, 0.0)
        self._acc_g = as_vectors((0.0, 0.0, 1.0))
        self._gyro_deg_s = as_vectors((0.0, 0.0, 0.0))
        self._temperature_c = as_vectors(25.0, width=1)
        self.errors()

    def fit(self, *, who_am_i=0x68, int_bit=4, clock_ppm=0.0, trim=TRIM):
        """Put a part on the bus and power it; int_bit of port D is wired to INT, None: nothing."""
        config = ffi.new("imu_config_t *")
        config.who_am_i, config.clock_ppm = who_am_i, clock_ppm
        config.int_bit = NOWHERE if int_bit is None else int_bit
        config.trim = trim
        if not lib.uno_imu_fit(self._core, config):
            raise ValueError("there is no room on the two-wire bus")
        return self

    def wire_int(self, int_bit):
        """Wire INT to that bit of port D, or, None, to nothing; the part goes on."""
        lib.uno_imu_wire_int(self._core, NOWHERE if int_bit is None else int_bit)

    def unplug(self):
        """Nothing answers any more."""
        lib.uno_imu_plug(self._core, 0)

    def plug(self):
        """The same part again, as after a power-on."""
        lib.uno_imu_plug(self._core, 1)

    power_cycle = plug

    def feel(self, *, acc_g=None, gyro_deg_s=None, temperature_c=None):
        """What there is to measure from now on; what is not named stays as it is."""
        if acc_g is not None:
            self._acc_g = as_vectors(acc_g)
        if gyro_deg_s is not None:
            self._gyro_deg_s = as_vectors(gyro_deg_s)
        if temperature_c is not None:
            self._temperature_c = as_vectors(temperature_c, width=1)
        lib.uno_imu_restate(self._core)

    def errors(
        self,
        *,
        gyro_bias_deg_s=(0.0, 0.0, 0.0),
        gyro_matrix=None,
        gyro_per_g=0.0,
        gyro_bias_per_k=(0.0, 0.0, 0.0),
        acc_offset_g=(0.0, 0.0, 0.0),
        acc_matrix=None,
        acc_offset_per_k=(0.0, 0.0, 0.0),
    ):
        """How the part errs: matrix @ true + bias + per_k (T - 25 degC); what is not named: not.

        The matrices hold scale and cross-axis sensitivity; gyro_per_g is deg/s a g, all axes.
        """
        self._gyro_bias = np.asarray(gyro_bias_deg_s, float)
        self._gyro_matrix = np.eye(AXES) if gyro_matrix is None else np.asarray(gyro_matrix, float)
        self._gyro_per_g = float(gyro_per_g)
        self._gyro_per_k = np.asarray(gyro_bias_per_k, float)
        self._acc_offset = np.asarray(acc_offset_g, float)
        self._acc_matrix = np.eye(AXES) if acc_matrix is None else np.asarray(acc_matrix, float)
        self._acc_per_k = np.asarray(acc_offset_per_k, float)
        lib.uno_imu_restate(self._core)

    def noise(self, acc_g_rthz=ACC_NOISE_G_RTHZ, gyro_deg_s_rthz=GYRO_NOISE_DEG_S_RTHZ, *, seed=1):
        """White noise of these densities within the filter's bandwidth."""
        self._noise = (float(acc_g_rthz), float(gyro_deg_s_rthz))
        self._rng = np.random.default_rng(seed)
        lib.uno_imu_restate(self._core)

    def play(self, acc_counts, gyro_counts, temperature_counts=0):
        """(n, 3) raw int16 values each, one row a sample, in place of all signals; None ends it."""
        if acc_counts is None:
            self._rows = None
            lib.uno_imu_play(self._core, ffi.NULL, 0)
            return
        acc, gyro = (np.asarray(each) for each in (acc_counts, gyro_counts))
        if acc.shape != gyro.shape or acc.ndim != 2 or acc.shape[1] != AXES or not len(acc):
            raise ValueError("accelerometer and gyroscope rows must have one shape (n, 3), n > 0")
        warm = np.broadcast_to(np.asarray(temperature_counts), len(acc))
        wanted = np.column_stack([acc, gyro, warm])
        rows = np.ascontiguousarray(wanted, dtype=np.int16)
        if not np.array_equal(rows, wanted):
            raise ValueError("played values do not fit in 16 bits")
        lib.uno_imu_play(self._core, ffi.from_buffer("int16_t[]", rows), len(rows))
        self._rows = rows  # the core reads them in place

    @property
    def played(self):
        """The row that comes next."""
        return lib.uno_imu_played(self._core)

    @property
    def registers(self):
        """All 128, without side effects."""
        regs = bytearray(REGISTERS)
        lib.uno_imu_registers(self._core, ffi.from_buffer("uint8_t[]", regs))
        return bytes(regs)

    def set_register(self, reg, value):
        """As if it were written over the bus."""
        lib.uno_imu_set_register(self._core, reg, value)

    @property
    def stats(self):
        """Counters, see ``imu_stats_t`` in core/uno.h."""
        stats = ffi.new("imu_stats_t *")
        lib.uno_imu_get_stats(self._core, stats)
        return {name: getattr(stats, name) for name, _ in ffi.typeof("imu_stats_t").fields}

    def felt(self, at_s, dlpf):
        """(n, 7) of the sensors at (n,) seconds since reset: g, deg/s, degC; asked by the core."""
        (acc_band, acc_delay_s), (gyro_band, gyro_delay_s) = ACC_DLPF[dlpf], GYRO_DLPF[dlpf]
        acc_s = np.floor(at_s * ACC_RATE_HZ) / ACC_RATE_HZ if dlpf in (0, 7) else at_s
        true_acc = self._acc_g(acc_s - acc_delay_s)
        warm = self._temperature_c(at_s)
        above_k = warm - 25.0
        acc = true_acc @ self._acc_matrix.T + self._acc_offset + above_k * self._acc_per_k
        gyro = self._gyro_deg_s(at_s - gyro_delay_s) @ self._gyro_matrix.T + self._gyro_bias
        gyro = gyro + above_k * self._gyro_per_k + self._gyro_per_g * true_acc
        for values, density, band in (
            (acc, self._noise[0], acc_band),
            (gyro, self._noise[1], gyro_band),
        ):
            if density:
                # one pole's noise bandwidth
                values += self._rng.normal(0.0, density * np.sqrt(band * np.pi / 2), values.shape)
        return np.hstack([acc, gyro, warm])


class Magnetometer:
    """A QMC5883L or HMC5883L on the same bus; nothing answers until ``fit``."""

    def __init__(self, uno):
        self._core = uno.core
        self._field_ut = as_vectors((20.0, 0.0, -40.0))

    def fit(self, kind):
        """Put one there: "qmc5883l" or "hmc5883l"; a board has one."""
        if kind not in MAGNETOMETERS:
            raise ValueError(f"no magnetometer {kind!r}; there are {', '.join(MAGNETOMETERS)}")
        if not lib.uno_mag_fit(self._core, MAGNETOMETERS[kind]):
            raise ValueError("there is a magnetometer already, or no room on the two-wire bus")
        return self

    def unplug(self):
        """Nothing answers any more."""
        lib.uno_mag_plug(self._core, 0)

    def plug(self):
        """The same part again, as after a power-on."""
        lib.uno_mag_plug(self._core, 1)

    def feel(self, field_ut):
        """The field in microtesla on the part's axes, as a constant, array or function."""
        self._field_ut = as_vectors(field_ut)

    @property
    def registers(self):
        """All 16, without side effects."""
        regs = bytearray(MAG_REGISTERS)
        lib.uno_mag_registers(self._core, ffi.from_buffer("uint8_t[]", regs))
        return bytes(regs)

    def felt(self, at_s):
        """(n, 3) gauss; asked by the core."""
        return self._field_ut(at_s) / 100.0


class Bus:
    """The two wires."""

    def __init__(self, uno):
        self._core = uno.core

    def fault(self, name, *, clocks=0):
        """sda_stuck (until SCL was clocked so often; 0: for ever), scl_stuck, deaf (all NACK)."""
        if name not in BUS_FAULTS:
            raise ValueError(f"no bus fault {name!r}; there are {', '.join(BUS_FAULTS)}")
        fault = ffi.new("twi_fault_t *")
        lib.uno_twi_get_fault(self._core, fault)
        setattr(fault, name, 1)
        if name == "sda_stuck":
            fault.sda_clocks = clocks
        lib.uno_twi_set_fault(self._core, fault)

    def clear_faults(self):
        """All is well again."""
        lib.uno_twi_set_fault(self._core, ffi.new("twi_fault_t *"))

    @property
    def is_stuck(self):
        """A line is held low."""
        fault = ffi.new("twi_fault_t *")
        lib.uno_twi_get_fault(self._core, fault)
        return bool(fault.sda_stuck or fault.scl_stuck)


def part_signals(uno, part, cycles, dlpf):
    """Rows of what a part senses at those cycles."""
    at_s = (cycles.astype(np.int64) - lib.uno_reset_cycle(uno.core)) / lib.UNO_CLOCK_HZ
    return uno.imu.felt(at_s, dlpf) if part == lib.UNO_PART_IMU else uno.mag.felt(at_s)
