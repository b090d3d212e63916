# SPDX-License-Identifier: Apache-2.0
"""Recorders killed at random moments lose at most the last second."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
from pathlib import Path

import rec_samples as samples
from mcap.reader import make_reader

from flatplank_control.recording.bag_writer import bag_file_name
from flatplank_control.recording.bus_cycles import read_bus_image
from flatplank_control.recording.recovery import repair
from flatplank_data.run_record import load_record

COUNT = 20
HERE = Path(__file__).parent


def kill_all(folder: Path) -> dict[int, list[int]]:
    """Kill each recorder after a random number of cycles: the stamps [ns] that it told."""
    rng = random.Random(20)
    fatal = {number: rng.randrange(1, 750) for number in range(COUNT)}
    path = os.pathsep.join([str(HERE), *filter(None, sys.path)])
    environment = os.environ | {"PYTHONPATH": path, "OMP_NUM_THREADS": "1"}
    command = [sys.executable, str(HERE / "rec_kill_writer.py"), str(folder), str(COUNT)]
    told: dict[int, list[int]] = {}
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as process:
        assert process.stdout is not None
        for line in process.stdout:
            number, pid, cycle, stamp_ns = map(int, line.split())
            told.setdefault(number, []).append(stamp_ns)
            if cycle == fatal[number]:
                os.kill(pid, signal.SIGKILL)
    assert process.returncode == 0
    return told


def test_twenty_kills_lose_at_most_the_last_second(tmp_path):
    told = kill_all(tmp_path)
    assert len(told) == COUNT
    repaired = repair(tmp_path)
    assert len(repaired) == COUNT
    for number, written in told.items():
        name = samples.toyo(fz=float(number)).name
        path = tmp_path / name
        messages = samples.read(path)
        cycles = [read_bus_image(data).last for topic, _, data in messages if topic == samples.BUS]
        assert cycles == list(range(1, len(cycles) + 1))
        lost = written[len(cycles) :]
        assert not lost or lost[-1] - lost[0] <= 1_000_000_000, (name, len(written), len(cycles))
        with (path / bag_file_name(name)).open("rb") as file:
            assert sum(1 for _ in make_reader(file, True).iter_messages()) == len(messages)
        record = load_record(path)
        assert record.status == "interrupted"
        assert (record.cycles_received, record.cycles_lost) == (len(cycles), 0)
    assert repair(tmp_path) == []
