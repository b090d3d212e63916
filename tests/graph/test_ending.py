# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C as it comes from a terminal and from `ros2 launch`: several times in a row."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest
from domains import loopback, next_domain

from flatplank_control.bench.processes import BenchProcesses
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.nodes.client import BenchClient
from flatplank_hw.process import STARTED

pytestmark = pytest.mark.graph


def test_every_node_ends_in_order_however_often_it_is_interrupted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    environment = loopback(next_domain())
    for key, value in environment.items():
        monkeypatch.setenv(key, value)
    setup = BenchSetup(data=str(tmp_path / "data"))
    log = tmp_path / "nodes.log"
    with BenchProcesses(setup, environment=environment, log=log) as bench:
        with BenchClient() as client:
            client.wait_connected(bench)
        nodes = dict(bench.running)
        while left := [node for node in nodes.values() if node.poll() is None]:
            for node in left:
                node.send_signal(signal.SIGINT)
            with suppress(subprocess.TimeoutExpired):
                left[0].wait(0.02)
    assert {name: node.returncode for name, node in nodes.items()} == dict.fromkeys(nodes, 0)
    assert "Traceback" not in log.read_text()


ENDS_BADLY = """
import ctypes, sys
import rclpy
from flatplank_hw.nodes import encoders

def hangs():  # compiled code that keeps the interpreter for itself, as Fast DDS does
    ctypes.PyDLL(None).sleep(600)

def crashes():
    ctypes.string_at(0)

def aborts():
    ctypes.CDLL(None).abort()

def end():
    print(sys.argv[1], flush=True)
    globals()[sys.argv[1]]()

rclpy.try_shutdown = end
raise SystemExit(encoders.main())
"""


@pytest.mark.parametrize("how", ["hangs", "crashes", "aborts"])
def test_a_node_whose_middleware_does_not_end_well_ends_all_the_same(how, tmp_path: Path) -> None:
    listens = tmp_path / "listens"
    environment = os.environ | loopback(next_domain()) | {STARTED: str(listens)}
    command = [sys.executable, "-c", ENDS_BADLY, how]
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as node:
        while not listens.exists():
            assert node.poll() is None
            time.sleep(0.05)
        node.send_signal(signal.SIGTERM)
        said, _ = node.communicate()
    assert (node.returncode, said) == (0, f"{how}\n")


LAUNCHES = """
import os, subprocess, sys
from flatplank_hw.process import END_WITH_PARENT
environment = {**os.environ, END_WITH_PARENT: str(os.getpid())}
node = subprocess.Popen([sys.executable, "-m", "flatplank_hw.nodes.wheel_drive"], env=environment)
print(node.pid, flush=True)
node.wait()
"""


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGKILL])
def test_a_node_ends_with_the_program_that_has_started_it(how: int, tmp_path: Path) -> None:
    """The launch file gives its nodes the same word of the environment."""
    listens = tmp_path / "listens"
    environment = os.environ | loopback(next_domain()) | {STARTED: str(listens)}
    with subprocess.Popen(
        [sys.executable, "-c", LAUNCHES], env=environment, stdout=subprocess.PIPE, text=True
    ) as launch:
        assert launch.stdout is not None
        node = int(launch.stdout.readline())
        while not listens.exists():
            assert launch.poll() is None
            time.sleep(0.05)
        watched = os.pidfd_open(node)
        launch.send_signal(how)
        launch.wait()
        (over, *_), _, _ = select.select([watched], [], [], 60.0)
        assert over == watched
        os.close(watched)
