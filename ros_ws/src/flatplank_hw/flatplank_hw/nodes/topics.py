# SPDX-License-Identifier: Apache-2.0
"""Topics and services of a node, within its process and through the middleware."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from inspect import iscoroutinefunction
from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.lifecycle import LifecycleNode
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import serialize_message

from flatplank_hw.nodes.exchanges import Exchange
from flatplank_hw.nodes.late_clients import LateClients
from flatplank_hw.nodes.local import LocalTopics
from flatplank_hw.nodes.reporting import Reporter, reporting_refusals
from flatplank_hw.nodes.responses import fill_response

End = Callable[[], None]
"""ends a subscription"""
Count = Callable[[], int]
"""counts the partners of a topic"""


class TopicNode(LifecycleNode):
    """Node whose topics and services exist from its activation to its deactivation.

    Streams have no QoS event handlers, since each would be checked with every message.
    """

    local: LocalTopics | None = None
    """topics within this process; None: the node has the process for itself"""

    troubles: Reporter

    def __init__(self, name: str, **kwargs: Any) -> None:
        self._late_clients = LateClients(self)
        super().__init__(name, **kwargs)
        self._links: list[tuple[Count, str]] = []
        self._teardown: list[End] = []
        self.outside: Node = self
        """node for clients of services that may be in this process; of another participant when
        the nodes of the process share theirs"""

    def add_subscription(
        self,
        msg_type: type,
        topic: str,
        callback: Callable[[Any], Any],
        qos: QoSProfile | int,
        *,
        needed: bool = True,
    ) -> None:
        """Subscribe; a `needed` topic must have a publisher before the graph is
        connected.
        """
        self._subscribe(msg_type, topic, callback, callback, qos, needed=needed)

    def add_sample_subscription(
        self,
        exchange: Exchange,
        topic: str,
        receive: Callable[[Any], None],
        qos: QoSProfile,
        *,
        needed: bool = True,
        from_inside: Callable[[Any], None] | None = None,
    ) -> Count:
        """Subscribe to the samples of a topic, as `add_subscription`; returns a function that
        counts its publishers. `from_inside`: receives the samples of this process in place of
        `receive`."""
        read, inside = exchange.read, from_inside or receive
        return self._subscribe(
            exchange.msg_type, topic, lambda msg: receive(read(msg)), inside, qos, needed=needed
        )[0]

    def add_serialised_subscription(
        self,
        msg_type: type,
        topic: str,
        receive: Callable[[bytes], None],
        qos: QoSProfile | int,
        *,
        needed: bool = True,
    ) -> End:
        """Subscribe to the messages of a topic as they are on the wire, as `add_subscription`;
        returns a function that ends it."""
        return self._subscribe(
            msg_type, topic, receive, receive, qos, needed=needed, serialised=True
        )[1]

    def _subscribe(
        self,
        msg_type: type,
        topic: str,
        from_outside: Callable[[Any], None],
        from_inside: Callable[[Any], None],
        qos: QoSProfile | int,
        *,
        needed: bool,
        serialised: bool = False,
    ) -> tuple[Count, End]:
        quiet = SubscriptionEventCallbacks(use_default_callbacks=False)
        subscription = self.create_subscription(
            msg_type, topic, from_outside, qos, event_callbacks=quiet, raw=serialised
        )
        ends = [lambda: self.destroy_subscription(subscription)]
        count, local = subscription.get_publisher_count, self.local
        if local is not None:
            name = subscription.topic_name
            ends.append(local.subscribe(name, from_inside, serialised=serialised))
            count = partial(_sum, count, partial(local.count_publishers, name))
        if needed:
            self._links.append((count, topic))
        self._teardown += ends

        def end() -> None:
            for each in ends:
                if each in self._teardown:
                    self._teardown.remove(each)
                    each()

        return count, end

    def add_publisher(
        self, msg_type: type, topic: str, qos: QoSProfile | int, *, needed: bool = False
    ) -> Callable[[Any], None]:
        """Return a publish function; a `needed` topic must have a subscription before the graph is
        connected.
        """
        return self._advertise(msg_type, topic, qos, needed, serialize_message)

    def add_sample_publisher(
        self,
        exchange: Exchange,
        topic: str,
        qos: QoSProfile,
        *,
        frame: str = "",
        needed: bool = False,
    ) -> Callable[[Any], None]:
        """Return a function that publishes a sample, as `add_publisher`. It is serialised only
        when somebody receives it so: outside of this process, or a recorder inside. `frame`: frame
        id of the messages.
        """
        return self._advertise(exchange.msg_type, topic, qos, needed, exchange.packing(frame))

    def _advertise(
        self,
        msg_type: type,
        topic: str,
        qos: QoSProfile | int,
        needed: bool,
        serialise: Callable[[Any], bytes],
    ) -> Callable[[Any], None]:
        """A function that publishes inside and outside of this process."""
        quiet = PublisherEventCallbacks(use_default_callbacks=False)
        publisher = self.create_publisher(msg_type, topic, qos, event_callbacks=quiet)
        self._teardown.append(lambda: self.destroy_publisher(publisher))
        outside, local = publisher.get_subscription_count, self.local
        keep = isinstance(qos, QoSProfile) and qos.durability == DurabilityPolicy.TRANSIENT_LOCAL
        count, name = outside, publisher.topic_name
        if local is not None:
            self._teardown.append(local.advertise(name))
            count = partial(_sum, outside, partial(local.count_subscribers, name))
        if needed:
            self._links.append((count, topic))

        def publish(sample: Any) -> None:
            heard = keep or outside() > 0
            wanted = heard or (local is not None and local.serialised_for(name))
            cdr = serialise(sample) if wanted else b""
            if local is not None:
                local.publish(name, sample, cdr, keep=keep)
            if heard:
                publisher.publish(cdr)

        return publish

    def create_service(self, *args: Any, **kwargs: Any) -> Any:
        """A service whose answers also reach a client that is not wholly known yet."""
        return self._late_clients.watch(super().create_service(*args, **kwargs))

    def add_service(self, srv_type: type, name: str, callback: Callable) -> None:
        # a waiting coroutine must not block other callbacks
        group = ReentrantCallbackGroup() if iscoroutinefunction(callback) else None
        full = self.resolve_service_name(name)
        wrapped = reporting_refusals(self.troubles, full, callback)
        service = self.create_service(srv_type, name, wrapped, callback_group=group)
        self._teardown.append(lambda: self.destroy_service(service))

    def add_request(
        self, srv_type: type, name: str, ask: Callable[[Any], tuple[bool, str, int]]
    ) -> None:
        """Add a service that the core answers at once: `ask` takes the request."""
        self.add_service(
            srv_type, name, lambda request, response: fill_response(response, *ask(request))
        )

    def add_timer(self, period: float, callback: Callable[[], None]) -> Any:
        timer = self.create_timer(period, callback)
        self._teardown.append(lambda: self.destroy_timer(timer))
        return timer

    def end_topics(self) -> None:
        """End all topics, services and timers that were added."""
        while self._teardown:
            self._teardown.pop()()
        self._links.clear()

    def missing_partners(self) -> list[str]:
        """Needed topics without a partner."""
        return sorted({topic for count, topic in self._links if count() == 0})


def _sum(*counts: Count) -> int:
    return sum(count() for count in counts)
