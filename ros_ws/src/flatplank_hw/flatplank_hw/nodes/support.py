# SPDX-License-Identifier: Apache-2.0
"""Common parts of all nodes of the bench: parameters, life cycle, start and end."""

from __future__ import annotations

import os
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from inspect import iscoroutinefunction
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy import Context
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.exceptions import InvalidParameterTypeException, ParameterException
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions
from std_srvs.srv import Trigger

from flatplank_data.params import SHELL_KEYS
from flatplank_hw.nodes.convert import Exchange, set_stamp
from flatplank_hw.nodes.executor import StreamExecutor
from flatplank_hw.nodes.local import LocalTopics
from flatplank_hw.nodes.parameters import (
    check_parameter_names,
    declare_parameter_set,
    read_parameter_set,
)
from flatplank_hw.nodes.reporting import OF_NODES, Collector, Reporter, reporting_refusals
from flatplank_hw.process import end_with_parent, end_within, prepare_threads, report_started

ENDING = (signal.SIGINT, signal.SIGTERM)

LOOK_AT_SIGNALS = 0.1
"""a node without messages checks at this interval whether it is to end [s]"""

TO_END = 4.0
"""time for the middleware to shut down after all work of the node is done [s]"""

TO_COME, TO_COME_BACK = 30.0, 3.0
"""a topic without partner is reported after this time [s]: after the start, later"""


