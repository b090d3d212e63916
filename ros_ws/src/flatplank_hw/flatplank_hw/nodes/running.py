# SPDX-License-Identifier: Apache-2.0
"""Runs the nodes of a process from their start to their end."""

from __future__ import annotations

import inspect
import signal
import sys
from collections.abc import Callable, Sequence
from typing import Any

import rclpy
from rclpy import Context
from rclpy.exceptions import InvalidParameterTypeException, ParameterException
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from flatplank_data.traces import keep_trace
from flatplank_hw.nodes.executor import StreamExecutor
from flatplank_hw.nodes.local import LocalTopics
from flatplank_hw.process import end_with_parent, end_within, prepare_threads, report_started
from flatplank_hw.wording import one_line

ENDING = (signal.SIGINT, signal.SIGTERM)

LOOK_AT_SIGNALS = 0.1
"""a node without messages checks at this interval whether it is to end [s]"""

TO_END = 4.0
"""time for the middleware to shut down after all work of the node is done [s]"""

OUTSIDE = "_outside"
"""hidden node of a shared process, for its clients of services within the process"""


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
) -> int:
    """Start the nodes of one process, spin them until they are told to end, and let them finish
    their work. `local`: their samples for each other go there without the middleware.

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
        return _live(makes, told_to_end, _outside(args) if local else None)
    except (ParameterException, InvalidParameterTypeException) as error:
        print(f"not started: {one_line(error)}", file=sys.stderr)
        return 1
    except Exception as error:
        print(f"ended by {type(error).__name__}: {_error_text(error)}", file=sys.stderr)
        end_within(TO_END, 70)
        return 70
    finally:
        rclpy.try_shutdown()


def _outside(args: list[str] | None) -> Node:
    """A node with a participant of its own: it reaches what the others of its process offer."""
    context = Context()
    context.init(args)
    return Node(OUTSIDE, context=context, enable_rosout=False, start_parameter_services=False)


def _live(makes: Sequence[Callable[[], Any]], told_to_end: list[int], outside: Node | None) -> int:
    """Run the nodes from construction to their end; returns the exit code. `outside`: that of
    nodes which share a participant."""
    executor = StreamExecutor()
    topics = LocalTopics(executor.due.append)
    nodes = []
    for make in makes:
        node = make()
        if outside is not None:
            node.local, node.outside = topics, outside
        nodes.append(node)
    failed = not all(map(_started, nodes))
    for node in (*nodes, *filter(None, [outside])):
        executor.add_node(node)
    prepare_nodes(nodes)
    # rclpy asks who logs, and Python looks through all modules the first time, for 40 ms
    inspect.getframeinfo(sys._getframe())
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


def _error_text(error: Exception) -> str:
    """The error on one line, with the path of the file that holds its traceback."""
    file = keep_trace(error)
    return f"{one_line(error)}; its trace is in {file}" if file else one_line(error)
