# SPDX-License-Identifier: MIT
"""What `./dev bench` says of attitude: peers beside ours, or why not. No speed is judged here."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path

from host.tests.applications.synthetic import write

ROOT = Path(__file__).resolve().parents[3]
PROGRAM = "import json, sys, attitude; print(json.dumps(attitude.accuracy(*sys.argv[1:])))"


def accuracy(*words):
    environment = {key: value for key, value in os.environ.items() if key != "TERAZI_DATA"}
    environment["PYTHONPATH"] = f"{ROOT / 'host' / 'benchmarks'}:{ROOT}"
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, *map(str, words)],
        capture_output=True,
        text=True,
        env=environment,
        timeout=300,
        check=True,
    )
    return json.loads(done.stdout)


def test_absent_recordings_are_named():
    assert "TERAZI_DATA is unset" in accuracy()["skipped"]


def test_a_folder_without_the_trials_is_named(tmp_path):
    assert "attitude/broad" in accuracy(tmp_path)["skipped"]


def test_all_filters_are_judged_on_all_trials_and_ours_holds_its_own(tmp_path):
    folder = tmp_path / "attitude" / "broad"
    folder.mkdir(parents=True)
    for seed in (1, 2):
        write(folder / f"{seed}.npz", rate_hz=200.0, rest_s=14.0, move_s=3.0, seed=seed)
    found = accuracy(tmp_path)
    assert found["trials"] == 2
    assert len(found["axes_6"]) == 7
    assert len(found["axes_9"]) == 3
    for table in (found["axes_6"], found["axes_9"]):
        for row in table.values():
            figures = [*row["mean"].values(), *row["worst"].values()]
            assert all(math.isfinite(figure) and 0 <= figure <= 180 for figure in figures)
    # Peers run in the right frames and units: an axis or a sign wrong would be far off.
    for name in ("terazi", "vqf.VQF", "imufusion.Ahrs", "ahrs.Madgwick"):
        assert found["axes_6"][name]["mean"]["inclination_rmse_deg"] < 4, name
    for name in ("terazi", "vqf.VQF"):
        assert found["axes_9"][name]["mean"]["total_rmse_deg"] < 4, name
