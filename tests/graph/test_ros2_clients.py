# SPDX-License-Identifier: Apache-2.0
"""The bench by the real tools of ROS, where they are installed.

`ros2` and `launch` are in an installed Jazzy. They are not among the packages that the set-up
takes from PyPI: there these tests are left out, which the end of the run says, and the same is
held in plain Python by tests/troubles (arguments, ends, dumps) and over the graph API by the other
tests of this folder.
"""

from __future__ import annotations

import os
import re
import select
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from domains import loopback, next_domain

from flatplank_hw.troubles import TROUBLES

pytestmark = [pytest.mark.graph, pytest.mark.installed_ros]
ROS2 = [sys.executable, "-c", "import sys; from ros2cli.cli import main; sys.exit(main())"]
ALONE = ("--no-daemon", "--spin-time", "10")
"""no process is left behind; the graph is looked for so long [s]"""
ECHO = ("topic", "echo", "--no-daemon", "--once")
STATUS = (*ECHO, "/wheel_drive/status", "flatplank_msgs/msg/DriveStatus")
DIAGNOSTICS = (*ECHO, "/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")
TIMEOUT_S = 120.0
"""[s]"""


@contextmanager
def launched(tmp_path: Path, *arguments: str) -> Iterator[tuple[subprocess.Popen, Path, dict]]:
    """`ros2 launch` in a domain of its own, its terminal in a file."""
    environment = {**os.environ, **loopback(next_domain()), "ROS_LOG_DIR": str(tmp_path / "log")}
    command = [*ROS2, "launch", "flatplank_control", "bench.launch.py", *arguments]
    terminal = tmp_path / "terminal.log"
    with terminal.open("wb") as out:
        process = subprocess.Popen(
            command, stdout=out, stderr=out, env=environment, start_new_session=True
        )
        try:
            yield process, terminal, environment
        finally:
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
            process.wait(TIMEOUT_S)


def tell(environment: dict, *words: str) -> str:
    """What a command of ros2 prints."""
    done = subprocess.run(
        [*ROS2, *words], env=environment, capture_output=True, text=True, timeout=TIMEOUT_S
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def until(terminal: Path, pattern: str) -> str:
    end = time.monotonic() + TIMEOUT_S
    while not (found := re.search(pattern, terminal.read_text(encoding="utf-8"))):
        assert time.monotonic() < end, terminal.read_text(encoding="utf-8")
        time.sleep(0.2)
    return found[0]


@pytest.mark.parametrize(
    ("argument", "reason"),
    [
        ("simm:=true", "unknown argument 'simm'; the nearest is 'sim'"),
        ("sim:=1", "Valid options are: ['true', 'false']"),
        ("calibration:=nope.yaml", "no such file"),
        ("seed:=foo", "seed:=foo: must be a whole number"),
    ],
)
def test_a_wrong_launch_argument_starts_nothing(tmp_path, argument, reason):
    with launched(tmp_path, "sim:=true", argument) as (process, terminal, _):
        assert process.wait(TIMEOUT_S) == 1
        text = terminal.read_text(encoding="utf-8")
    assert reason in text and "process started" not in text and "Traceback" not in text


def test_a_launch_tells_its_troubles_and_ends_with_a_node(tmp_path):
    arguments = "sim:=true", "separate:=true", f"data:={tmp_path}"
    with launched(tmp_path, *arguments) as (process, terminal, environment):
        recorder = int(re.search(r"\d+$", until(terminal, r"recorder-\d+\]: .*pid \[\d+"))[0])
        tell(environment, *STATUS)
        tell(environment, "service", "call", "/wheel_drive/quick_stop", "std_srvs/srv/Trigger")
        said = tell(environment, *DIAGNOSTICS)
        assert TROUBLES["quick_stop"].text in said.replace("\n", " ")
        until(terminal, TROUBLES["quick_stop"].text)
        dump = tmp_path / "hub.yaml"
        dump.write_text(
            tell(environment, "param", "dump", "/measurement_hub", *ALONE), encoding="utf-8"
        )
        loaded = tell(environment, "param", "load", "/measurement_hub", str(dump), *ALONE)
        failed = [line for line in loaded.splitlines() if "failed" in line]
        assert all("read-only" in line for line in failed), failed
        os.kill(recorder, signal.SIGKILL)
        assert process.wait(TIMEOUT_S) == 1
        text = terminal.read_text(encoding="utf-8")
    assert f"{TROUBLES['node_ended'].text} (recorder, ended by SIGKILL)" in text
    assert "Traceback" not in text


def test_ctrl_c_of_a_launch_is_no_trouble(tmp_path):
    with launched(tmp_path, "sim:=true", f"data:={tmp_path}") as (process, terminal, environment):
        tell(environment, *STATUS)
        process.send_signal(signal.SIGINT)
        assert process.wait(TIMEOUT_S) == 0
        text = terminal.read_text(encoding="utf-8")
    assert TROUBLES["node_ended"].text not in text and "Traceback" not in text


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGKILL])
def test_a_launch_that_is_ended_leaves_no_node(tmp_path, how):
    arguments = "sim:=true", "separate:=true", f"data:={tmp_path}"
    with launched(tmp_path, *arguments) as (process, terminal, environment):
        tell(environment, *STATUS)
        found = re.findall(r"process started with pid \[(\d+)\]", terminal.read_text())
        nodes = [os.pidfd_open(int(pid)) for pid in found]
        assert len(nodes) >= 8
        process.send_signal(how)
        process.wait(TIMEOUT_S)
        for node in nodes:
            assert select.select([node], [], [], TIMEOUT_S)[0] == [node]
            os.close(node)
