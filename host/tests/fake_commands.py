# SPDX-License-Identifier: MIT
"""The test double's answers to commands: settings by key, EEPROM, calibration, zero and tare."""

from dataclasses import dataclass, field

from terazi.cshared import ScaleRefusedError, ScaleStatus
from terazi.link.generated import messages as wire
from terazi.link.generated.messages import Ack, Point, Result, SettingsState
from terazi.link.generated.settings import SETTINGS

WRITING_US = 600_000  # 175 bytes of 3.4 ms
POINTS_MAX = 8
RESULT_OF = {
    ScaleStatus.OK: Result.OK,
    ScaleStatus.BAD_COUNT: Result.TOO_FEW_POINTS,
    ScaleStatus.BAD_POINT: Result.OUT_OF_RANGE,
    ScaleStatus.NOT_MONOTONE: Result.NOT_MONOTONE,
    ScaleStatus.TOO_STEEP: Result.TOO_STEEP,
    ScaleStatus.NOT_STABLE: Result.NOT_STABLE,
    ScaleStatus.OUT_OF_RANGE: Result.OUT_OF_RANGE,
    ScaleStatus.TOO_LIGHT: Result.TOO_LIGHT,
    ScaleStatus.UNKNOWN: Result.OUT_OF_RANGE,
}
IN_CALIBRATION = (
    wire.Tare,
    wire.TareClear,
    wire.Zero,
    wire.CountPieces,
    wire.SetSetting,
    wire.ResetSettings,
    wire.ResetCounts,
)
SCALE_FIELDS = {
    f"scale.{name}"
    for name in (
        "max_mg",
        "interval_mg",
        "under_mg",
        "step_mg",
        "stable_band_mg",
        "stable_us",
        "gap_us",
        "unit",
        "decimals",
        "digit",
        "hysteresis_q8",
        "options",
    )
}


@dataclass
class Eeprom:
    """What outlives a reset: settings by key; points; how often it was written."""

    values: dict[int, int] = field(default_factory=dict)
    config: dict | None = None
    sequence: int = 0
    is_worn: bool = False  # what is written does not read back


class Refused(Exception):
    """A command's result, where it is not OK."""

    def __init__(self, result: Result) -> None:
        self.result = result


