# SPDX-License-Identifier: MIT
"""What is read is what was written, in SI; what cannot be true is refused by name."""

import numpy as np
import pytest

from terazi.applications.walks import find_walks, load_walk, simulator
from terazi.errors import CannotRead, UsageError

WALK = simulator.simulate([*simulator.stand(2), *simulator.strides(4)], seed=2)
GYRO = [f"Gyroscope {axis} (deg/s)" for axis in "XYZ"]
ACC = [f"Accelerometer {axis} (g)" for axis in "XYZ"]


def npz(folder, name="walk.npz", **changed):
    fields = {"imu": np.hstack([WALK.acc_b_m_s2, WALK.gyro_b_rad_s]), "ts": WALK.t_s, **changed}
    path = folder / name
    np.savez(path, **{key: value for key, value in fields.items() if value is not None})
    return path


def csv(folder, headings, columns, name="walk.csv"):
    path = folder / name
    np.savetxt(path, columns, "%.9g", delimiter=",", header=",".join(headings), comments="")
    return path


def x_io(folder, t_s=WALK.t_s, acc_unit=9.80665, gyro_unit=np.pi / 180):
    columns = np.column_stack([t_s, WALK.gyro_b_rad_s / gyro_unit, WALK.acc_b_m_s2 / acc_unit])
    return csv(folder, ["Time (s)", *GYRO, *ACC], columns)


def layout(folder, text):
    path = folder / "layout.toml"
    path.write_text(text)
    return path


def test_an_npz_without_truth_is_read_as_it_is(tmp_path):
    walk = load_walk(npz(tmp_path))
    assert np.array_equal(walk.acc_b_m_s2, WALK.acc_b_m_s2)
    assert np.array_equal(walk.gyro_b_rad_s, WALK.gyro_b_rad_s)
    assert (walk.name, walk.truth, walk.rate_hz) == ("walk", None, 200.0)


def test_optical_truth_is_turned_to_the_right_hand_and_jumps_do_not_count(tmp_path):
    path = WALK.truth.pos_t_m.copy()
    path[300:] += [0.5, 0, 0]
    walk = load_walk(npz(tmp_path, gt=path * [1, -1, 1], best_detector="shoe", zv_shoe_opt=
                         WALK.zero_velocity.astype(np.uint8)))  # fmt: skip
    assert np.allclose(walk.truth.pos_t_m, path[walk.truth.at])
    missing = np.setdiff1d(np.arange(len(WALK)), walk.truth.at)
    assert missing.min() == pytest.approx(299 - 50, abs=1)
    assert missing.max() == pytest.approx(300 + 50, abs=1)
    assert np.array_equal(walk.zero_velocity, WALK.zero_velocity)


def test_footprints_are_of_the_right_hand_and_start_the_alignment(tmp_path):
    walk = load_walk(npz(tmp_path, gcp=[[0, 0], [1.0, 2.0]], stride_index=[100, 400]))
    assert walk.truth.pos_t_m.tolist() == [[0, 0], [1, -2]]
    assert walk.truth.from_start


def test_x_io_s_csv_comes_out_in_si(tmp_path):
    walk = load_walk(x_io(tmp_path))
    assert np.allclose(walk.acc_b_m_s2, WALK.acc_b_m_s2, atol=1e-5)
    assert np.allclose(walk.gyro_b_rad_s, WALK.gyro_b_rad_s, atol=1e-6)


def test_rows_of_equal_time_are_left_out_and_gaps_bridged_with_a_word_of_it(tmp_path):
    keep = np.sort(np.concatenate([np.delete(np.arange(len(WALK)), slice(500, 510)), [200, 300]]))
    columns = np.column_stack(
        [WALK.t_s, WALK.gyro_b_rad_s * 180 / np.pi, WALK.acc_b_m_s2 / 9.80665]
    )[keep]
    walk = load_walk(csv(tmp_path, ["Time (s)", *GYRO, *ACC], columns))
    assert len(walk) == len(WALK)
    assert walk.notes[0].startswith("2 rows bear the time")
    assert "1 steps of time are irregular, the longest 0.055 s at 2.5 s" in walk.notes[1]


