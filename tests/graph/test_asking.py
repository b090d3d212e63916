# SPDX-License-Identifier: Apache-2.0
"""A service whose node ends in the middle of a call: one clear line, no wait without end."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import rclpy
from domains import loopback, next_domain
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger

from flatplank_control.nodes.bench_samples import BenchSamples
from flatplank_control.nodes.ros_bench import RosBench
from flatplank_control.runner.steps import PlanFailed
from flatplank_hw.nodes.executor import StreamExecutor

pytestmark = pytest.mark.graph
NAME = "/slow/answer"


class SlowServer(Node):
    """Answers when it is told to."""

    def __init__(self) -> None:
        super().__init__("slow")
        self.asked = False
        self.go = Future()
        self.create_service(Trigger, NAME, self.on_ask)

    async def on_ask(self, _request, response):
        self.asked = True
        response.success = await self.go
        return response


class Question:
    """A call by the runner's bench, and the executors of both sides."""

    def __init__(self) -> None:
        self.server, self.node = SlowServer(), Node("asks")
        deaf = BenchSamples(lambda *_topic: lambda: None)
        self.bench = RosBench(self.node, deaf, held=False, simulated=True)
        self.executors = [StreamExecutor(), StreamExecutor()]
        for executor, node in zip(self.executors, (self.server, self.node), strict=True):
            executor.add_node(node)
        self.outcome: Trigger.Response | PlanFailed | None = None
        self.executors[1].create_task(self.ask())

    async def ask(self) -> None:
        try:
            self.outcome = await self.bench.call(Trigger, NAME)
        except PlanFailed as error:
            self.outcome = error

    def spin(self, until) -> None:
        while not until():
            for executor in self.executors:
                executor.spin_once(timeout_sec=0.02)

    def spin_to_the_end(self) -> Trigger.Response | PlanFailed:
        self.spin(lambda: self.outcome is not None)
        return self.outcome

    def end_the_server(self) -> None:
        executor = self.executors.pop(0)
        executor.release_entities()
        executor.remove_node(self.server)
        self.server.destroy_node()


@pytest.fixture
def question(monkeypatch: pytest.MonkeyPatch) -> Iterator[Question]:
    for key, value in loopback(next_domain()).items():
        monkeypatch.setenv(key, value)
    rclpy.init()
    asked = Question()
    asked.spin(lambda: asked.server.asked)
    yield asked
    asked.bench.close()
    for executor in asked.executors:
        executor.release_entities()
    rclpy.try_shutdown()


def test_an_answer_may_take_long(question: Question) -> None:
    looks = []
    question.node.create_timer(0.3, lambda: looks.append(None))
    question.spin(lambda: len(looks) > 2)
    assert question.outcome is None
    question.server.go.set_result(True)
    assert question.spin_to_the_end().success


def test_a_server_that_ends_leaves_no_call_waiting(question: Question) -> None:
    question.end_the_server()
    error = question.spin_to_the_end()
    assert str(error) == f"{NAME}: its node has ended before it answered; start it again"


def test_a_server_that_is_started_again_has_not_heard_the_call(question: Question) -> None:
    question.end_the_server()
    again = SlowServer()
    executor = StreamExecutor()
    executor.add_node(again)
    question.executors.append(executor)
    assert isinstance(question.spin_to_the_end(), PlanFailed)
    assert not again.asked


def test_calls_are_served_without_gathering_all_entities_anew(question: Question) -> None:
    """A round of rclpy gathers every entity of the process; a held bench makes two calls in each
    25 cycles."""
    question.server.go.set_result(True)
    assert question.spin_to_the_end().success
    executors = question.executors
    watches = [executor._watch for executor in executors]
    for executor in executors:
        executor._spin_everything = None  # fails when it is called
    for _ in range(5):
        question.outcome = None
        executors[1].create_task(question.ask())
        assert question.spin_to_the_end().success
    assert [executor._watch for executor in executors] == watches
    assert not any(executor._tasks for executor in executors)


def test_samples_do_not_wait_with_services(question: Question) -> None:
    """A wait costs with every entity: those of the samples are not waited for with services; a
    service that comes later is answered all the same, and one that goes leaves the others."""
    executor, node = question.executors[0], question.server
    executor.spin_once(timeout_sec=0.0)
    size = executor._watch.sizes
    more = [node.create_service(Trigger, f"~/more{i}", node.on_ask) for i in range(20)]
    node.create_timer(3600.0, lambda: None)
    executor.spin_once(timeout_sec=0.0)
    executor.spin_once(timeout_sec=0.0)
    assert executor._watch.sizes == [size[0], size[1] + 1, size[2]]
    assert len(executor._watch.rare.services) >= len(more)
    node.destroy_service(more[0])
    question.server.go.set_result(True)
    assert question.spin_to_the_end().success
