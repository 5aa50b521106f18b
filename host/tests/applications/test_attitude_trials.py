# SPDX-License-Identifier: MIT
"""Reading trials: what is converted, what is refused and how it is said."""

import numpy as np
import pytest

from host.tests.applications.synthetic import write
from terazi.applications.attitude.trials import find_trials, load_trial
from terazi.errors import CannotRead

SHORT = {"rest_s": 0.5, "move_s": 1.0}
ONES = np.ones((572, 3))


def refused(path, words):
    with pytest.raises(CannotRead, match=words) as caught:
        load_trial(path)
    assert str(path) in str(caught.value)


def test_trial_is_what_the_file_holds(tmp_path):
    trial = load_trial(write(tmp_path / "one.npz", **SHORT))
    held = np.load(tmp_path / "one.npz")
    assert trial.name == "one"
    assert trial.rate_hz == pytest.approx(285.714, abs=1e-3)
    for ours, theirs in (("gyro", "gyr"), ("acc", "acc"), ("mag", "mag")):
        found = getattr(trial, f"{ours}_b_counts")
        assert found.dtype == np.int16
        assert np.array_equal(found, held[theirs])
    assert np.linalg.norm(trial.truth_wb, axis=1) == pytest.approx(1)
    assert trial.scored.sum() == held["movement"].sum()


def test_scales_and_rate_may_be_left_out_and_are_then_broads(tmp_path):
    scales = ("sampling_rate", "gyr_lsb_per_dps", "acc_lsb_per_g", "mag_lsb_per_uT", "acc_g")
    bare = load_trial(write(tmp_path / "bare.npz", without=scales, **SHORT))
    whole = load_trial(write(tmp_path / "whole.npz", **SHORT))
    assert bare.rate_hz == whole.rate_hz
    assert np.array_equal(bare.gyro_b_counts, whole.gyro_b_counts)


def test_other_scales_are_converted_to_the_chips_counts_and_limited_as_it_would(tmp_path):
    changed = {"acc": ONES * 16384 * [1, -1, 3], "acc_lsb_per_g": 16384.0}
    changed |= {"gyr": ONES * 131 * [100, -2, 5000], "gyr_lsb_per_dps": 131.0}
    trial = load_trial(write(tmp_path / "other.npz", changed, **SHORT))
    assert trial.acc_b_counts[0].tolist() == [2048, -2048, 6144]
    assert trial.gyro_b_counts[0].tolist() == [1638, -33, 32767]


def test_samples_without_truth_or_movement_do_not_count(tmp_path):
    path = write(tmp_path / "gaps.npz", **SHORT)
    quat = np.load(path)["quat"].astype(float)
    quat[200:210] = 0
    quat[220:225] = np.nan
    trial = load_trial(write(path, {"quat": quat}, **SHORT))
    assert not trial.scored[200:210].any()
    assert not trial.scored[220:225].any()
    assert not trial.scored[:100].any()
    assert trial.scored.sum() == 286 - 15


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"gyr": np.zeros((572, 4))}, "gyr has the shape .572, 4., not .572, 3."),
        ({"acc": np.zeros((571, 3))}, "acc has the shape"),
        ({"quat": np.zeros((572, 4))}, "no sample moves and has a known orientation"),
        ({"movement": np.zeros(572)}, "no sample moves"),
        ({"movement": np.ones((572, 1))}, "movement has the shape"),
        ({"gyr": ONES * np.nan}, "gyr holds what is no number"),
        ({"mag": ONES * np.inf}, "mag holds what is no number"),
        ({"gyr": np.full((572, 3), "x")}, "could not convert"),
        ({"gyr": np.array([{}] * 572)}, "Object arrays cannot be loaded"),
        ({"gyr": np.float64(3)}, "gyr has the shape"),
        ({"sampling_rate": 3.0}, "a rate of 3 Hz; 50 to 1000 do"),
        ({"sampling_rate": np.nan}, "sampling_rate must be one positive number"),
        ({"acc_lsb_per_g": 0.0}, "acc_lsb_per_g must be one positive number"),
        ({"mag_lsb_per_uT": np.ones(2)}, "mag_lsb_per_uT must be one positive number"),
    ],
)
def test_what_is_wrong_with_a_file_is_said(tmp_path, changed, words):
    refused(write(tmp_path / "wrong.npz", changed, **SHORT), words)


def test_a_file_that_lacks_fields_names_them(tmp_path):
    refused(write(tmp_path / "less.npz", without=("mag", "quat"), **SHORT), "lacks mag, quat")


def test_a_trial_of_less_than_a_second_is_refused(tmp_path):
    refused(write(tmp_path / "brief.npz", rest_s=0.1, move_s=0.5), "less than 1 s")


def test_files_that_are_no_archives_are_refused(tmp_path):
    for name, content in {"text.npz": b"hello", "empty.npz": b"", "cut.npz": b"PK\3\4cut"}.items():
        (tmp_path / name).write_bytes(content)
        refused(tmp_path / name, name)
    np.save(tmp_path / "array.npy", ONES)
    (tmp_path / "array.npy").rename(tmp_path / "array.npz")
    refused(tmp_path / "array.npz", "no .npz archive")
    refused(tmp_path / "absent.npz", "No such file")
    whole = write(tmp_path / "whole.npz", **SHORT).read_bytes()
    (tmp_path / "half.npz").write_bytes(whole[: len(whole) // 2])
    refused(tmp_path / "half.npz", "zip")
    (tmp_path / "spoilt.npz").write_bytes(whole[:300] + bytes(200) + whole[500:])
    refused(tmp_path / "spoilt.npz", "spoilt")


def test_trials_of_a_folder_are_found_in_order(tmp_path):
    for name in ("b.npz", "a.npz", "notes.txt"):
        (tmp_path / name).touch()
    assert [path.name for path in find_trials(tmp_path)] == ["a.npz", "b.npz"]
    assert find_trials(tmp_path / "a.npz") == [tmp_path / "a.npz"]


def test_a_folder_without_trials_is_refused(tmp_path):
    with pytest.raises(CannotRead, match="holds no file that ends in"):
        find_trials(tmp_path)
    with pytest.raises(CannotRead, match="no such folder"):
        find_trials(tmp_path / "absent")
