# SPDX-License-Identifier: MIT
"""Settings of the device by name, a few or many at once: all of a change holds, or none of it."""

from collections.abc import Iterable, Mapping

from terazi.errors import CommandRefused
from terazi.link import Link
from terazi.link.generated.messages import GetSetting, Result, SetSetting
from terazi.link.generated.messages import Setting as SettingMessage
from terazi.link.generated.settings import SETTINGS_BY_NAME


def read_settings(link: Link, names: Iterable[str]) -> dict[str, int]:
    """Values by name, as the device has them."""
    return {name: _read(link, SETTINGS_BY_NAME[name].key) for name in names}


def apply_settings(link: Link, wanted: Mapping[str, int]) -> dict[str, int]:
    """Set values, not saved yet; gives those of before, of what differed.

    The device checks after each one whether all go together, so that the order matters: what is
    refused for that is tried again after the others. If some stay refused, or the device says no
    for another reason, everything is put back. Raises CommandRefused, which names the setting.
    """
    before = read_settings(link, wanted)
    left = {name: value for name, value in wanted.items() if value != before[name]}
    changed = dict.fromkeys(left)
    try:
        _settle(link, left)
    except CommandRefused:
        _settle(link, {name: before[name] for name in changed})
        raise
    return {name: before[name] for name in changed}


def _settle(link: Link, wanted: Mapping[str, int]) -> None:
    """Set values in any order that the device takes."""
    left = dict(wanted)
    while left:
        refused = {}
        for name, value in left.items():
            try:
                _write(link, SETTINGS_BY_NAME[name].key, value)
            except CommandRefused as error:
                refused[name] = error
                if error.result != Result.CONTRADICTS:
                    raise _named(error, name, value) from None
        if len(refused) == len(left):
            name, error = next(iter(refused.items()))
            raise _named(error, name, left[name]) from None
        left = {name: left[name] for name in refused}


def _named(error: CommandRefused, name: str, value: int) -> CommandRefused:
    return CommandRefused(f"{name} = {value}: {error}", remedy=error.remedy, result=error.result)


def _read(link: Link, key: int) -> int:
    return link.ask(GetSetting(key), SettingMessage, key=key).value


def _write(link: Link, key: int, value: int) -> None:
    link.ask(SetSetting(key, value), SettingMessage, key=key, value=value)
