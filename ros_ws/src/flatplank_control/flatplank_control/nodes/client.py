# SPDX-License-Identifier: Apache-2.0
"""Client of a running bench: connect, measure, call services."""

from __future__ import annotations

import math
import signal
import time
import uuid
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from types import FrameType
from typing import Any

import rclpy
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from std_msgs.msg import String
from std_srvs.srv import Trigger

from flatplank_control.bench.processes import STALL_TIMEOUT_S, BenchProcesses, StartProgress
from flatplank_control.nodes.charge import DEPTH, TOPIC
from flatplank_control.runner.steps import BUSY
from flatplank_data.errors import FlatplankError
from flatplank_data.yaml_text import dump_yaml
from flatplank_msgs.action import RunMeasurement


class Interrupt:
    """Context in which Ctrl-C within `delayed` acts only at its end, or at `raise_if_pressed`.

    A KeyboardInterrupt inside rclpy loses the message that is being taken, and its receiver may
    never get another one. A goal could then neither be cancelled nor followed. So the first Ctrl-C
    is delayed; a second one acts at once. Other handlers of Ctrl-C are left unchanged.
    """

    def __init__(self) -> None:
        self._depth = 0
        self._asked = self._reported = False
        self._ours = False

    def __enter__(self) -> Interrupt:
        self._ours = signal.getsignal(signal.SIGINT) is signal.default_int_handler
        if self._ours:
            signal.signal(signal.SIGINT, self._on_signal)
        return self

    def __exit__(self, *_: object) -> None:
        if self._ours:
            signal.signal(signal.SIGINT, signal.default_int_handler)

    def _on_signal(self, _number: int, _frame: FrameType | None) -> None:
        if self._asked:
            raise KeyboardInterrupt
        self._asked = True
        if not self._depth:
            self.raise_if_pressed()

    def raise_if_pressed(self) -> None:
        """Raise KeyboardInterrupt, once, when Ctrl-C was pressed."""
        if self._asked and not self._reported:
            self._reported = True
            raise KeyboardInterrupt

    @contextmanager
    def delayed(self) -> Iterator[None]:
        """Delay a first Ctrl-C to the end of the outermost `delayed`."""
        self._depth += 1
        try:
            yield
        finally:
            self._depth -= 1
        if not self._depth:
            self.raise_if_pressed()

    @contextmanager
    def at_once(self) -> Iterator[None]:
        """Within `delayed`, let Ctrl-C act at once, while the operator is waited for."""
        depth, self._depth = self._depth, 0
        try:
            self.raise_if_pressed()
            yield
        finally:
            self._depth = depth


Say = Callable[[str], None]
Hear = Callable[[RunMeasurement.Feedback], None]
SERVER_GONE = 10.0
"""a server that is absent for longer is gone [s of wall clock]"""
LISTEN = 0.05
"""longest wait for one message while an answer is awaited [s of wall clock]"""
ANSWER_TIMEOUT_S = 5.0
"""a connection request without answer is repeated after this time [s of wall clock]"""
ASK_AGAIN_S = 0.5
"""a node that is not connected yet is asked again after this time [s of wall clock]"""


class BenchError(FlatplankError):
    """The bench does not answer or refuses."""