class BenchNode(LifecycleNode):
    """Lifecycle node around one core.

    A subclass names its parameter class in `PARAMETERS`, makes its core in `configure(parameters)`
    and its subscriptions and publishers in `connect()`. Subscriptions exist only while the node is
    active. Streams have no QoS event handlers, since each would be checked with every message.
    """

    PARAMETERS: type

    OWNS_BUS = False
    """true: publishes /diagnostics for all nodes; without such a node each publishes its own"""

    MEASURES = False
    """true: the node has calibrated constants, and says so when it was given none"""

    local: LocalTopics | None = None
    """topics within this process; None: the node has the process for itself"""

    ended = False
    """true when the node cannot continue; it ends with exit code 1"""

    def __init__(self, name: str, **kwargs: Any) -> None:
        super().__init__(name, **kwargs)
        declare_parameter_set(self, self.PARAMETERS)
        self.declare_parameter("autostart", True)
        self.declare_parameter(
            "fifo_priority",
            0,
            ParameterDescriptor(
                description="SCHED_FIFO of this node where it is allowed; 0: ordinary scheduling",
                integer_range=[IntegerRange(from_value=0, to_value=49)],
                read_only=True,
            ),
        )
        if self.MEASURES:
            self.declare_parameter(
                "constants_from",
                "",
                ParameterDescriptor(
                    description="origin of the calibrated constants; empty: not calibrated",
                    read_only=True,
                ),
            )
        self.add_on_set_parameters_callback(self._check)
        self.troubles = Reporter(
            self.get_fully_qualified_name(), self.get_logger(), self._publish_troubles
        )
        self._collector = Collector()
        self._publish_status: Callable[[DiagnosticArray], None] | None = None
        self._links: list[tuple[Callable[[], int], str]] = []
        self._teardown: list[Callable[[], None]] = []
        self.create_service(Trigger, "~/connected", self._connected)

    # to be implemented by a subclass
    def configure(self, parameters: Any) -> None:
        """Make the core; a ValueError refuses the configuration."""

    def connect(self) -> None:
        """Make subscriptions, publishers and services with the helpers below."""

    def bench_ns(self) -> int:
        """Bench time for the stamps of diagnostics [ns]; the owner of the bus knows it."""
        return self.get_clock().now().nanoseconds

    def diagnostic_values(self) -> Mapping[str, Any]:
        """Values that /diagnostics shows beside the troubles."""
        return {}

    # helpers
    def add_subscription(
        self,
        msg_type: type,
        topic: str,
        callback: Callable,
        qos: QoSProfile | int,
        *,
        needed: bool = True,
        raw: bool = False,
    ) -> None:
        """Subscribe; a `needed` topic must have a publisher before the graph is
        connected.
        """
        self._subscribe(msg_type, topic, callback, callback, qos, needed, raw)

    def add_sample_subscription(
        self,
        exchange: Exchange,
        topic: str,
        receive: Callable[[Any], None],
        qos: QoSProfile,
        *,
        needed: bool = True,
        from_inside: Callable[[Any], None] | None = None,
    ) -> Callable[[], int]:
        """Subscribe to the samples of a topic, as `add_subscription`; returns a function that
        counts its publishers. `from_inside`: receives the samples of this process in place of
        `receive`."""
        read, inside = exchange.read, from_inside or receive
        return self._subscribe(
            exchange.msg_type, topic, lambda msg: receive(read(msg)), inside, qos, needed, False
        )

    def _subscribe(
        self,
        msg_type: type,
        topic: str,
        from_outside: Callable[[Any], None],
        from_inside: Callable[[Any], None],
        qos: QoSProfile | int,
        needed: bool,
        raw: bool,
    ) -> Callable[[], int]:
        quiet = SubscriptionEventCallbacks(use_default_callbacks=False)
        subscription = self.create_subscription(
            msg_type, topic, from_outside, qos, event_callbacks=quiet, raw=raw
        )
        self._teardown.append(lambda: self.destroy_subscription(subscription))
        count, local = subscription.get_publisher_count, self.local
        if local is not None:
            name = subscription.topic_name
            self._teardown.append(local.subscribe(name, from_inside))
            count = partial(_sum, count, partial(local.count_publishers, name))
        if needed:
            self._links.append((count, topic))
        return count

    def add_publisher(
        self, msg_type: type, topic: str, qos: QoSProfile | int, *, needed: bool = False
    ) -> Callable:
        """Return a publish function; a `needed` topic must have a subscription before the graph is
        connected.
        """
        publish_outside, publish_inside, _count = self._advertise(msg_type, topic, qos, needed)
        if publish_inside is None:
            return publish_outside

        def publish(message: Any) -> None:
            publish_inside(message)
            publish_outside(message)

        return publish

    def add_sample_publisher(
        self,
        exchange: Exchange,
        topic: str,
        qos: QoSProfile,
        *,
        frame: str = "",
        needed: bool = False,
    ) -> Callable[[Any], None]:
        """Return a function that publishes a sample, as `add_publisher`. A message is made only
        when somebody outside of this process receives it. `frame`: frame id of the messages.
        """
        publish_outside, publish_inside, count = self._advertise(
            exchange.msg_type, topic, qos, needed
        )
        message, fill = exchange.msg_type(), exchange.fill
        message.header.frame_id = frame

        def publish(sample: Any) -> None:
            if publish_inside is not None:
                publish_inside(sample)
            if count():
                fill(sample, message)
                publish_outside(message)

        return publish

    def _advertise(
        self, msg_type: type, topic: str, qos: QoSProfile | int, needed: bool
    ) -> tuple[Callable[[Any], None], Callable[[Any], None] | None, Callable[[], int]]:
        """Functions that publish a message outside and anything inside of this process, and the
        number of subscriptions outside."""
        quiet = PublisherEventCallbacks(use_default_callbacks=False)
        publisher = self.create_publisher(msg_type, topic, qos, event_callbacks=quiet)
        self._teardown.append(lambda: self.destroy_publisher(publisher))
        count, local = publisher.get_subscription_count, self.local
        everybody, inside = count, None
        if local is not None:
            name = publisher.topic_name
            self._teardown.append(local.advertise(name))
            everybody = partial(_sum, count, partial(local.count_subscribers, name))
            keep = isinstance(qos, QoSProfile) and (
                qos.durability == DurabilityPolicy.TRANSIENT_LOCAL
            )
            inside = partial(local.publish, name, keep=keep)
        if needed:
            self._links.append((everybody, topic))
        return publisher.publish, inside, count

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

    def add_timer(self, period: float, callback: Callable):
        timer = self.create_timer(period, callback)
        self._teardown.append(lambda: self.destroy_timer(timer))
        return timer

    def end_with_trouble(self, trouble: str) -> None:
        """Report a trouble and end the node, when its device does not return by itself."""
        self.troubles.begin(trouble)
        self.ended = True

    # life cycle
    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        try:
            check_parameter_names(self)
            self.parameters = read_parameter_set(self, self.PARAMETERS)
            self.configure(self.parameters)
        except (ValueError, OSError) as error:
            self.get_logger().error(f"not configured: {_words(error)}")
            return TransitionCallbackReturn.FAILURE
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        self._open_diagnostics()
        self.connect()
        if self.MEASURES and not self.get_parameter("constants_from").value:
            self.troubles.begin("not_calibrated")
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        while self._teardown:
            self._teardown.pop()()
        self._links.clear()
        self._publish_status = None
        return super().on_deactivate(state)

    def _check(self, parameters) -> SetParametersResult:
        try:
            values = {p.name: p.value for p in parameters if p.name not in SHELL_KEYS}
            self.apply_changes(read_parameter_set(self, self.PARAMETERS, values))
        except ValueError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def apply_changes(self, parameters: Any) -> None:
        """Refuse a change at run time (ValueError); overridden where the core can change its
        parameters."""
        if getattr(self, "parameters", None) not in (None, parameters):
            raise ValueError(
                f"{self.get_name()}: parameters are read when the node is configured; "
                "set them in the parameter file, or deactivate, clean up and configure again"
            )

    # troubles
    def _open_diagnostics(self) -> None:
        everybody = self.add_publisher(DiagnosticArray, "diagnostics", 10)
        if self.OWNS_BUS:
            self._publish_status = everybody
            hear = self._collector.store_status
            self.add_subscription(DiagnosticArray, OF_NODES, hear, 100, needed=False)
        else:
            owner = self.add_publisher(DiagnosticArray, OF_NODES, 10)
            heard = partial(self.count_subscribers, OF_NODES)
            self._publish_status = lambda message: (owner if heard() else everybody)(message)
        self._missed_from = time.monotonic() + TO_COME
        self.add_timer(1.0, self._look)

    def _look(self) -> None:
        """Once a second: report missing partners and publish the troubles."""
        missing, now = self.missing_partners(), time.monotonic()
        if not missing:
            self._missed_from = now + TO_COME_BACK
            self.troubles.end("unconnected")
        elif now > self._missed_from:
            self.troubles.begin("unconnected", "no partner on " + ", ".join(missing))
        for name, silent in self._collector.silence_by_node().items():
            if silent:
                self.troubles.begin("node_silent", name, of=name)
            else:
                self.troubles.end("node_silent", of=name)
        self._publish_troubles()

    def _publish_troubles(self) -> None:
        if self._publish_status is None:
            return
        own = self.troubles.status(self.diagnostic_values())
        message = DiagnosticArray(status=[own, *self._collector.statuses()])
        set_stamp(message.header, self.bench_ns())
        self._publish_status(message)

    def missing_partners(self) -> list[str]:
        """Needed topics without a partner."""
        return sorted({topic for count, topic in self._links if count() == 0})

    def _connected(self, _request, response):
        missing = self.missing_partners()
        response.success = not missing
        response.message = "" if response.success else "no partner on " + ", ".join(missing)
        return response


