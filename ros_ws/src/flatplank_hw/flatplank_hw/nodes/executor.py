# SPDX-License-Identifier: Apache-2.0
"""An executor for nodes that receive hundreds of small messages per second.

For every message rclpy gathers all entities of a node and makes a new wait set and task, which
costs more than the work of a bench node. Here the wait set persists, and messages, timers,
requests and responses go straight to their callbacks. Actions and other rare events are left to
rclpy.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any

from rclpy.exceptions import InvalidHandle
from rclpy.executors import ShutdownException, SingleThreadedExecutor, TimeoutException
from rclpy.task import Task

from flatplank_hw.nodes.wait_sets import Watch

MOST_AT_ONCE = 50
"""largest number of messages taken from one subscription before the others are served"""


def _never() -> bool:
    """Shared by all rounds: rclpy drops its ready entities when it gets another function."""
    return False


class StreamExecutor(SingleThreadedExecutor):
    """Single-threaded executor: subscriptions and timers first, callback groups only for rare
    events. `due` are functions that it calls once, in its next round."""

    _watch: Watch | None = None
    _tasks: list[tuple[Task, Any, Any]]

    def __init__(self) -> None:
        super().__init__()
        self.due: deque[Callable[[], None]] = deque()

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Wait, then call the callbacks of everything that is ready.

        Args:
            timeout_sec: longest wait [s]; None waits for ever.
        """
        if self._watch is None:
            self._watch = Watch(self.get_nodes(), self._guard, (self._sigint_gc,), self.context)
        watch = self._watch
        if self.due:
            timeout_sec = 0.0
        try:
            watch.wait(-1 if timeout_sec is None else int(timeout_sec * 1e9))
        except InvalidHandle:  # a callback has destroyed an entity: gather the entities again
            self.release_entities()
            return
        if watch.rare.stale:
            self.release_entities()
            return
        if watch.rare_entity_ready():
            self.release_entities()
            self._spin_everything()
            self._call_due()
            return
        timers = watch.set.get_ready_entities("timer")
        messages = watch.set.get_ready_entities("subscription")
        if timers:
            for timer in watch.timers:
                if timer.handle.pointer in timers and timer.handle.is_timer_ready():
                    timer.handle.call_timer()
                    timer.callback()
        if messages:
            for subscription in watch.subscriptions:
                if subscription.handle.pointer in messages:
                    self._take_all(subscription)
        if (rare := watch.rare).ready:
            self._serve(rare.services, rare.set.get_ready_entities("service"), self._take_service)
            self._serve(rare.clients, rare.set.get_ready_entities("client"), self._take_client)
            rare.go_on()
        if watch.outdated(self.get_nodes()):
            self.release_entities()
        self._call_due()
        self._resume()

    def _call_due(self) -> None:
        for _ in range(len(self.due)):
            self.due.popleft()()

    def release_entities(self) -> None:
        """Release the entities; the next wait gathers them again."""
        if self._watch is not None:
            self._watch.keep.close()
            self._watch = None

    @staticmethod
    def _take_all(subscription) -> None:
        take: Callable = subscription.handle.take_message
        for _ in range(MOST_AT_ONCE):
            taken = take(subscription.msg_type, subscription.raw)
            if taken is None:
                return
            subscription.callback(taken[0])

    def _serve(self, entities, ready, take: Callable) -> None:
        """Take a request or response of each ready entity; `_resume` processes it."""
        for entity in entities if ready else ():
            if entity.handle.pointer in ready and (call := take(entity)) is not None:
                self._tasks.append((Task(call, executor=self), None, None))

    def _resume(self) -> None:
        """Begin and resume coroutines: what was taken, and services whose awaited result may have
        come."""
        for task, *_ in tuple(self._tasks):
            if not task.done():
                task()
                if task.done():
                    task.result()
        with self._tasks_lock:
            self._tasks = [entry for entry in self._tasks if not entry[0].done()]

    def _spin_everything(self) -> None:
        """Run one round of the rclpy executor, without waiting."""
        try:
            while True:
                handler, _entity, _node = self.wait_for_ready_callbacks(0.0, None, _never)
                handler()
                if handler.done():
                    handler.result()
        except (TimeoutException, ShutdownException):
            return
