# SPDX-License-Identifier: MIT
"""The truth file: what is taken and what is refused, and with which words."""

import numpy as np
import pytest

from terazi.errors import CannotRead
from terazi.report import Truth, load_truth


@pytest.fixture
def file(tmp_path):
    return tmp_path / "truth.csv"


def test_truth_takes_the_columns_by_name_and_skips_comments(file):
    file.write_text("# of the bench\nload_g,counts,t_s\n0,84000,0\n500,298775,2.5\n")
    truth = load_truth(file)
    assert truth.t_s.tolist() == [0.0, 2.5]
    assert truth.load_g.tolist() == [0.0, 500.0]


def test_truth_holds_each_row_until_the_next_and_knows_nothing_beyond():
    truth = Truth(np.array([1.0, 2.0, 3.0]), np.array([10.0, 20.0, 20.0]))
    known = truth.at(np.array([0.5, 1.0, 1.9, 2.0, 3.0, 3.1]))
    assert np.array_equal(known, [np.nan, 10, 10, 20, 20, np.nan], equal_nan=True)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("t_s,grams\n0,1\n1,2\n", "no column load_g"),
        ("", "no column load_g and no column t_s"),
        ("t_s,load_g\n0,1\n1,heavy\n", "line 3: not a number"),
        ("t_s,load_g\n0,1\n1\n", "line 3: not a number"),
        ("t_s,load_g\n0,1\n1,nan\n", "line 3: not a finite number"),
        ("t_s,load_g\n0,1\n", "fewer than two rows"),
        ("t_s,load_g\n0,1\n2,1\n1,1\n", "does not always grow"),
    ],
)
def test_truth_says_what_is_wrong_with_a_file(file, text, words):
    file.write_text(text)
    with pytest.raises(CannotRead, match=words):
        load_truth(file)


def test_truth_names_a_missing_and_a_binary_file(file):
    with pytest.raises(CannotRead, match="there is no file"):
        load_truth(file)
    file.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(CannotRead, match="not a text file"):
        load_truth(file)