def fill_response(
    response: Any, accepted: bool, reason: str, cycle: int = 0, **fields: Any
) -> Any:
    """Fill a service response of the bench or std_srvs; `cycle`: first cycle with the effect."""
    if hasattr(response, "success"):
        response.success, response.message = accepted, reason
        return response
    response.accepted, response.reason = accepted, reason
    if hasattr(response, "cycle"):
        response.cycle = max(cycle, 0)
    for name, value in fields.items():
        setattr(response, name, value)
    return response


def _sum(*counts: Callable[[], int]) -> int:
    return sum(count() for count in counts)


def prepare_nodes(nodes: Sequence[Any]) -> None:
    """Request the real-time scheduling of the most urgent node; `flatplank doctor` shows whether
    it is allowed."""
    key = "fifo_priority"
    wanted = [n.get_parameter(key).value for n in nodes if n.has_parameter(key)]
    nodes[0].get_logger().debug(prepare_threads(max(wanted, default=0)))


def run_node(make: Callable[[], Any], args: list[str] | None = None) -> int:
    """Start a node, spin it until it is told to end, and let it finish its work."""
    return run_nodes([make], args)


def run_nodes(
    makes: Sequence[Callable[..., Any]],
    args: list[str] | None = None,
    *,
    local: bool = False,
    beside: Sequence[Callable[..., Any]] = (),
) -> int:
    """Start the nodes of one process, spin them until they are told to end, and let them finish
    their work. `local`: samples of `makes` for each other go there without the middleware.
    `beside`: further nodes that communicate by the middleware alone.

    Under `ros2 launch` Ctrl-C arrives twice in a row, and ROS must still run when a node closes
    its bag or its bus. So the signals only set a flag.
    """
    told_to_end: list[int] = []

    def record_signal(number: int, _frame: Any) -> None:
        told_to_end.append(number)
        # once is enough: Python removes its handlers while it ends, and a further Ctrl-C
        # would then give a bad exit code
        for each in ENDING:
            signal.signal(each, signal.SIG_IGN)

    for number in ENDING:
        signal.signal(number, record_signal)
    end_with_parent()
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    try:
        return _live(makes, told_to_end, local, [_participant(make, args) for make in beside])
    except (ParameterException, InvalidParameterTypeException) as error:
        print(f"not started: {' '.join(str(error).split())}", file=sys.stderr)
        return 1
    except Exception as error:
        print(f"ended by {type(error).__name__}: {_error_text(error)}", file=sys.stderr)
        end_within(TO_END, 70)
        return 70
    finally:
        rclpy.try_shutdown()


