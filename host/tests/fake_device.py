# SPDX-License-Identifier: MIT
"""A test double: something on a pseudo-terminal that speaks the true protocol, and can misbehave.

It is no firmware and knows no converter; the genuine firmware runs on the bench (hil_tests). It
resets when its port is opened, as an Uno does, and runs faster than time: no test need wait.
"""

import dataclasses
import os
import random
import select
import threading
import time
import tty
from collections.abc import Callable

from terazi.cshared import (
    Fir,
    FrameDecoder,
    Scale,
    ScaleRefusedError,
    WeightKf,
    WeightKfAdaptive,
    encode_frame,
)
from terazi.design import scale as scale_design
from terazi.link.generated.messages import (
    FINGERPRINT,
    Ack,
    ChainOrder,
    ConverterState,
    GetInfo,
    GetPoint,
    Hello,
    KfKind,
    Point,
    ResetCause,
    Result,
    Sample,
    SampleFlag,
    SetStream,
    SetTextMode,
    Status,
    StreamFlag,
    Tare,
)
from terazi.units import COUNTS_RAIL_HIGH, COUNTS_RAIL_LOW

RATE_HZ = 82.0
SLICE_S = 0.002
BOOT_S = 0.05


def steps_and_noise(t_s: float) -> int:
    """A load that is put on at 2 s and taken off at 6 s, with noise from a fixed seed."""
    noise = random.Random(round(t_s * 1e6)).gauss(0.0, 40.0)
    load_counts = 214_775 if 2.0 <= t_s % 8.0 < 6.0 else 0  # 500 g
    return 84_000 + load_counts + round(noise)


