# SPDX-License-Identifier: Apache-2.0
"""The panel's node beside a bench that is silent at the wrong moment, or has no hands.

By its name it comes before the browser tests, whose observer keeps rclpy until the session ends.
"""

from __future__ import annotations

import asyncio
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from types import SimpleNamespace

import pytest
from panel_rig import wait_for
from rclpy.action import ActionServer
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future

from flatplank_msgs.action import RunMeasurement
from flatplank_msgs.srv import SetValue
from flatplank_panel.bench_state import BenchState
from flatplank_panel.nodes import panel

pytestmark = pytest.mark.graph


@pytest.fixture
def bench(domain, monkeypatch):
    """A panel's node, and a runner that answers only while it is spun."""
    monkeypatch.setattr(panel, "ANSWER_TIMEOUT_S", 0.3)
    loop = asyncio.new_event_loop()
    with panel.PanelNode(BenchState(), "panel_under_test") as link:
        node, over = Node("runner_of_test"), Future()

        async def execute(goal):
            await over
            goal.abort()
            return RunMeasurement.Result()

        server = ActionServer(node, RunMeasurement, "/run_measurement", execute)
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        spin = partial(executor.spin_once, 0.0)
        with ThreadPoolExecutor(1) as thread:  # the browser of other tests has a loop in this one

            def run(work):
                return thread.submit(loop.run_until_complete, work).result()

            yield SimpleNamespace(link=link, node=node, spin=spin, run=run)
        over.set_result(None)
        wait_for(lambda: spin() or not link.state.progress.active, 20.0, "ended")
        executor.shutdown()
        server.destroy()
        node.destroy_node()
    loop.close()  # what answers late does so to an open one


def test_an_answer_that_comes_before_its_question_is_noted(bench, monkeypatch):
    """The thread that asks may stall between the two."""
    over = threading.Event()

    def stalls(*args, **kwargs):
        time.sleep(0.3)
        return Future(*args, **kwargs)

    def answer():
        while not over.wait(0.01):
            bench.spin()

    monkeypatch.setattr("rclpy.action.client.Future", stalls)
    monkeypatch.setattr(panel, "ANSWER_TIMEOUT_S", 5.0)
    runner = threading.Thread(target=answer)
    runner.start()
    try:
        began = bench.run(bench.link.measure("", "", True))
        stopped = bench.run(bench.link.cancel())
    finally:
        over.set()
        runner.join()
    assert began.accepted, began.reason
    assert stopped.accepted, stopped.reason


def test_a_silent_runner_is_named(bench):
    async def answered(work):
        task = asyncio.ensure_future(work)
        while not task.done():
            bench.spin()
            await asyncio.sleep(0.01)
        return await task

    async def ask():
        late = await bench.link.measure("", "", True)
        panel.ANSWER_TIMEOUT_S = 20.0
        good = await answered(bench.link.measure("", "", True))
        panel.ANSWER_TIMEOUT_S = 0.3
        return late, good, await bench.link.cancel()

    late, good, cancelled = bench.run(ask())
    assert not late.accepted and "measurement runner: no answer within" in late.reason
    assert good.accepted and bench.link.state.progress.active
    assert not cancelled.accepted and "measurement runner: no answer within" in cancelled.reason


def test_hands_are_seen_by_their_service(bench):
    def hands() -> bool:
        return bench.link.offers("load_to")

    assert not hands()
    service = bench.node.create_service(SetValue, "/simulated_plant/load_to", lambda _q, a: a)
    wait_for(hands, 20.0, "the service is seen")
    bench.node.destroy_service(service)
    wait_for(lambda: not hands(), 20.0, "the service has gone")
