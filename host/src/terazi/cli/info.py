# SPDX-License-Identifier: MIT
"""`terazi info`."""

import json
from typing import Annotated

import typer
from rich.table import Table
from rich.text import Text

from terazi.cli.board import board
from terazi.cli.common import (
    BAUD_DEFAULT,
    BaudOption,
    JsonOption,
    PortArgument,
    errors,
    out,
    show_rate,
    show_version,
)

# IMU_STATUS comes once a second, once an IMU was seen.
IMU_WAIT_S = 1.3
# The device knows its converter's rate after some conversions (0.2 s at 80 SPS, 2 s at 10 SPS).
RATE_WAIT_S = 3.0
SETTINGS_SHOWN = (
    "scale.max_mg",
    "scale.interval_mg",
    "scale.stable_band_mg",
    "scale.stable_us",
    "calibration.zero_mg",
    "calibration.tare_mg",
    "checkweigher.on",
    "temperature.on",
    "imu.mode",
    "imu.every",
)
# Of STATUS: what stands above zero on a healthy board, or is told in words.
NO_COUNTERS = {
    "uptime_s",
    "converter_state",
    "converter_rate_hz",
    "conversions",
    "settling_dropped",
    "stack_free_bytes",
    "cpu_busy_permille",
    "faults",
    "faults_seen",
    "settings_state",
    "settings_saved",
}


def info(
    port: PortArgument = None,
    baud: BaudOption = BAUD_DEFAULT,
    as_json: JsonOption = False,
    wait: Annotated[
        float, typer.Option(help="Seconds to wait for a measured rate.", min=0.0)
    ] = RATE_WAIT_S,
) -> None:
    """Say who is at the port, how it is, and what is wrong. Resets the board.

    Firmware, converter, filters, calibration, settings, IMU and tilt; each fault with what to do
    about it.

    [dim]Examples:[/]  terazi info      terazi info /dev/ttyACM0 --json
    """
    from terazi.control import Balance
    from terazi.control.settings import read_settings

    with board(port, baud) as link:
        port, hello = link.name, link.hello()
        balance = Balance(link)
        with errors.status("asking ..."):
            balance.quiet_stream()  # else what is asked for may find no room beside the samples
            status = _status_with_rate(link, wait)
            points = balance.points()
            settings = read_settings(link, SETTINGS_SHOWN)
            imu = _imu_status(link)
    if as_json:
        print(json.dumps(_plain(port, hello, status, points, settings, imu)))
    else:
        _show(link, status, points, settings, imu)


def _status_with_rate(link, wait_s: float):
    status = link.status()
    end_s = link.now_s() + wait_s
    while not status.converter_rate_hz_q16 and link.now_s() < end_s:
        link.poll(0.2)
        status = link.status()
    return status


def _imu_status(link):
    """The newest IMU_STATUS; None where the board has seen no IMU."""
    from terazi.link.generated.messages import ImuStatus

    found = None
    end_s = link.now_s() + IMU_WAIT_S
    while True:
        for received in link.poll(0.05):
            if isinstance(received.message, ImuStatus):
                found = received.message
        if found is not None or link.now_s() > end_s:
            return found


def _plain(port: str, hello, status, points, settings: dict[str, int], imu) -> dict:
    from terazi.control import faults, inertial
    from terazi.link.plain import plain_message

    return {
        "port": port,
        "hello": plain_message(hello),
        "status": plain_message(status),
        "faults": faults.names(status.faults),
        "faults_seen": faults.names(status.faults_seen),
        "points": [{"counts_q7": point.counts_q7, "mass_mg": point.mass_mg} for point in points],
        "settings": settings,
        "imu": None if imu is None else plain_message(imu) | {"tilt_deg": inertial.tilt_deg(imu)},
    }


def _show(link, status, points, settings: dict[str, int], imu) -> None:
    hello, line = link.hello(), f" ({link.baud} baud)" if link.baud else ""
    table = Table.grid(padding=(0, 2))
    table.add_column(style="dim", no_wrap=True)
    table.add_column(overflow="fold")
    table.add_row("device", f"Terazi {show_version(hello)} at {link.name}{line}")
    table.add_row("", f"protocol 0x{hello.protocol_fingerprint:04X}, {_started(hello, status)}")
    table.add_row("converter", _converter(hello, status))
    table.add_row("filters", _filters(hello))
    for name, words in _scale(points, settings):
        table.add_row(name, words)
    for name, words in _imu(imu, settings):
        table.add_row(name, words)
    table.add_row("settings", _settings(status))
    table.add_row("chip", f"{_busy(status)}, {status.stack_free_bytes} bytes free")
    table.add_row("counters", _counters(status))
    for name, words in _faults(status):
        table.add_row(name, words)
    out.print(table)


def _started(hello, status) -> str:
    from terazi.units import show_duration

    cause = _words(hello.reset_cause)
    since = f"up for {show_duration(status.uptime_s)}" if status.uptime_s else "just started"
    return f"{since}, by a reset ({cause})"


def _converter(hello, status) -> str:
    state = _words(status.converter_state)
    return f"HX711 {state}, {show_rate(status.converter_rate_hz_q16)}, gain {hello.gain}"


