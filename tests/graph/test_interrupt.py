# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C in the midst of a message still cancels a measurement, and its end is heard."""

from __future__ import annotations

import signal

import pytest
from domains import loopback, next_domain
from rclpy.action import ActionServer, CancelResponse
from rclpy.task import Future

from flatplank_control.nodes.client import BenchClient, BenchError, Interrupt
from flatplank_msgs.action import RunMeasurement

pytestmark = pytest.mark.graph


def ctrl_c(*_: object) -> None:
    signal.raise_signal(signal.SIGINT)


@pytest.fixture
def client(monkeypatch: pytest.MonkeyPatch):
    for key, value in loopback(next_domain()).items():
        monkeypatch.setenv(key, value)
    with BenchClient() as client:
        yield client


@pytest.fixture
def runner(client):
    """One that goes on until it is cancelled."""
    over = Future()

    async def execute(goal):
        goal.publish_feedback(RunMeasurement.Feedback(step="under way"))
        await over
        goal.canceled()
        return RunMeasurement.Result(message="cancelled")

    def on_cancel(_goal):
        over.set_result(None)
        return CancelResponse.ACCEPT

    server = ActionServer(
        client.node, RunMeasurement, "/run_measurement", execute, cancel_callback=on_cancel
    )
    yield server
    server.destroy()


@pytest.mark.parametrize("where", ["hear", "idle"])
def test_a_measurement_is_cancelled(client, runner, where):
    with pytest.raises(KeyboardInterrupt, match="cancelled"):
        client.measure({}, simulated=True, **{where: ctrl_c})


def test_who_is_impatient_ends_at_once():
    with pytest.raises(KeyboardInterrupt), Interrupt() as interrupt, interrupt.delayed():
        ctrl_c()
        ctrl_c()
        pytest.fail("the second one was kept")


def test_a_client_that_has_ended_leaves_ctrl_c_as_it_was():
    before = signal.getsignal(signal.SIGINT)
    with Interrupt():
        assert signal.getsignal(signal.SIGINT) is not before
    assert signal.getsignal(signal.SIGINT) is before


def test_ignored_stays_ignored():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with Interrupt() as interrupt, interrupt.delayed():
            ctrl_c()
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)


def test_without_a_runner_it_is_said(client, monkeypatch):
    monkeypatch.setattr(
        "rclpy.action.ActionClient.wait_for_server", lambda _self, timeout_sec: False
    )
    with pytest.raises(BenchError, match="/run_measurement: not there"):
        client.measure({}, simulated=True)