class Chain:
    """What the device makes of a conversion: FIR, Kalman, scale; and the frames of it."""

    def __init__(self, load: Callable[[float], int] = steps_and_noise) -> None:
        self.load = load
        self.fingerprint = FINGERPRINT
        self.sequence = 0
        self.conversion = 0
        self.samples = 0
        self.device_us = 0
        self.state = ConverterState.RUNNING
        self._fir: Fir | None = None
        self._kf: WeightKf | WeightKfAdaptive | None = None
        self.order, self.kf_kind = ChainOrder.FIR_KF, KfKind.CONSTANT
        self.calibrate(scale_design.config())

    def frame(self, message, device_us: int | None = None) -> bytes:
        """The frame of a message, numbered."""
        sequence, self.sequence = self.sequence, (self.sequence + 1) % 256
        us = self.device_us if device_us is None else device_us
        return encode_frame(message.ID, sequence, us % (1 << 32), message.pack())

    def hello(self) -> Hello:
        return Hello(
            protocol_fingerprint=self.fingerprint,
            version_major=0,
            version_minor=1,
            version_patch=0,
            build=0x1234ABCD,
            reset_cause=ResetCause.EXTERNAL,
            gain=128,
            fir_design=0,
            fir_taps=32,
            kf_schedule=0,
            converter_rate_hz_q16=0,
            chain_order=self.order,
            kf_kind=self.kf_kind,
        )

    def calibrate(self, config: dict) -> None:
        """Weigh by another configuration (scale.h)."""
        columns = (config["point_counts_q7"], config["point_mass_mg"])
        pairs = list(zip(*columns, strict=True))[: config["points"]]
        self.points = [
            Point(at, counts_q7, mass_mg) for at, (counts_q7, mass_mg) in enumerate(pairs)
        ]
        self._scale = Scale(config)

    def status(self) -> Status:
        fields = {field.name: 0 for field in dataclasses.fields(Status)}
        fields |= {
            "uptime_s": self.device_us // 1_000_000,
            "converter_state": self.state,
            "converter_rate_hz_q16": round(RATE_HZ * 65536),
            "conversions": self.conversion,
            "stack_free_bytes": 1200,
            "cpu_busy_permille": 21,
        }
        return Status(**fields)

    def sample(self, *, restart: bool = False, skip: int = 0) -> Sample:
        """The next conversion; restart primes the filters anew, skip loses some before it."""
        self.conversion += 1 + skip
        raw = self.load(self.conversion / RATE_HZ)
        self.device_us = round(self.conversion / RATE_HZ * 1e6)
        flags = SampleFlag.GAP if skip else SampleFlag(0)
        if raw in (COUNTS_RAIL_LOW, COUNTS_RAIL_HIGH):
            flags |= SampleFlag.AT_RAIL
        restart = restart or self._fir is None
        if restart:
            flags |= SampleFlag.RESTARTED
        if self.order == ChainOrder.FIR_KF:
            fir = self._run_fir(raw, restart)
            kf_q7 = last_q7 = self._run_kf(fir, restart)
        else:
            kf_q7 = self._run_kf(raw, restart)
            fir = self._run_fir((kf_q7 + 64) >> 7, restart)
            last_q7 = fir * 128
        self.samples += 1
        weight_flags = self._scale.update(last_q7, self.device_us % (1 << 32))
        return Sample(
            conversion=self.conversion % 65536,
            raw_counts=raw,
            fir_counts=fir,
            kf_counts_q7=kf_q7,
            mass_mg=self._scale.mass_mg,
            net_mg=self._scale.net_mg,
            flags=flags,
            weight_flags=int(weight_flags),
        )

    def _run_fir(self, counts: int, restart: bool) -> int:
        if restart:
            self._fir = Fir("lowpass32", counts)
        return self._fir.update(counts)

    def _run_kf(self, counts: int, restart: bool) -> int:
        if restart:
            kind = WeightKfAdaptive if self.kf_kind == KfKind.ADAPTIVE else WeightKf
            self._kf = kind("default", counts)
        return self._kf.update(counts)

    def fall_silent(self) -> None:
        """Time goes on by one conversion, but the converter has none."""
        self.state = ConverterState.TIMED_OUT
        self.conversion += 1
        self.device_us = round(self.conversion / RATE_HZ * 1e6)

    def answer(self, frame, *, mask: list[int]) -> bytes:
        """The frames that answer a command."""
        result = Result.OK
        told = b""
        if frame.id == Tare.ID:
            result = self._tare()
        elif frame.id == GetPoint.ID:
            index = GetPoint.unpack(frame.payload).index
            if index < len(self.points):
                told = self.frame(self.points[index])
            else:
                result = Result.NOTHING_THERE
        elif frame.id == SetStream.ID:
            mask[0] = SetStream.unpack(frame.payload).mask
        elif frame.id not in (GetInfo.ID, SetTextMode.ID):
            result = Result.UNKNOWN_COMMAND
        answer = self.frame(Ack(command=frame.id, command_sequence=frame.sequence, result=result))
        if frame.id == GetInfo.ID:
            told = self.frame(self.hello()) + self.frame(self.status())
        return answer + told

    def _tare(self) -> Result:
        try:
            self._scale.tare()
        except ScaleRefusedError as refused:
            return Result[refused.status.name]
        return Result.OK


