# SPDX-License-Identifier: MIT
"""The last line of ``./dev test`` is true: whatever a stage does, it is counted as what it was."""

import sys

import pytest

from tools.checks import stages
from tools.checks.stage_list import Stage

JUNIT = """<testsuites><testsuite>
<testcase classname="a" name="good"/>
<testcase classname="a" name="bad"><failure message="no"/></testcase>
<testcase classname="a" name="broken"><error message="no"/></testcase>
<testcase classname="a" name="left"><skipped message="no board"/></testcase>
</testsuite></testsuites>"""
ALL_GOOD = '<testsuites><testsuite><testcase classname="a" name="b"/></testsuite></testsuites>'
NOTHING = "<testsuites><testsuite/></testsuites>"


@pytest.fixture
def tree(tmp_path, monkeypatch):
    for name in ("ROOT", "LOGS", "RESULTS"):
        monkeypatch.setattr(stages, name, tmp_path)
    return tmp_path


def stage(exit_code, left=None, text=""):
    """A stage that leaves a file with a text and ends with an exit code."""
    write = f"open({left!r}, 'w').write({text!r});" if left else ""
    code = f"import sys; {write} sys.exit({exit_code})"
    return Stage("s", "claim", lambda _: [[sys.executable, "-c", code]])


@pytest.mark.parametrize(
    ("does", "passed", "failed"),
    [
        ((0,), 1, 0),
        ((3,), 0, 1),
        (
            (
                1,
                "s.xml",
                JUNIT,
            ),
            1,
            2,
        ),
        (
            (
                0,
                "s.xml",
                ALL_GOOD,
            ),
            1,
            0,
        ),
        (
            (
                1,
                "s.xml",
                ALL_GOOD,
            ),
            1,
            1,
        ),
        (
            (
                0,
                "s.xml",
                NOTHING,
            ),
            0,
            1,
        ),
        (
            (
                0,
                "s.xml",
                "<cut",
            ),
            0,
            1,
        ),
        (
            (
                1,
                "s.json",
                '{"passed": 4, "failed": 2}',
            ),
            4,
            2,
        ),
        (
            (
                0,
                "s.json",
                '{"passed": 4}',
            ),
            0,
            1,
        ),
    ],
)
def test_a_stage_is_counted_as_what_it_was(tree, does, passed, failed):
    outcome = stages.run(stage(*does))
    assert (outcome.passed, outcome.failed) == (passed, failed)


def test_counts_left_by_an_earlier_run_are_not_taken(tree):
    (tree / "s.xml").write_text(ALL_GOOD)
    outcome = stages.run(stage(1))
    assert (outcome.passed, outcome.failed) == (0, 1)


def test_skips_are_told_by_their_reason(tree):
    assert stages.run(stage(1, "s.xml", JUNIT)).skipped == {"no board": 1}


def test_later_stages_run_after_a_failure_and_the_last_line_is_their_sum(tree, monkeypatch, capsys):
    monkeypatch.setattr(stages, "STAGES", (stage(1), stage(0, "s.xml", ALL_GOOD)))
    assert stages.main([]) == 1
    assert capsys.readouterr().out.splitlines()[-1] == "1 passed, 1 failed"


def test_an_unknown_stage_is_refused(tree, capsys):
    assert stages.main(["dance"]) == 2
    assert "dance" in capsys.readouterr().err
