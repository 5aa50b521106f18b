# SPDX-License-Identifier: MIT
"""The test double's bench with an IMU that plays a simulated board's sitting, mode by mode."""

from host.tests.fake_bench import Bench
from host.tests.fake_imu import FakeImu
from terazi.calibration.imu.board import MODES
from terazi.calibration.imu.rehearsal import FACES, SLANTS, Board
from terazi.link.generated.messages import Imu, Mag, StreamFlag
from terazi.link.generated.settings import SETTINGS_BY_NAME

MODE, EVERY = (SETTINGS_BY_NAME[name].key for name in ("imu.mode", "imu.every"))
BASE = ((40, -20, 4100), (30, -10, 5))  # at +-8 g and +-250 deg/s, not excited


class PlayedImu(FakeImu):
    """record : a Record at 500 Hz, played once from the start; then its last sample, with noise.
    answers : (acc, gyro) counts that excitement adds;  trim : registers 0x0D to 0x10.
    shakes : counts of noise while it tests itself;  ends : it falls silent with the record.
    values : gives the settings by key;  loops : the record begins anew where it ends.
    """

    def __init__(self, record, *, fields=None, answers=None, trim=(0, 0, 0, 0), **how):
        super().__init__(mag_every=0 if fields is None else 5)
        self.record, self.fields = record, fields
        self.answers, self.trim = answers or ((0, 0, 0), (0, 0, 0)), trim
        self.shakes, self.ends = how.pop("shakes", 6), how.pop("ends", False)
        self.identity = how.pop("identity", self.identity)
        self.loops = how.pop("loops", False)
        self.values = how.pop("values", lambda: {MODE: 1, EVERY: 1})

    def sample(self, *, lost=0):
        at, self.number = self.number, self.number + 1
        every = self.values()[EVERY]
        if self.number % every or (self.ends and at >= len(self.record)):
            return []
        acc, gyro = self._raw(at)
        told = []
        if self.fields is not None and self.number % (every * 2) == 0:
            told.append(Mag(self.number % 65536, *self.fields[at % len(self.fields)]))
        return [*told, Imu(self.number % 65536, *acc, -11_000, *gyro)]

    def _raw(self, at):
        mode = self.values()[MODE]
        if mode in (MODES["hz_500"], MODES["hz_1000"]):
            if self.loops:
                at %= len(self.record)
            elif at >= len(self.record):
                at = len(self.record) - 1 - at % 500
            record = self.record
            return record.acc_b_counts[at].tolist(), record.gyro_b_counts[at].tolist()
        if mode == MODES["trim"]:
            x, y, z, a = self.trim
            words = [
                value - 65536 if value > 32767 else value for value in (x << 8 | y, z << 8 | a)
            ]
            return [*words, 7], [at % 5] * 3
        on = mode == MODES["self_test_on"]
        return [
            [
                round(base + on * more + self._noise.gauss(0, self.shakes))
                for base, more in zip(bases, answer, strict=True)
            ]
            for bases, answer in zip(BASE, self.answers, strict=True)
        ]


def bench_of(record=None, **how):
    """A Bench whose IMU plays a sitting and obeys imu.mode and imu.every."""
    played = PlayedImu(record if record is not None else sitting(), **how)
    bench = Bench(imu=lambda: played)
    played.values = lambda: bench.chain.values
    return bench


def fill_line(bench):
    """Every sample is streamed on a slow line: answers find no room until that is over."""
    filling = StreamFlag.ATTITUDE | StreamFlag.IMU
    bench.chain.values[EVERY] = 1
    bench.lose = lambda name: bool(
        name != "SetStream" and bench.chain.mask & filling and bench.chain.values[EVERY] == 1
    )
    return bench


def sitting(seed=1, ups=(*FACES, *SLANTS)):
    """A Record at 500 Hz."""
    return Board(seed, rate_hz=500.0).sitting(list(ups))