def _participant(make: Callable[..., Any], args: list[str] | None) -> Callable[[], Any]:
    """A function that makes a node as a participant of its own."""
    context = Context()
    context.init(args)
    return partial(make, context=context)


def _live(
    makes: Sequence[Callable[[], Any]],
    told_to_end: list[int],
    local: bool,
    beside: Sequence[Callable[[], Any]],
) -> int:
    """Run the nodes from construction to their end; returns the exit code."""
    executor = StreamExecutor()
    topics = LocalTopics(executor.due.append) if local else None
    nodes = []
    for make in makes:
        node = make()
        if topics is not None:
            node.local = topics
        nodes.append(node)
    nodes += [make() for make in beside]
    failed = not all(map(_started, nodes))
    for node in nodes:
        executor.add_node(node)
    prepare_nodes(nodes)
    if not failed:
        report_started()
    try:
        while not failed and rclpy.ok() and not told_to_end:
            executor.spin_once(timeout_sec=LOOK_AT_SIGNALS)
            failed = any(getattr(node, "ended", False) for node in nodes)
    finally:
        executor.release_entities()
        for node in nodes:
            getattr(node, "finish", lambda: None)()
    code = 1 if failed else 0
    end_within(TO_END, code)
    return code


def _started(node: Any) -> bool:
    """Configure and activate a node that starts by itself; false when the node refuses."""
    if not (isinstance(node, LifecycleNode) and node.get_parameter("autostart").value):
        return True
    ok = TransitionCallbackReturn.SUCCESS
    return node.trigger_configure() == ok and node.trigger_activate() == ok


def _words(error: Exception) -> str:
    """The error on one line; for an OSError its file and reason, without its number."""
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    return " ".join(str(error).split())


def _error_text(error: Exception) -> str:
    """The error on one line, with the path of the file that holds its traceback."""
    words = _words(error)
    try:
        handle, path = tempfile.mkstemp(prefix="flatplank-trace-", suffix=".txt")
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write("".join(traceback.format_exception(error)))
    except OSError:
        return words
    return f"{words}; its trace is in {path}"
