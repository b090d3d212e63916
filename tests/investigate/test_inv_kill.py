# SPDX-License-Identifier: Apache-2.0
"""Killed on the twin, while runs are made and while they are diagnosed: the same end.

FLATPLANK_KILLS says how often; five to an investigation."""

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

from flatplank_control.investigate.opening import NAME

pytestmark = [pytest.mark.long, pytest.mark.timeout(7200)]
VERB = (
    "import sys; from flatplank_control.cli.investigate import main; sys.exit(main(sys.argv[1:]))"
)
KILLS = int(os.environ.get("FLATPLANK_KILLS", "5"))
EACH = 5
"""kills of one investigation"""
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


def _listed(folder: Path) -> list[str]:
    runs = yaml.safe_load((folder / "campaign.yaml").read_text())["runs"]
    return sorted(r["file"] for r in runs)


def _files(folder: Path) -> list[str]:
    return sorted(p.name for p in folder.glob("*.parquet"))


def test_killed_on_the_twin_it_ends_as_if_nothing_was(tmp_path):
    plant = tmp_path / "plant.yaml"
    plant.write_text(PLANT)
    words = ["--sim", "--plant", str(plant), "--minutes", "60", "--jobs", "2"]

    def command(folder: Path) -> list[str]:
        return [sys.executable, "-c", VERB, str(folder), *words]

    whole, draw, killed = tmp_path / "whole", random.Random(2106), 0
    subprocess.run(command(whole), check=True, capture_output=True)
    for number in range(-(-KILLS // EACH)):
        folder = tmp_path / f"killed_{number}"
        codes = [_killed(command(folder), folder, draw) for _ in range(min(EACH, KILLS - killed))]
        assert set(codes) <= {-signal.SIGKILL, 0}, codes  # it may have come to its end
        killed += codes.count(-signal.SIGKILL)
        subprocess.run(command(folder), check=True, capture_output=True)
        assert _events(folder) == _events(whole)
        assert _files(folder) == _files(whole) == _listed(folder) == _listed(whole)
        print(f"{killed} kills, {number + 1} investigations: the same events, files and verdict")
    assert killed >= 0.8 * KILLS
