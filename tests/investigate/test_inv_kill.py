# SPDX-License-Identifier: Apache-2.0
"""Killed on the twin, while runs are made and while they are diagnosed: the same end."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path

import pytest
import yaml

from flatplank_control.investigate.journal import NAME

pytestmark = [pytest.mark.long, pytest.mark.timeout(7200)]
VERB = (
    "import sys; from flatplank_control.cli.investigate import main; sys.exit(main(sys.argv[1:]))"
)
KILLS = 5
PLANT = "defects: {drive_brake_asymmetry: {friction: 0.12}}\n"


def _steps(folder: Path) -> int:
    """Lines of logs and journals, and files of runs."""
    lines = (len(p.read_text().splitlines()) for p in folder.glob("*.jsonl"))
    return sum(lines) + len(list(folder.glob("*.parquet")))


def _killed(command: list[str], folder: Path, draw: random.Random) -> int:
    """Start it, and kill it some steps and a moment later; its exit code. Workers that it leaves
    go on with the run that they have, as after any crash; they are ended at the very end."""
    pause = threading.Event()
    goal, later = _steps(folder) + draw.randint(1, 7), draw.uniform(0.0, 4.0)
    with subprocess.Popen(
        command, start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as process:
        while process.poll() is None and _steps(folder) < goal:
            pause.wait(0.05)
        with suppress(subprocess.TimeoutExpired):
            process.wait(later)
        process.kill()
        _LEFT.append(process.pid)
    return process.returncode


def _events(folder: Path) -> list[dict]:
    """The log without the seconds that the last diagnosis took."""
    events = [json.loads(line) for line in (folder / NAME).read_text().splitlines()]
    events[-1]["verdict"].pop("seconds")
    return events


_LEFT: list[int] = []


@pytest.fixture(autouse=True)
def no_workers_are_left():
    yield
    for group in _LEFT:
        with suppress(ProcessLookupError):
            os.killpg(group, signal.SIGKILL)


def test_killed_on_the_twin_it_ends_as_if_nothing_was(tmp_path):
    plant = tmp_path / "plant.yaml"
    plant.write_text(PLANT)
    words = ["--sim", "--plant", str(plant), "--minutes", "60", "--jobs", "2"]
    folders = tmp_path / "whole", tmp_path / "killed"
    commands = [[sys.executable, "-c", VERB, str(folder), *words] for folder in folders]
    subprocess.run(commands[0], check=True, capture_output=True)
    draw = random.Random(2106)
    codes = [_killed(commands[1], folders[1], draw) for _ in range(KILLS)]
    assert codes.count(-signal.SIGKILL) >= KILLS - 1, codes  # it may have come to its end
    subprocess.run(commands[1], check=True, capture_output=True)
    whole, killed = (_events(f) for f in folders)
    assert killed == whole
    names = [sorted(p.name for p in f.glob("*.parquet")) for f in folders]
    assert names[0] == names[1]
    runs = [yaml.safe_load((f / "campaign.yaml").read_text())["runs"] for f in folders]
    assert sorted(r["file"] for r in runs[1]) == sorted(r["file"] for r in runs[0])
    assert sorted(r["file"] for r in runs[1]) == names[1]