class Commands:
    """Mixed into Chain. `staged` is None, or the points of a calibration under way."""

    def __init__(self) -> None:
        self.eeprom = Eeprom()
        self.values = {one.key: one.default for one in SETTINGS}
        self.staged: list[Point] | None = None
        self.mask = wire.StreamFlag(31)
        self.text_modes: list[int] = []  # as they were asked for; it has frames only
        self._told_flags = None
        self._written_us: int | None = None
        self._failed = False

    def start(self, eeprom: Eeprom) -> None:
        """As after a reset: what the EEPROM holds is taken over."""
        self.eeprom = eeprom
        self.values |= eeprom.values
        if eeprom.config is not None:
            self.calibrate(eeprom.config)

    @property
    def settings_state(self) -> SettingsState:
        if self._written_us is not None and self.device_us < self._written_us:
            return SettingsState.WRITING
        return SettingsState.FAILED if self._failed else SettingsState.IDLE

    def answer(self, frame, *, mask: list[int] | None = None) -> bytes:
        """The frames that answer a command; mask: told there, too."""
        kind = wire.MESSAGES_BY_ID.get(frame.id)
        told: list = []
        result = Result.OK
        try:
            does = getattr(self, f"_{kind.NAME}", None) if kind else None
            if does is None:
                raise Refused(Result.UNKNOWN_COMMAND)
            if len(frame.payload) != kind.LEN:
                raise Refused(Result.WRONG_LENGTH)
            try:
                command = kind.unpack(frame.payload)
            except ValueError:
                raise Refused(Result.OUT_OF_RANGE) from None
            if self.staged is not None and isinstance(command, IN_CALIBRATION):
                raise Refused(Result.CALIBRATING)
            told = does(command) or []
        except Refused as refused:
            result = refused.result
        except ScaleRefusedError as refused:
            result = RESULT_OF.get(refused.status, Result.CONTRADICTS)
        if mask is not None:
            mask[0] = self.mask
        ack = Ack(command=frame.id, command_sequence=frame.sequence, result=result)
        return b"".join(self.frame(message) for message in (ack, *told))

    # One method a command, named as the wire names it.

    def _get_info(self, _command):
        return [self.hello(), *self.health()]

    def _set_stream(self, command):
        self.mask = command.mask

    def _set_text_mode(self, command):
        self.text_modes.append(command.on)

    def _tare(self, _command):
        self.scale.tare()
        self._save()

    def _tare_clear(self, _command):
        self.scale.tare_clear()
        self._save()

    def _zero(self, _command):
        self.scale.zero()
        self._save()

    def _show(self, command):
        self.scale.show(command.view)

    def _count_pieces(self, command):
        self.scale.count_out(command.pieces)

    def _calibrate_begin(self, _command):
        if self.staged is not None:
            raise Refused(Result.CALIBRATING)
        self.staged = []

    def _calibrate_point(self, command):
        self._want_calibration()
        if not self.is_stable:
            raise Refused(Result.NOT_STABLE)
        return self._stage(self.last_counts_q7, command.mass_mg)

    def _calibrate_known(self, command):
        self._want_calibration()
        return self._stage(command.counts_q7, command.mass_mg)

    def _calibrate_end(self, _command):
        self._want_calibration()
        if len(self.staged) < 2:
            raise Refused(Result.TOO_FEW_POINTS)
        self._want_ready()
        spare = [0] * (POINTS_MAX - len(self.staged))
        self.calibrate(
            self.config
            | {
                "points": len(self.staged),
                "point_counts_q7": [one.counts_q7 for one in self.staged] + spare,
                "point_mass_mg": [one.mass_mg for one in self.staged] + spare,
            }
        )
        self.staged = None
        self._save()

    def _calibrate_abort(self, _command):
        self._want_calibration()
        self.staged = None

    def _get_point(self, command):
        points = self.points if self.staged is None else self.staged
        if command.index >= len(points):
            raise Refused(Result.NOTHING_THERE)
        return [points[command.index]]

    def _get_setting(self, command):
        if command.key >= len(SETTINGS):
            raise Refused(Result.NOTHING_THERE)
        return [wire.Setting(command.key, self._value(SETTINGS[command.key]))]

    def _set_setting(self, command):
        if command.key >= len(SETTINGS):
            raise Refused(Result.NOTHING_THERE)
        setting = SETTINGS[command.key]
        if setting.by:
            raise Refused(Result.WRITE_PROTECTED)
        if not setting.minimum <= command.value <= setting.maximum:
            raise Refused(Result.OUT_OF_RANGE)
        self._put(setting, command.value)
        return [wire.Setting(command.key, command.value)]

    def _save_settings(self, _command):
        self._want_ready()
        self._save()

    def _reset_settings(self, command):
        points = {key: self.config[key] for key in ("points", "point_counts_q7", "point_mass_mg")}
        from terazi.design import scale as scale_design

        keep = {} if command.what == wire.ResetWhat.EVERYTHING else points
        self.values = {one.key: one.default for one in SETTINGS}
        self.calibrate(scale_design.config() | keep)
        self.order, self.kf_kind = wire.ChainOrder.FIR_KF, wire.KfKind.ADAPTIVE
        self._save()

    # What they share.

    def _want_calibration(self) -> None:
        if self.staged is None:
            raise Refused(Result.NOT_CALIBRATING)

    def _want_ready(self) -> None:
        if self.settings_state == SettingsState.WRITING:
            raise Refused(Result.BUSY)

    def _stage(self, counts_q7: int, mass_mg: int) -> list[Point]:
        kept = [one for one in self.staged if one.mass_mg != mass_mg]
        if len(kept) == POINTS_MAX:
            raise Refused(Result.TOO_MANY_POINTS)
        pairs = sorted([*((one.mass_mg, one.counts_q7) for one in kept), (mass_mg, counts_q7)])
        self.staged = [Point(at, counts, mass) for at, (mass, counts) in enumerate(pairs)]
        return [next(one for one in self.staged if one.mass_mg == mass_mg)]

    def _value(self, setting) -> int:
        name = setting.full_name
        if name in SCALE_FIELDS:
            return self.config[setting.name]
        if name == "calibration.points":
            return self.config["points"]
        if setting.group == "calibration" and setting.name.startswith("point_"):
            column, _, index = setting.name.rpartition("_")
            return self.config[column][int(index)]
        if name == "calibration.zero_mg":
            return self.scale.zero_mg
        if name == "calibration.tare_mg":
            return self.scale.tare_mg
        return self.values[setting.key]

    def _put(self, setting, value: int) -> None:
        if setting.full_name in SCALE_FIELDS:
            try:
                self.calibrate(self.config | {setting.name: value})
            except ScaleRefusedError:
                raise Refused(Result.CONTRADICTS) from None
            return
        changed = self.values[setting.key] != value
        self.values[setting.key] = value
        if changed and self.imu and setting.full_name in ("imu.mode", "imu.zupt"):
            self.imu.begin_anew()
        if setting.full_name == "chain.order":
            self.order = wire.ChainOrder(value)
            self.prime()

    def _save(self) -> None:
        self._written_us = self.device_us + WRITING_US
        self._failed = self.eeprom.is_worn
        if not self._failed:
            self.eeprom.values = dict(self.values)
            self.eeprom.config = dict(self.config)
            self.eeprom.sequence += 1