class BenchClient:
    """Client of the bench as a short-lived node; a context manager."""

    def __init__(self, name: str = "flatplank_client", namespace: str = "") -> None:
        """`namespace`: ROS namespace of the bench, in which relative names of services are."""
        # with its own signal handlers rclpy would shut down before a Ctrl-C can cancel a goal
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        self.node = Node(name, namespace=namespace)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self._clients: dict[str, Any] = {}
        self._heartbeat = self.node.create_publisher(String, TOPIC, DEPTH)
        self._interrupt = Interrupt()

    def __enter__(self) -> BenchClient:
        self._interrupt.__enter__()
        return self

    def __exit__(self, *_: object) -> None:
        self._executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown()
        self._interrupt.__exit__()

    def call(self, kind: Any, name: str, /, timeout: float = 10.0, **fields: Any) -> Any:
        """Call a service; BenchError when it does not answer in time [s of wall clock]."""
        future = self.ask(kind, name, timeout, **fields)
        self._until(future, timeout)
        if not future.done():
            place = self._client(kind, name).service_name
            raise BenchError(f"{place}: no answer within {timeout:g} s")
        return future.result()

    def ask(self, kind: Any, name: str, /, timeout: float = 10.0, **fields: Any) -> Future:
        """Call a service without waiting for its answer; BenchError when it is not there in time
        [s of wall clock]."""
        client = self._client(kind, name)
        if not client.wait_for_service(timeout_sec=timeout):
            place = client.service_name
            raise BenchError(f"{place}: not there after {timeout:g} s; is the bench running?")
        return client.call_async(kind.Request(**fields))

    def _client(self, kind: type, name: str) -> Any:
        if name not in self._clients:
            self._clients[name] = self.node.create_client(kind, name)
        return self._clients[name]

    def wait_connected(
        self,
        nodes: BenchProcesses | Iterable[str],
        timeout: float = STALL_TIMEOUT_S,
        say: Say = lambda _text: None,
    ) -> dict[str, float]:
        """Wait until every node reports that all its topics have a partner.

        For a bench started by this program, BenchError names a node that has ended or hangs.
        `timeout`: longest time without any progress [s]. `say` gets the number of nodes that are
        up, whenever it changes. Returns node -> time when it was up (time.monotonic) [s].
        """
        ours = nodes if isinstance(nodes, BenchProcesses) else None
        names = nodes.nodes() if isinstance(nodes, BenchProcesses) else nodes
        start = StartProgress(list(names), time.monotonic(), timeout)
        asked: dict[str, tuple[Future | None, float]] = {}
        shown = ""
        while start.missing:
            for name in start.missing:
                self._ask_connected(name, asked, start)
            if shown != str(start):
                shown = str(start)
                say(shown)
            if not start.missing:
                break
            if ours and (reason := ours.why_ended()):
                raise BenchError(f"{reason}; {start}")
            if reason := start.why_waiting_is_useless(
                ours.vitals() if ours else {}, time.monotonic()
            ):
                raise BenchError(reason)
            self.spin(LISTEN)
        return start.up_at

    def _ask_connected(
        self, name: str, asked: dict[str, tuple[Future | None, float]], start: StartProgress
    ) -> None:
        """Ask a node whether it is connected; repeat when the answer is lost or negative."""
        service = f"{name}/connected"
        client = self._client(Trigger, service)
        now = time.monotonic()
        future, since = asked.get(name, (None, -math.inf))
        if future is not None and future.done():
            answer = future.result()
            start.register_answer(name, "" if answer.success else answer.message, now)
            asked[name] = None, now
        elif future is not None and now - since > ANSWER_TIMEOUT_S:
            # the request may have gone to a node that has died since
            self.node.destroy_client(self._clients.pop(service))
            del asked[name]
        elif future is None and now - since >= ASK_AGAIN_S and client.service_is_ready():
            asked[name] = client.call_async(Trigger.Request()), now

    def spin(self, seconds: float) -> None:
        """Process messages for a time [s of wall clock]."""
        with self._interrupt.delayed():
            self._executor.spin_once(timeout_sec=seconds)

    def _until(self, future: Any, seconds: float) -> None:
        """Process messages until a future is done, at most for `seconds` [s of wall clock].

        The method of the executor adds a callback to the future with every message, and the next
        wait must process them all, so it gets slower and slower. All waits have the same length:
        with another one the executor restarts its round, and a busy topic would keep it from
        reaching the answer.
        """
        end = time.monotonic() + seconds
        while not future.done() and time.monotonic() < end:
            self.spin(LISTEN)

    def measure(
        self,
        plan: Mapping[str, Any] | str,
        *,
        simulated: bool,
        folder: str = "",
        resume: bool = False,
        say: Say = lambda _text: None,
        hear: Hear = lambda _feedback: None,
        idle: Callable[[], None] = lambda: None,
    ) -> list[str]:
        """Let the runner make a measurement or a campaign, given as YAML; returns the bags.

        BenchError has the reason of the runner, also when the runner goes away. `say` gets the
        text of the feedback, `hear` the whole message; `idle` is called ten times a second. Ctrl-C
        cancels and waits for the safe end, 20 s at most, and for its reason. When this program
        dies, the runner ends the measurement after 5 s.
        """

        last = ""

        def on_feedback(message: Any) -> None:
            nonlocal last
            feedback = message.feedback
            text = feedback.prompt or feedback.step
            if text and (feedback.prompt or text != last):
                say(text)
            last = text
            hear(feedback)

        text = plan if isinstance(plan, str) else dump_yaml(dict(plan))
        beat = String(data=uuid.uuid4().hex)
        goal = RunMeasurement.Goal(
            plan=text, folder=folder, simulated=simulated, resume=resume, heartbeat=beat.data
        )
        client = ActionClient(self.node, RunMeasurement, "run_measurement")
        try:
            if not client.wait_for_server(timeout_sec=10.0):
                name = self.node.resolve_service_name("run_measurement")
                raise BenchError(f"{name}: not there; is the bench running?")
            with self._interrupt.delayed():
                answer = self._goal(client, goal, on_feedback, beat, idle)
        finally:
            client.destroy()
        if not answer.success:
            raise BenchError(answer.message)
        return list(answer.bags)

    def _goal(
        self,
        client: ActionClient,
        goal: Any,
        on_feedback: Hear,
        beat: String,
        idle: Callable[[], None],
    ) -> Any:
        """Send the goal and return its result, with heartbeats meanwhile. Ctrl-C cancels the goal;
        before it is accepted it cannot be cancelled, so Ctrl-C is delayed.
        """
        sent = client.send_goal_async(goal, on_feedback)
        self._await(sent, client, beat)
        handle = sent.result()
        if not handle.accepted:
            raise BenchError(BUSY)
        result = handle.get_result_async()
        try:
            self._await(result, client, beat, idle)
        except KeyboardInterrupt:
            # the runner first ends safely, and reports what is left to do by hand
            cancelled = handle.cancel_goal_async()
            self._until(cancelled, 5.0)
            self._until(result, 20.0)
            message = result.result().result.message if result.done() else "no answer"
            raise KeyboardInterrupt(message) from None
        return result.result().result

    def _await(
        self,
        future: Any,
        client: ActionClient,
        beat: String,
        idle: Callable[[], None] | None = None,
    ) -> None:
        """Wait for the future; BenchError when the server is gone for `SERVER_GONE`. Ctrl-C acts
        at once while `idle` is called.
        """
        seen = time.monotonic()
        while not future.done():
            self._heartbeat.publish(beat)
            self._until(future, 0.1)
            if idle is not None:
                with self._interrupt.at_once():
                    idle()
            if client.server_is_ready():
                seen = time.monotonic()
            elif time.monotonic() - seen > SERVER_GONE:
                raise BenchError(
                    "the runner has gone; start it again, the same command continues it"
                )
