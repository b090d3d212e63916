# SPDX-License-Identifier: Apache-2.0
"""The runner is in charge of the axes while it makes a measurement, unless a person is."""

from __future__ import annotations

import pytest
import rclpy
from domains import loopback, next_domain
from rclpy.node import Node
from std_msgs.msg import String

from flatplank_control.nodes.bench_samples import BenchSamples
from flatplank_control.nodes.ros_bench import RosBench
from flatplank_control.runner import steps as S
from flatplank_hw.drive.requests import RUNNER
from flatplank_hw.nodes.executor import StreamExecutor
from flatplank_msgs.srv import Claim

pytestmark = pytest.mark.graph


class Drive(Node):
    """Answers claims, and hears heartbeats."""

    def __init__(self, free: bool) -> None:
        super().__init__("drive")
        self.free, self.claims, self.beats = free, [], []
        self.create_service(Claim, "operator/claim", self.on_claim)
        self.create_subscription(String, "operator/heartbeat", self.beats.append, 10)

    def on_claim(self, request, response):
        self.claims.append(request.client)
        response.accepted, response.token = self.free, request.client
        return response


def measured(monkeypatch, free: bool, held: bool = False) -> Drive:
    """The drive at the end of a measurement of one step, during which heartbeats were waited for
    when the runner was in charge."""
    for key, value in loopback(next_domain()).items():
        monkeypatch.setenv(key, value)
    rclpy.init()
    try:
        drive, node = Drive(free), Node("runs")
        deaf = BenchSamples(lambda *_topic: lambda: None)
        bench = RosBench(node, deaf, held=held, simulated=False)
        executors = [StreamExecutor(), StreamExecutor()]
        for executor, one in zip(executors, (drive, node), strict=True):
            executor.add_node(one)

        def spin(until) -> None:
            while not until():
                for executor in executors:
                    executor.spin_once(timeout_sec=0.02)

        ended = []

        async def measure() -> None:
            await bench.perform(S.ShowProgress("a step"))
            ended.append("step")

        async def release() -> None:
            await bench.release_charge()
            ended.append("released")

        executors[1].create_task(measure())
        spin(lambda: ended and (drive.beats or held or not free))
        executors[1].create_task(release())
        spin(lambda: len(ended) > 1)
        bench.close()
        for executor in executors:
            executor.release_entities()
    finally:
        rclpy.try_shutdown()
    return drive


def test_heartbeats_are_sent_until_the_measurement_has_ended(monkeypatch):
    drive = measured(monkeypatch, free=True)
    assert drive.claims == [RUNNER, ""]
    assert {beat.data for beat in drive.beats} == {RUNNER}


def test_a_person_in_charge_stays_in_charge(monkeypatch):
    drive = measured(monkeypatch, free=False)
    assert drive.claims == [RUNNER] and not drive.beats


def test_a_bench_whose_time_is_not_that_of_the_clock_is_not_claimed(monkeypatch):
    drive = measured(monkeypatch, free=True, held=True)
    assert not drive.claims and not drive.beats
