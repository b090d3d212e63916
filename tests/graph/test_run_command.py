# SPDX-License-Identifier: Apache-2.0
"""`flatplank run` on a bench as an operator starts and ends it: a process, its lines, its code."""

from __future__ import annotations

import signal
import subprocess
import sys
from contextlib import contextmanager

import pytest
from bench_graph import shared_graph
from diagnostic_msgs.msg import DiagnosticArray
from short_plan import short_plan
from std_msgs.msg import String
from std_srvs.srv import Trigger

from flatplank_control.nodes.client import BenchError
from flatplank_control.nodes.measurement_runner import CLIENT_GONE
from flatplank_control.runner.steps import BUSY

pytestmark = pytest.mark.graph
bench = shared_graph()
PLAN = short_plan("command")
RUN = "import sys; from flatplank_control.cli.run import main; sys.exit(main(sys.argv[1:]))"


@contextmanager
def running(folder, *words: str):
    """The command, up to its first line of progress."""
    plan = folder / "plan.yaml"
    plan.write_text(PLAN)
    command = [sys.executable, "-c", RUN, str(plan), "--data", str(folder / "data"), *words]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True) as process:
        try:
            while not (line := process.stdout.readline()).startswith("0/1 "):
                assert line, process.stderr.read()
            yield process, line
        finally:
            process.kill()


def test_ctrl_c_cancels_and_waits_for_the_safe_end(bench, tmp_path):
    with running(tmp_path) as (process, _line):
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60.0)
    assert "stopped (cancelled); the same command continues it" in errors
    assert process.returncode == 130
    assert "kapa" in why_refused(bench)  # not busy


def test_a_run_ends_when_its_client_dies(bench, tmp_path):
    beats = bench.listen(String, "/operator/heartbeat")
    told = bench.listen(DiagnosticArray, "/diagnostics")
    with running(tmp_path, "--lab") as (process, _line):
        while not beats:
            bench.client.spin(0.5)
        process.kill()
    while BUSY in (reason := why_refused(bench)):
        bench.client.spin(0.5)
    assert "kapa" in reason
    while not any(CLIENT_GONE in str(message) for message in told):
        bench.client.spin(0.5)


def why_refused(bench) -> str:
    """What the runner says to a plan with a mistake."""
    with pytest.raises(BenchError) as refused:
        bench.client.measure({"kapa": 1}, simulated=False)
    return str(refused.value)


def test_a_skipped_run_is_told_and_has_its_exit_code(bench, tmp_path):
    with running(tmp_path, "--lab") as (process, line):
        while "turn the plank switch" not in line:
            line = process.stdout.readline()
        assert line.startswith("0/1 ")
        bench.call(Trigger, "/measurement_runner/skip")
        said, errors = process.communicate(timeout=60.0)
        assert process.returncode == 3, errors
    assert "0 of 1 runs in" in said
    assert "skipped: " in said and "plan.yaml:8" in said
