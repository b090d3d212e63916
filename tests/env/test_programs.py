# SPDX-License-Identifier: Apache-2.0
"""The programs of `ros2 run`: each is there, and Ctrl-C while it is imported is no traceback."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from importlib.metadata import entry_points
from importlib.util import find_spec

import pytest

PROGRAMS = [
    entry
    for entry in entry_points(group="console_scripts")
    if entry.module in ("flatplank_hw.start", "flatplank_sim.start", "flatplank_control.start")
]
SLOW = """
import sys
from importlib.abc import MetaPathFinder

class Slow(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name == "rclpy":
            print("importing", flush=True)
            sys.stdin.read()

from importlib.metadata import entry_points
(entry,) = entry_points(group="console_scripts", name="measurement_hub")
sys.meta_path.insert(0, Slow())
entry.load()()
"""
"""a node whose import of ROS lasts until its input ends"""


def test_every_node_is_a_program() -> None:
    assert len(PROGRAMS) >= 11


@pytest.mark.parametrize("entry", PROGRAMS, ids=lambda entry: entry.name)
def test_a_program_finds_its_node(entry) -> None:
    (module,) = entry.load().args
    assert find_spec(module)


def test_ctrl_c_while_a_node_is_imported_is_no_traceback() -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", SLOW], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout.readline() == "importing\n"
    os.kill(process.pid, signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert said == ""


def test_no_node_of_the_machine_waits_for_arrow() -> None:
    """Files are read by `flatplank_data`, whose limits and parameters every node uses."""
    cores = ("flatplank_hw.drive.axis", "flatplank_hw.hub", "flatplank_control.sequencer")
    check = f"import sys, {', '.join(cores)}; sys.exit('pyarrow' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", check], timeout=60).returncode == 0