def test_packets_have_a_rate_and_a_magnetometer(tmp_path):
    mag = [f"Magnetometer {axis} (G)" for axis in "XYZ"]
    count = np.arange(len(WALK))[:, None]
    columns = np.hstack(
        [count, WALK.gyro_b_rad_s * 180 / np.pi, WALK.acc_b_m_s2 / 9.80665, WALK.acc_b_m_s2]
    )
    path = csv(tmp_path, ["Packet number", *GYRO, *ACC, *mag], columns)
    assert load_walk(path).rate_hz == 256.0
    walk = load_walk(path, rate_hz=200.0)
    assert walk.rate_hz == 200.0
    assert np.allclose(walk.mag_b, WALK.acc_b_m_s2, atol=1e-5)


LAYOUT = """
[time]
column = "us"
unit = "us"
[acceleration]
columns = ["a", "-b", "c"]
unit = "counts"
per_unit = 2048
[rate]
columns = ["p", "q", "r"]
unit = "mdeg/s"
"""


def test_any_csv_is_read_by_a_layout_of_columns_and_units(tmp_path):
    acc = WALK.acc_b_m_s2 / 9.80665 * 2048 * [1, -1, 1]
    columns = np.column_stack([acc, WALK.t_s * 1e6, np.degrees(WALK.gyro_b_rad_s) * 1000])
    path = csv(tmp_path, ["a", "b", "c", "us", "p", "q", "r"], columns)
    walk = load_walk(path, layout=layout(tmp_path, LAYOUT))
    assert np.allclose(walk.acc_b_m_s2, WALK.acc_b_m_s2, atol=1e-4)
    assert np.allclose(walk.gyro_b_rad_s, WALK.gyro_b_rad_s, atol=1e-5)


def test_a_table_without_headings_is_read_by_numbers(tmp_path):
    path = tmp_path / "bare.csv"
    np.savetxt(path, np.hstack([WALK.acc_b_m_s2, WALK.gyro_b_rad_s]), "%.9g", delimiter=",")
    form = layout(tmp_path, 'rate_hz = 200\n[acceleration]\ncolumns = [0, 1, 2]\nunit = "m/s^2"\n'
                            '[rate]\ncolumns = [3, 4, 5]\nunit = "rad/s"\n')  # fmt: skip
    assert np.allclose(load_walk(path, layout=form).acc_b_m_s2, WALK.acc_b_m_s2)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[rate]\n", r"lacks \[acceleration\]"),
        (LAYOUT.replace("[time]", "[clock]"), "does not know 'clock'"),
        (LAYOUT.replace('"mdeg/s"', '"rpm"'), r"\[rate\] has no unit 'rpm'"),
        (LAYOUT.replace('"a", ', ""), "must name three columns, not 2"),
        (LAYOUT.replace("per_unit = 2048", ""), "needs per_unit"),
        (LAYOUT.replace('unit = "us"', 'unit = "h"'), "time has no unit 'h'"),
        (LAYOUT.partition("[acceleration]")[0][:0] + LAYOUT[LAYOUT.index("[acc"):], "needs"),
    ],
)  # fmt: skip
def test_a_wrong_layout_is_refused_with_what_is_wrong(tmp_path, text, words):
    columns = np.column_stack([WALK.acc_b_m_s2, WALK.t_s * 1e6, WALK.gyro_b_rad_s])
    path = csv(tmp_path, ["a", "b", "c", "us", "p", "q", "r"], columns)
    with pytest.raises(UsageError, match=words):
        load_walk(path, layout=layout(tmp_path, text))