class FakeDevice:
    """A chain on a pseudo-terminal, in a thread of its own. Use it as a context manager."""

    def __init__(
        self,
        *,
        speed: float = 20.0,
        load: Callable[[float], int] = steps_and_noise,
        fingerprint: int = FINGERPRINT,
        speak: str = "frames",  # or "nothing", "garbage", "other" (bytes that are no frames)
        hello_at_reset: bool = True,
        answers: bool = True,
        ignore_commands: int = 0,
        vanish_after: int | None = None,  # samples
        silent_after: int | None = None,  # samples; then only STATUS, converter timed out
        lose: frozenset[int] = frozenset(),  # frames of these samples never leave
        corrupt: frozenset[int] = frozenset(),  # frames of these samples arrive broken
        noise_before: frozenset[int] = frozenset(),  # stray bytes on the line before these
        restart_at: frozenset[int] = frozenset(),  # samples at which the filters start anew
    ) -> None:
        self.speed = speed
        self.load = load
        self.fingerprint = fingerprint
        self.speak = speak
        self.hello_at_reset = hello_at_reset
        self.answers = answers
        self.ignore_commands = ignore_commands
        self.vanish_after = vanish_after
        self.silent_after = silent_after
        self.lose, self.corrupt, self.restart_at = lose, corrupt, restart_at
        self.noise_before = noise_before
        self.resets = 0
        self.commands: list[int] = []
        self._garbage = random.Random(7)
        self._master, slave = os.openpty()
        tty.setraw(slave)
        self.path = os.ttyname(slave)
        os.close(slave)
        os.set_blocking(self._master, False)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> "FakeDevice":
        self._thread.start()
        return self

    def __exit__(self, *_exception) -> None:
        self._stop.set()
        self._thread.join()
        self._vanish()

    def _vanish(self) -> None:
        if self._master >= 0:
            os.close(self._master)
            self._master = -1

    def _run(self) -> None:
        poll = select.poll()
        poll.register(self._master, select.POLLIN)
        is_open = False
        while not self._stop.is_set():
            events = poll.poll(0)
            if events and events[0][1] & select.POLLHUP:
                is_open = False
                time.sleep(SLICE_S)
                continue
            if not is_open:
                is_open = True
                self._reset()
            if events:
                self._take(os.read(self._master, 4096))
            self._say()
            if self.vanish_after is not None and self.chain.samples >= self.vanish_after:
                time.sleep(0.1)  # what the host has not read by then goes down with the port
                self._vanish()
                return
            time.sleep(SLICE_S)

    def _reset(self) -> None:
        self.resets += 1
        self.chain = Chain(self.load)
        self.chain.fingerprint = self.fingerprint
        self._decoder = FrameDecoder()
        self._mask = [int(StreamFlag.SAMPLE | StreamFlag.STATUS)]
        self._statuses = 0
        time.sleep(BOOT_S)  # whoever opens a port discards what is stale in it, at once
        self._begin_s = time.monotonic()
        if self.speak == "frames" and self.hello_at_reset:
            self._send(self.chain.frame(self.chain.hello()))

    def _take(self, data: bytes) -> None:
        for frame in self._decoder.feed(data):
            self.commands.append(frame.id)
            if self.ignore_commands:
                self.ignore_commands -= 1
            elif self.answers and self.speak == "frames":
                self._send(self.chain.answer(frame, mask=self._mask))

    def _say(self) -> None:
        if self.speak == "garbage":
            self._send(self._garbage.randbytes(20))
        elif self.speak == "other":
            self._send(b"some other sketch\r\n")
        if self.speak != "frames":
            return
        now_s = (time.monotonic() - self._begin_s) * self.speed
        while (self.chain.conversion + 1) / RATE_HZ <= now_s:
            if self.vanish_after is not None and self.chain.samples >= self.vanish_after:
                return
            if self.silent_after is not None and self.chain.samples >= self.silent_after:
                self.chain.fall_silent()
            else:
                self._send_sample()
            if self.chain.device_us // 1_000_000 > self._statuses:
                self._statuses += 1
                if self._mask[0] & StreamFlag.STATUS:
                    self._send(self.chain.frame(self.chain.status()))

    def _send_sample(self) -> None:
        index = self.chain.samples
        wire = self.chain.frame(self.chain.sample(restart=index in self.restart_at))
        if index in self.lose or not self._mask[0] & StreamFlag.SAMPLE:
            return
        if index in self.corrupt:
            wire = wire[:1] + bytes([wire[1] ^ 0x40 or 0x41]) + wire[2:]
        if index in self.noise_before:
            wire = self._garbage.randbytes(40) + b"\0" + wire
        self._send(wire)

    def _send(self, data: bytes) -> None:
        while data and not self._stop.is_set():
            try:
                data = data[os.write(self._master, data) :]
            except BlockingIOError:  # the host is slow: wait, never drop
                time.sleep(SLICE_S)
            except OSError:
                return
