# SPDX-License-Identifier: MIT
"""Settings as TOML, both ways, and every way in which a file can be wrong."""

import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from terazi.errors import CannotRead
from terazi.link.generated.messages import Point
from terazi.link.generated.settings import SETTING_GROUPS, SETTINGS
from terazi.settings import SettingsFile, parse_settings, read_settings_file, render_settings
from terazi.settings.text import points_of

FACTORY = {one.full_name: one.default for one in SETTINGS}
WRITABLE = [one for one in SETTINGS if not one.by]
CALIBRATION = "[calibration]\n"


def lawful(setting):
    """Values that this setting can hold."""
    if setting.choices and not setting.is_flags:
        return st.sampled_from([value for _name, value in setting.choices])
    return st.integers(setting.minimum, setting.maximum)


@st.composite
def held(draw):
    """All values of a device: its points rise in mass, as a calibration's do."""
    values = draw(st.fixed_dictionaries({one.full_name: lawful(one) for one in SETTINGS}))
    count = values["calibration.points"]
    limit = 500_000_000
    masses = draw(st.lists(st.integers(-limit, limit), min_size=count, max_size=count, unique=True))
    values |= {f"calibration.point_mass_mg_{at}": mass for at, mass in enumerate(sorted(masses))}
    return values


@given(values=held(), heading=st.lists(st.text(), max_size=3))
def test_what_is_written_is_read_back(values, heading):
    file = parse_settings(render_settings(values, heading), "a file")
    assert file.settings == {one.full_name: values[one.full_name] for one in WRITABLE}
    assert file.points == points_of(values)


@given(values=held())
def test_what_is_written_is_toml_with_a_table_a_group_and_a_comment_a_setting(values):
    text = render_settings(values)
    content = tomllib.loads(text)
    assert list(content) == [group for group, _summary in SETTING_GROUPS]
    for setting in SETTINGS:
        if setting.by != "calibration":
            assert f"# {setting.summary}" in text
    assert f"# zero_mg = {values['calibration.zero_mg']} " in text


@given(text=st.text())
def test_any_text_is_read_or_refused_by_name(text):
    refused = None
    try:
        assert parse_settings(text, "a file") == SettingsFile()  # chance names no setting
    except CannotRead as error:
        refused = error
    assert refused is None or (str(refused).startswith("a file") and refused.remedy)


def test_a_file_may_hold_some_settings_only():
    file = parse_settings("[scale]\nmax_mg = 3000000\n[chain]\ngain = 'b_32'\n", "a file")
    assert file == SettingsFile({"scale.max_mg": 3_000_000, "chain.gain": 2}, None)
    assert parse_settings("", "an empty one") == SettingsFile()


def test_flags_and_truths_are_written_as_such():
    text = render_settings(FACTORY | {"scale.options": 2, "checkweigher.on": 1})
    content = tomllib.loads(text)
    assert content["scale"]["options"] == ["track_zero"]
    assert content["checkweigher"]["on"] is True
    assert content["scale"]["unit"] == "g"


WRONG = [
    ("[scale", "a file is no TOML", "export"),
    ("[scales]\n", "scales is no group that this host knows", "Did you mean scale?"),
    ("max_mg = 5\n", "max_mg is no group", "It belongs under [scale]"),
    ("scale = 5\n", "scale is no table", "[scale]"),
    ("[scale]\nmax_g = 5\n", "scale.max_g is no setting", "Did you mean scale.max_mg?"),
    ("[scale]\nmax_mg = 5.0\n", "scale.max_mg is a number with a point", "whole number"),
    ("[scale]\nmax_mg = true\n", "scale.max_mg is a truth value", "whole number"),
    ("[scale]\nmax_mg = 'much'\n", "scale.max_mg is a text", "whole number"),
    ("[scale]\nmax_mg = 0\n", "scale.max_mg = 0 is out of range", "1 and 500000000"),
    ("[scale]\nmax_mg = 500000001\n", "is out of range", "1 and 500000000"),
    ("[scale]\nmax_mg = 99999999999999999999\n", "is out of range", "1 and 500000000"),
    ("[scale]\nunit = 'stone'\n", 'scale.unit cannot be "stone"', '"kg"'),
    ("[scale]\nunit = 1\n", "scale.unit is a whole number", '"kg"'),
    ("[scale]\noptions = 'track_zero'\n", "scale.options is a text", "list"),
    ("[scale]\noptions = [1]\n", "scale.options is a list", "list"),
    ("[scale]\noptions = ['track_zero', 'track_zero']\n", "names one value twice", "list"),
    ("[checkweigher]\non = 1\n", "checkweigher.on is a whole number", "true or false"),
    ("[checkweigher]\non = 2000-01-01\n", "checkweigher.on is a date", "true or false"),
    (CALIBRATION + "zero_mg = 5\n", "calibration.zero_mg is the device's own", "terazi tare"),
    (CALIBRATION + "point_mass_mg_0 = 5\n", "part of the calibration's points", "points = "),
    (CALIBRATION + "points = 2\n", "is no list of 2 to 8 points", "counts_q7"),
    (CALIBRATION + "points = [{counts_q7 = 1, mass_mg = 2}]\n", "is no list of 2 to 8", "2 to 8"),
    (CALIBRATION + "points = [1, 2]\n", "calibration.points[0] is no point", "counts_q7"),
    (
        CALIBRATION + "points = [{counts_q7 = 1, mass_mg = 2}, {counts_q7 = 1}]\n",
        "calibration.points[1] is no point",
        "mass_mg",
    ),
    (
        CALIBRATION + "points = [{counts_q7 = 1, mass_mg = 2}, {counts_q7 = 2, mass_mg = 2.5}]\n",
        "calibration.points[1].mass_mg is a number with a point",
        "whole",
    ),
    (
        CALIBRATION
        + "points = [{counts_q7 = 1, mass_mg = 2}, {counts_q7 = 2000000000, mass_mg = 3}]\n",
        "calibration.points[1].counts_q7 = 2000000000 is out of range",
        "1073741824",
    ),
    (
        CALIBRATION + "points = [{counts_q7 = 1, mass_mg = 2}, {counts_q7 = 2, mass_mg = 2}]\n",
        "not in the order of their masses",
        "greater",
    ),
]


@pytest.mark.parametrize(
    ("text", "reason", "remedy"), WRONG, ids=[reason for _, reason, _ in WRONG]
)
def test_a_wrong_file_is_refused_with_file_key_reason_and_remedy(tmp_path, text, reason, remedy):
    path = tmp_path / "scale.toml"
    path.write_text(text)
    with pytest.raises(CannotRead) as refused:
        read_settings_file(path)
    assert str(refused.value).startswith(str(path))
    assert reason.removeprefix("a file ") in str(refused.value)
    assert remedy in refused.value.remedy


def test_a_file_that_is_not_there_or_no_text_is_refused_by_name(tmp_path):
    with pytest.raises(CannotRead, match="No such file"):
        read_settings_file(tmp_path / "none.toml")
    with pytest.raises(CannotRead, match="cannot read"):
        read_settings_file(tmp_path)
    (tmp_path / "picture.toml").write_bytes(b"\x89PNG\xff")
    with pytest.raises(CannotRead, match="is no text"):
        read_settings_file(tmp_path / "picture.toml")


def test_points_are_numbered_as_they_stand():
    points = "points = [{counts_q7 = 9, mass_mg = 0}, {counts_q7 = -1, mass_mg = 1}]"
    file = parse_settings(CALIBRATION + points, "a file")
    assert file.points == (Point(0, 9, 0), Point(1, -1, 1))