@pytest.mark.parametrize(
    ("scales", "words"),
    [
        ({"acc_unit": 1.0}, "9[5-7].* m/s\\^2, not 9.81"),
        ({"acc_unit": 9.80665**2}, "is (0.99|1).* m/s\\^2, not 9.81"),
        ({"gyro_unit": 1.0}, "acceleration walks, but it turns"),
        ({"gyro_unit": (np.pi / 180) ** 2}, "no foot does"),
        ({"t_s": WALK.t_s * 1000}, "0.2 samples a second"),
        ({"t_s": WALK.t_s / 1000}, "200000 samples a second"),
    ],
)
def test_wrong_units_are_told_by_name(tmp_path, scales, words):
    with pytest.raises(CannotRead, match=words) as refused:
        load_walk(x_io(tmp_path, **scales))
    assert refused.value.remedy


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"imu": None}, "lacks imu"),
        ({"ts": WALK.t_s[:-1]}, "rows of imu, but"),
        ({"imu": np.zeros((9, 5))}, r"imu has the shape \(9, 5\)"),
        ({"ts": WALK.t_s[::-1]}, "run backwards"),
        ({"ts": np.round(WALK.t_s, 1)}, "does not always grow"),
        ({"gcp": [[0, 0]], "stride_index": [99999]}, "stride_index does not name"),
        (
            {"imu": np.full((len(WALK), 6), np.nan)},
            f"no number in {len(WALK)} rows, first in row 1",
        ),
        ({"imu": np.zeros((0, 6)), "ts": np.zeros(0)}, "holds 0 samples"),
        ({"imu": np.tile([0, 0, 9.81, 0, 0, 0], (len(WALK), 1))}, "every sample is the same"),
    ],
)
def test_a_wrong_npz_is_refused_with_what_is_wrong(tmp_path, changed, words):
    with pytest.raises(CannotRead, match=words):
        load_walk(npz(tmp_path, **changed))


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_a_damaged_npz_is_refused_wherever_the_damage_is(tmp_path, save):
    whole = tmp_path / "whole.npz"
    save(whole, imu=np.hstack([WALK.acc_b_m_s2, WALK.gyro_b_rad_s]), ts=WALK.t_s)
    data, path = whole.read_bytes(), tmp_path / "x.npz"
    load_walk(whole)
    for at in range(0, len(data), len(data) // 20):
        path.write_bytes(data[:at])
        with pytest.raises(CannotRead, match=r"x\.npz"):
            load_walk(path)
    for at in range(200, len(data) // 2, len(data) // 20):
        path.write_bytes(data[:at] + bytes(50) + data[at + 50 :])
        with pytest.raises(CannotRead, match=r"x\.npz"):
            load_walk(path)


def test_what_else_an_npz_holds_does_not_matter(tmp_path):
    odd = np.array([{"a": 1}], dtype=object)
    assert len(load_walk(npz(tmp_path, note=odd, who="somebody"))) == len(WALK)


def test_optical_truth_that_was_never_seen_is_none(tmp_path):
    assert load_walk(npz(tmp_path, gt=np.full((len(WALK), 3), np.nan))).truth is None


def test_a_gap_in_an_npz_is_told(tmp_path):
    keep = np.delete(np.arange(len(WALK)), slice(600, 700))
    imu = np.hstack([WALK.acc_b_m_s2, WALK.gyro_b_rad_s])[keep]
    walk = load_walk(npz(tmp_path, imu=imu, ts=WALK.t_s[keep]))
    assert walk.notes == (
        "gaps of the times: 1, the longest 0.50 s at 3.0 s: where the foot went meanwhile is not "
        "known",
    )


def test_a_row_that_was_cut_off_is_left_out_with_a_word_of_it(tmp_path):
    path = x_io(tmp_path)
    path.write_text(path.read_text()[:-30])
    walk = load_walk(path)
    assert len(walk) == len(WALK) - 1
    assert walk.notes == ("the last row is cut off: left out",)


@pytest.mark.parametrize("between", [";", "\t"])
def test_tables_of_other_countries_are_read(tmp_path, between):
    path = x_io(tmp_path)
    text = path.read_text().replace(",", between)
    path.write_text(text.replace(".", ",") if between == ";" else text)
    assert np.allclose(load_walk(path).acc_b_m_s2, WALK.acc_b_m_s2, atol=1e-5)


def test_a_folder_is_for_score(tmp_path):
    with pytest.raises(CannotRead, match="is a folder") as refused:
        load_walk(tmp_path)
    assert "terazi walk score" in refused.value.remedy


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "is empty"),
        (b"a,b\n1,2\n3,4\n", "columns are not known: a, b"),
        (b"Time (s),b\n1\n", "row 1 has 1 fields, not 2"),
        (
            b"Time (s),"
            + b",".join(f'"{each}"'.encode() for each in GYRO + ACC)
            + b"\n"
            + b"1,2,3,x,5,6,7\n" * 3,
            "'Gyroscope Z .deg/s.' holds no number in row 1: 'x'",
        ),
        (b"\xff\xfe\x00", "no CSV"),
    ],
)
def test_a_wrong_csv_is_refused_with_what_is_wrong(tmp_path, content, words):
    path = tmp_path / "x.csv"
    path.write_bytes(content)
    with pytest.raises(CannotRead, match=words):
        load_walk(path)


def test_folders_are_searched_for_both_formats_and_never_give_none(tmp_path):
    with pytest.raises(CannotRead, match="holds no capture and no file"):
        find_walks(tmp_path)
    wanted = [npz(tmp_path, "b.npz"), x_io(tmp_path)]
    (tmp_path / "LICENSE.md").write_text("words")
    assert find_walks(tmp_path) == sorted(wanted)
    with pytest.raises(CannotRead, match="no such file"):
        find_walks(tmp_path / "nowhere")