def _filters(hello) -> str:
    from terazi.cshared import FIR_DESIGNS, WEIGHT_KF_SCHEDULES
    from terazi.link.generated.messages import ChainOrder, KfKind

    fir = f"FIR {_name(FIR_DESIGNS, hello.fir_design)} of {hello.fir_taps} taps"
    kalman = f"Kalman {_words(hello.kf_kind)}"
    if hello.kf_kind == KfKind.CONSTANT:
        kalman = f"Kalman {_name(WEIGHT_KF_SCHEDULES, hello.kf_schedule)}"
    first, then = (kalman, fir) if hello.chain_order == ChainOrder.KF_FIR else (fir, kalman)
    return f"{first}, then {then}"


def _scale(points, settings: dict[str, int]) -> list[tuple[str, str]]:
    from terazi.calibration.points import line_through, span_mg
    from terazi.control.quantities import show_mass

    max_mg, e_mg = settings["scale.max_mg"], settings["scale.interval_mg"]
    slope_mg, _origin = line_through(points)
    masses = ", ".join(show_mass(point.mass_mg, e_mg) for point in points)
    extras = [name for name in ("checkweigher", "temperature") if settings[f"{name}.on"]]
    zero_mg, tare_mg = settings["calibration.zero_mg"], settings["calibration.tare_mg"]
    band = show_mass(settings["scale.stable_band_mg"])
    rows = [
        ("scale", f"Max {show_mass(max_mg, e_mg)}, e {show_mass(e_mg, e_mg / 10)}"),
        ("", f"stable: within {band} for {settings['scale.stable_us'] / 1e6:g} s"),
        ("calibration", f"{len(points)} points: {masses}"),
        ("", f"{slope_mg * 1000:.1f} ug a count, {span_mg(points) / max_mg:.0%} of Max measured"),
        ("", f"zero {show_mass(zero_mg)}, tare {show_mass(tare_mg)}"),
    ]
    return [*rows, ("", f"{' and '.join(extras)} on")] if extras else rows


def _imu(imu, settings: dict[str, int]) -> list[tuple[str, Text | str]]:
    """The part, its rate, what went wrong, and how the board lies."""
    from terazi.control import inertial
    from terazi.control.setting_text import find_setting, show_value
    from terazi.link.generated.messages import ImuState

    mode = show_value(find_setting("imu.mode"), settings["imu.mode"])
    if imu is None:
        words = "none was seen" if settings["imu.mode"] else "switched off (imu.mode)"
        return [("IMU", words)]
    rows: list[tuple[str, Text | str]] = [("IMU", inertial.part_words(imu))]
    if warning := inertial.identity_warning(imu):
        rows.append(("", Text(warning, style="yellow")))
    every = settings["imu.every"]
    rate = f"mode {mode}, {f'one in {every} samples' if every > 1 else 'every sample'} told"
    rows.append(("", f"{inertial.magnetometer_words(imu)}; {rate}"))
    trouble = ", ".join(f"{name} {count}" for name, count in inertial.trouble(imu).items())
    style = "red" if trouble else ""
    rows.append(("", Text(f"{imu.samples} samples, {trouble or 'none lost'}", style=style)))
    if imu.state == ImuState.RUNNING:
        bias = ", ".join(f"{rate:+.2f}" for rate in inertial.bias_deg_s(imu))
        rows.append(("", f"gyroscope's bias {bias} °/s"))
        rows.append(("tilt", inertial.tilt_words(inertial.tilt_deg(imu))))
    return rows


def _settings(status) -> str:
    from terazi.link.generated.messages import SettingsState

    words = {
        SettingsState.IDLE: "saved" if status.settings_saved else "the factory's, never saved",
        SettingsState.WRITING: "being written",
        SettingsState.FAILED: "[bold red]could not be written: the EEPROM may be worn out[/]",
    }
    record = f", record {status.settings_saved}" if status.settings_saved else ""
    return words.get(status.settings_state, _words(status.settings_state)) + record


def _counters(status) -> str:
    from terazi.link.plain import plain_message

    plain = plain_message(status)
    bad = [
        f"{name.replace('_', ' ')} {value}"
        for name, value in plain.items()
        if name not in NO_COUNTERS and value
    ]
    return f"[red]{', '.join(bad)}[/]" if bad else "all at zero: nothing lost, clipped or late"


def _faults(status) -> list[tuple[str, Text | str]]:
    from terazi.control import faults

    rows: list[tuple[str, Text | str]] = []
    for name, words, remedy in faults.explained(status.faults):
        rows.append(("fault", Text(f"{name}: {words}", style="bold red")))
        rows.append(("", Text(remedy, style="yellow")))
    if not rows:
        rows.append(("faults", Text("none", style="green")))
    seen = faults.names(status.faults_seen & ~status.faults)
    if seen:
        rows.append(("", f"since the reset, and over: {', '.join(seen)}"))
    return rows


def _busy(status) -> str:
    """Of the last whole second, where there was one."""
    if not status.uptime_s:
        return "busy: not known in its first second"
    return f"{status.cpu_busy_permille / 10:.1f} % busy"


def _words(value) -> str:
    """An enumerator for people; a newer board may send a number that has no name here."""
    return value.name.lower().replace("_", " ") if hasattr(value, "name") else f"number {value}"


def _name(names: tuple[str, ...], index: int) -> str:
    return names[index] if index < len(names) else f"number {index}, unknown to this host"
