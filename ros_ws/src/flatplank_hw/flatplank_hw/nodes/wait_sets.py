# SPDX-License-Identifier: Apache-2.0
"""Wait sets of an executor that persist while the entities stay the same.

A wait takes longer with every entity, and the nodes of a bench have over a hundred services. So a
thread waits for requests, responses and rare events, and wakes the executor.
"""

from __future__ import annotations

import threading
from contextlib import ExitStack
from itertools import chain
from operator import attrgetter, is_not

from rclpy.exceptions import InvalidHandle
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy


class Watch:
    """Wait sets of all entities that can wake the nodes and their executor.

    `wake`: the guard by which rclpy wakes the executor, for instance for a new entity; `guards`:
    further ones.
    """

    def __init__(self, nodes, wake, guards, context) -> None:
        self.keep = ExitStack()
        self._gathered = _entities_of(nodes)
        self.subscriptions = self._hold(chain.from_iterable(n.subscriptions for n in nodes))
        self.timers = self._hold(chain.from_iterable(n.timers for n in nodes))
        others = [*chain.from_iterable(n.guards for n in nodes), *guards]
        held = self._hold([wake, *others])
        self._wake = wake.handle.pointer
        self._others = {g.handle.pointer for g in held} - {self._wake}
        self.keep.enter_context(context.handle)
        self.rare = RareWatch(
            self._hold(chain.from_iterable(n.services for n in nodes)),
            self._hold(chain.from_iterable(n.clients for n in nodes)),
            self._hold(chain.from_iterable(n.waitables for n in nodes), lambda w: w),
            context,
        )
        self.keep.callback(self.rare.end)
        self._handles = [
            [entity.handle for entity in entities]
            for entities in (self.subscriptions, self.timers, held)
        ]
        self._handles[-1].append(self.rare.ready_guard)
        self.sizes = [len(handles) for handles in self._handles]
        """number of subscriptions, timers and guards that are waited for"""
        messages, timers, guards = self.sizes
        self.set = _rclpy.WaitSet(messages, guards, timers, 0, 0, 0, context.handle)
        self.rare.start()

    def _hold(self, entities, handle=attrgetter("handle")) -> list:
        """Entities that still exist; holding their handles keeps them alive during the wait."""
        held = []
        for entity in entities:
            try:
                self.keep.enter_context(handle(entity))
            except InvalidHandle:
                continue
            held.append(entity)
        return held

    def wait(self, nanoseconds: int) -> None:
        wanted = self.set
        wanted.clear_entities()
        adders = (wanted.add_subscription, wanted.add_timer, wanted.add_guard_condition)
        for add, handles in zip(adders, self._handles, strict=True):
            for handle in handles:
                add(handle)
        wanted.wait(nanoseconds)

    def outdated(self, nodes) -> bool:
        """True when rclpy has woken the executor and the entities have changed."""
        if self._wake not in self.set.get_ready_entities("guard_condition"):
            return False
        now = _entities_of(nodes)
        return len(now) != len(self._gathered) or any(map(is_not, now, self._gathered))

    def rare_entity_ready(self) -> bool:
        if not self._others.isdisjoint(self.set.get_ready_entities("guard_condition")):
            return True
        return self.rare.ready and self.rare.waitable_ready()


class RareWatch:
    """Waits in a thread for requests, responses and rare events. What is `ready` is served in the
    thread of the executor; then `go_on` lets this one wait again. `stale`: an entity is gone."""

    def __init__(self, services, clients, waitables, context) -> None:
        self.services, self.clients, self._waitables = services, clients, waitables
        self.ready = self.stale = False
        self.ready_guard = _rclpy.GuardCondition(context.handle)
        """is triggered when something is ready"""
        self._end_guard = _rclpy.GuardCondition(context.handle)
        self._ends = False
        self._served = threading.Semaphore(0)
        self._thread = threading.Thread(target=self._run, name="rare events", daemon=True)
        extra = [w.get_num_entities() for w in waitables]
        self.set = _rclpy.WaitSet(
            sum(n.num_subscriptions for n in extra),
            1 + sum(n.num_guard_conditions for n in extra),
            sum(n.num_timers for n in extra),
            len(clients) + sum(n.num_clients for n in extra),
            len(services) + sum(n.num_services for n in extra),
            sum(n.num_events for n in extra),
            context.handle,
        )

    def start(self) -> None:
        self._thread.start()

    def end(self) -> None:
        """End the thread."""
        self._ends = True
        self._end_guard.trigger_guard_condition()
        self._served.release()
        self._thread.join()

    def go_on(self) -> None:
        """Wait again; what was ready has been served."""
        self.ready = False
        self._served.release()

    def waitable_ready(self) -> bool:
        return any(waitable.is_ready(self.set) for waitable in self._waitables)

    def _run(self) -> None:
        while not self._ends:
            try:
                self._wait()
            except InvalidHandle:  # a callback has destroyed an entity: gather the entities again
                self.stale = True
            if self._ends:
                return
            self.ready = not self.stale
            self.ready_guard.trigger_guard_condition()
            self._served.acquire()

    def _wait(self) -> None:
        self.set.clear_entities()
        for service in self.services:
            self.set.add_service(service.handle)
        for client in self.clients:
            self.set.add_client(client.handle)
        self.set.add_guard_condition(self._end_guard)
        for waitable in self._waitables:
            waitable.add_to_wait_set(self.set)
        self.set.wait(-1)


def _entities_of(nodes) -> list:
    """All entities of the nodes."""
    kinds = attrgetter("subscriptions", "timers", "clients", "services", "guards", "waitables")
    return [*chain.from_iterable(chain.from_iterable(kinds(node)) for node in nodes)]
