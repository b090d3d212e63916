# SPDX-License-Identifier: Apache-2.0
"""Common parts of all nodes of the bench: parameters, life cycle and troubles."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn
from std_srvs.srv import Trigger

from flatplank_data.params import SHELL_KEYS
from flatplank_hw.nodes.convert import set_stamp
from flatplank_hw.nodes.parameters import (
    check_parameter_names,
    declare_parameter_set,
    read_parameter_set,
)
from flatplank_hw.nodes.reporting import OF_NODES, Collector, Reporter
from flatplank_hw.nodes.topics import TopicNode
from flatplank_hw.wording import one_line

TO_COME, TO_COME_BACK = 30.0, 3.0
"""a topic without partner is reported after this time [s]: after the start, later"""
TELL_NS = 1_000_000_000
"""interval of the messages on /diagnostics [ns of bench time]"""


class BenchNode(TopicNode):
    """Lifecycle node around one core.

    A subclass names its parameter class in `PARAMETERS`, makes its core in `configure(parameters)`
    and its subscriptions and publishers in `connect()`. Subscriptions exist only while the node is
    active.
    """

    PARAMETERS: type

    OWNS_BUS = False
    """true: publishes /diagnostics for all nodes; without such a node each publishes its own"""

    MEASURES = False
    """true: the node has calibrated constants, and says so when it was given none"""

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
            self.get_fully_qualified_name(), self.get_logger(), self.publish_troubles
        )
        self._collector = Collector()
        self._told, self._told_ns = False, -TELL_NS
        """whether the troubles were published in this second, and at which bench time last [ns]"""
        self._publish_status: Callable[[DiagnosticArray], None] | None = None
        self.create_service(Trigger, "~/connected", self._connected)

    # to be implemented by a subclass
    def configure(self, parameters: Any) -> None:
        """Make the core; a ValueError refuses the configuration."""

    def connect(self) -> None:
        """Make subscriptions, publishers and services with the helpers of `TopicNode`."""

    def bench_ns(self) -> int:
        """Bench time for the stamps of diagnostics [ns]; the owner of the bus knows it."""
        return self.get_clock().now().nanoseconds

    def diagnostic_values(self) -> Mapping[str, Any]:
        """Values that /diagnostics shows beside the troubles."""
        return {}

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
            self.get_logger().error(f"not configured: {one_line(error)}")
            return TransitionCallbackReturn.FAILURE
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        self._open_diagnostics()
        self.connect()
        if self.MEASURES and not self.get_parameter("constants_from").value:
            self.troubles.begin("not_calibrated")
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.end_topics()
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
        if not self._told:
            self.publish_troubles()
        self._told = False

    def tell_each_second(self) -> None:
        """Publish the troubles once per second of bench time, when a cycle is made; without
        cycles the wall clock does so."""
        if not 0 <= self.bench_ns() - self._told_ns < TELL_NS:
            self._told, self._told_ns = True, self.bench_ns()
            self.publish_troubles()

    def publish_troubles(self) -> None:
        """Publish the troubles now."""
        if self._publish_status is None:
            return
        own = self.troubles.status(self.diagnostic_values())
        message = DiagnosticArray(status=[own, *self._collector.statuses()])
        set_stamp(message.header, self.bench_ns())
        self._publish_status(message)

    def _connected(self, _request, response):
        missing = self.missing_partners()
        response.success = not missing
        response.message = "" if response.success else "no partner on " + ", ".join(missing)
        return response
