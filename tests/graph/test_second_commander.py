# SPDX-License-Identifier: Apache-2.0
"""A second node that commands the wheel: refused and reported, and never enabled by itself."""

import os
import signal
import subprocess
import sys
from contextlib import contextmanager

import pytest
from bench_graph import graph
from diagnostic_msgs.msg import DiagnosticArray
from std_srvs.srv import SetBool

pytestmark = pytest.mark.graph
SECOND = [sys.executable, "-m", "flatplank_hw.nodes.wheel_drive", "--ros-args"]
SECOND += ["-r", "__node:=other_drive"]


@contextmanager
def second_drive():
    with subprocess.Popen(SECOND, env=dict(os.environ)) as node:
        try:
            yield
        finally:
            node.send_signal(signal.SIGTERM)


@pytest.mark.parametrize("separate", [(), ("wheel_drive",)])
def test_a_second_drive_node_is_refused_and_named(separate, tmp_path, monkeypatch):
    with graph(tmp_path, monkeypatch, separate=separate) as bench:
        heard = bench.listen(DiagnosticArray, "/diagnostics")
        bench.roll()
        assert bench.wheel_turns()
        with second_drive():
            answer = bench.client.call(SetBool, "/other_drive/enable", timeout=60.0, data=True)
            assert not answer.success
            # and maybe others that it has not met yet
            assert answer.message.startswith("not connected: no partner on ")
            assert "~/reference" in answer.message
            said, found = "", {}
            # a message may arrive before the name of its publisher
            while not ("/other_drive" in said and "/wheel_drive" in said):
                bench.advance(20)
                bench.client.spin(0.2)
                found |= {s.name: s for message in heard for s in message.status}
                # a node that has not met the owner of the bus has no bench time
                owners = [m for m in heard if m.status[0].name == "/simulated_plant"]
                assert all(message.header.stamp.sec < 3600 for message in owners), "bench time"
                heard.clear()
                if "/simulated_plant" in found:
                    said = found["/simulated_plant"].message
            assert "another node commands an axis of this bench (wheel: " in said
            if separate:
                while bench.wheel_turns():  # the wheel comes to rest
                    bench.advance(50)
            else:
                bench.advance(250)
                assert bench.wheel_turns()
