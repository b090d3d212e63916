# SPDX-License-Identifier: Apache-2.0
"""Records all topics of the bench into bags: the node around `flatplank_control.recording`."""

from __future__ import annotations

import datetime
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.serialization import deserialize_message
from rclpy.task import Future
from std_srvs.srv import Trigger

from flatplank_control.bench.setup import parse_axes
from flatplank_control.calibration.book import CalibrationBook
from flatplank_control.nodes.asking import NodeParameters, parameter_clients
from flatplank_control.recording.bus_cycles import DIAGNOSTICS, Arrivals
from flatplank_control.recording.filled import in_words, requested_record
from flatplank_control.recording.recovery import repair
from flatplank_control.recording.session import RecordingSession, State
from flatplank_control.recording.topics import (
    ROSOUT,
    RUN_TOPIC,
    TopicSpec,
    at_every_cycle,
    recorded_topics,
    run_message,
)
from flatplank_control.recording.typestore import message_definition, type_hash
from flatplank_control.runner.provenance import InForce, complete_record, software_version, utc_now
from flatplank_data.errors import RecordingError
from flatplank_data.params import Params, param
from flatplank_data.run_record import RunRecord
from flatplank_hw.bus.timing import told_times
from flatplank_hw.nodes import convert
from flatplank_hw.nodes.qos import LATCHED, STREAM
from flatplank_hw.nodes.responses import fill_response
from flatplank_hw.nodes.running import run_node
from flatplank_hw.nodes.support import BenchNode
from flatplank_msgs.msg import OperationMode, Run
from flatplank_msgs.srv import StartRecording, StopRecording

CLOSE_TIMEOUT_S = 5.0
"""time-out for messages in transit when a bag is closed [s]; a lost one is sent again after 3 s"""
MODE = "/wheel_drive/mode"
WITHOUT_HEADER = ("std_msgs/msg/String", ROSOUT.type)
"""types whose messages get the bench time of their arrival"""
INTRODUCTION = 8.0
"""time-out for the first messages of running nodes at a start [s]; clients wait for 10 s"""


@dataclass(frozen=True)
class RecorderParameters(Params):
    """Folder of bags, and what they keep."""

    folder: str = param("data", "data folder; made when it is not there")
    pre_trigger: float = param(
        2.0, "kept from before the motion trigger", unit="s", bounds=(0.0, 60.0)
    )
    axes: str = param("", "driven beside the wheel, as in vertical,steer; empty: none")
    calibration: str = param("", "book that the bench was started with; empty: none")


def message_class(name: str) -> type:
    """`package/msg/Type` -> class."""
    package, _, kind = name.split("/")
    return getattr(import_module(f"{package}.msg"), kind)


def relative(topic: str) -> str:
    """Name in the namespace of the bench of a topic in the bag, which has none."""
    return topic.removeprefix("/")


class RecorderNode(BenchNode):
    """Writes all topics of the table, serialised as received, into one MCAP bag per measurement;
    publishes /run."""

    PARAMETERS = RecorderParameters

    def configure(self, parameters: RecorderParameters) -> None:
        folder = Path(parameters.folder).expanduser()
        folder.mkdir(parents=True, exist_ok=True)
        for repaired in repair(folder):
            self.troubles.report_occurrence("bag_mended", str(repaired))
        self.topics = recorded_topics(parse_axes(parameters.axes, "axes"))
        self.session = RecordingSession(folder, self.topics, pre_trigger=parameters.pre_trigger)
        self.arrivals = Arrivals()
        self.late: int | None = None
        """late cycles that the bus has told of last"""
        self.requested = requested_record("")
        self.mode = ""
        # git runs, types of ROS are read and compiled: samples must not wait when a bag is opened
        software_version()
        for topic in (RUN_TOPIC, *self.topics):
            message_definition(topic.type)
            type_hash(topic.type)
        run_message(RunRecord(), 0)

    def connect(self) -> None:
        self.changed_something: Future | None = None
        self.publish_run = self.add_publisher(Run, "run", LATCHED)
        self.parameters_of = parameter_clients(self.outside)
        for client in self.parameters_of.values():
            self._teardown.append(partial(self.outside.destroy_client, client))
        for spec in self.topics:
            self.record_topic(spec)
        self.add_timer(0.25, self.poll)
        self.add_service(StartRecording, "~/start", self.on_start)
        self.add_service(StopRecording, "~/stop", self.on_stop)
        self.add_service(Trigger, "~/discard", self.on_discard)

    def record_topic(self, spec: TopicSpec) -> None:
        """Subscribe to a topic. The log is not a topic of the bench: ROS publishes it in each
        node, beside the topics within the process."""
        kind, with_header = message_class(spec.type), spec.type not in WITHOUT_HEADER
        receive = partial(self.on_message, spec.name, with_header)
        if spec is ROSOUT:
            log = self.outside.create_subscription(kind, spec.name, receive, STREAM, raw=True)
            self._teardown.append(lambda: self.outside.destroy_subscription(log))
            return
        self.add_serialised_subscription(
            kind, relative(spec.name), receive, LATCHED if spec.qos.latched else STREAM,
            needed=spec.name != DIAGNOSTICS,
        )  # fmt: skip

    def on_message(self, topic: str, with_header: bool, cdr: bytes) -> None:
        if topic == MODE:
            self.mode = deserialize_message(cdr, OperationMode).mode
        elif topic == DIAGNOSTICS:
            self.note_times(deserialize_message(cdr, DiagnosticArray))
        stamp_ns = self.arrivals.bus_ns
        if with_header:
            stamp_ns = self.arrivals.add(topic, convert.raw_stamp_ns(cdr))
        received_ns = self.arrivals.received(topic, stamp_ns, time.monotonic_ns())
        self.reporting_failure(lambda: self.session.write(topic, cdr, stamp_ns, received_ns))
        self.wake_waiting_calls()

    def note_times(self, message: DiagnosticArray) -> None:
        """Note what the bus tells of its late cycles, which only one in real time does."""
        told = [told_times({v.key: v.value for v in status.values}) for status in message.status]
        for times in filter(None, told):
            self.late = times.late
            self.session.cycles.tell_late(times.late)
        self.arrivals.real_time = any(told)

    def wake_waiting_calls(self) -> None:
        """Let the service calls that wait for a message look again."""
        if self.changed_something is not None and not self.changed_something.done():
            self.changed_something.set_result(None)

    async def next_event(self) -> None:
        """Wait for the next message or timer tick; several coroutines may wait."""
        if self.changed_something is None or self.changed_something.done():
            self.changed_something = Future()
        await self.changed_something

    async def wait_for_messages(self, stamp: Time, timeout: float, mode: str = "") -> list[str]:
        """Wait for messages up to `stamp`, at most `timeout` [s], on all topics with a publisher
        that this operation mode uses; returns the topics that lack them."""
        wanted = stamp.sec * 1_000_000_000 + stamp.nanosec
        end = time.monotonic() + timeout
        there = [t for t in at_every_cycle(mode) if self.count_publishers(relative(t))]
        while (behind := self.arrivals.behind(wanted, there)) and time.monotonic() < end:
            await self.next_event()
        return behind

    async def wait_for_parameters(self, asked: NodeParameters, end: float) -> InForce:
        """Wait for parameters of the nodes until `end` of the monotonic clock; warns of missing
        ones."""
        while asked.unanswered() and time.monotonic() < end:
            await self.next_event()
        for name in asked.unanswered():
            self.get_logger().warning(
                f"{name} does not give its parameters: not in the run record"
            )
        return asked.received()

    def poll(self) -> None:
        self.reporting_failure(self.session.poll)
        self.wake_waiting_calls()

    def reporting_failure(self, action: Callable[[], None]) -> None:
        """Do the action; a fault of the recording becomes a trouble and is published on /run."""
        try:
            action()
        except RecordingError as error:
            self.troubles.report_occurrence("recording_failed", str(error))
            self.publish_record()

    def publish_record(self) -> None:
        """Publish the present record on /run."""
        record = self.session.record
        if record is not None:
            message = Run(uuid=record.uuid, name=record.name, status=record.status)
            message.record = record.to_yaml()
            message.header.stamp.sec, message.header.stamp.nanosec = divmod(
                self.arrivals.bus_ns, 1_000_000_000
            )
            self.publish_run(message)

    async def on_start(
        self, request: StartRecording.Request, response: StartRecording.Response
    ) -> StartRecording.Response:
        end = time.monotonic() + INTRODUCTION
        asked = NodeParameters(self.parameters_of, self.wake_waiting_calls)
        silent = await self.wait_for_messages(request.after, INTRODUCTION)
        in_force = await self.wait_for_parameters(asked, end)
        if silent:
            what = f"no message on {', '.join(silent)} although a node publishes it"
            do = "start again in a moment, or start that node anew"
            return fill_response(response, False, f"{what}; {do}")
        try:
            requested = requested_record(request.record, request.name)
            record = requested.record
            record = record.with_changes(started=record.started or utc_now())
            book = CalibrationBook(Path(self.parameters.calibration))
            record = complete_record(record, in_force, book, datetime.date.today())
            path = self.session.start(
                record,
                self.arrivals.bus_ns,
                folder=request.folder or None,
                at_once=request.at_once,
            )
            if self.late is not None:
                self.session.cycles.tell_late(self.late)
        except ValueError as error:
            return fill_response(response, False, str(error))
        self.requested = requested
        self.publish_record()
        begin = "at once" if request.at_once else "with the motion trigger"
        done = f"{path} is recorded, beginning {begin}"
        return fill_response(response, True, done, path=str(path), uuid=record.uuid)

    async def on_stop(
        self, request: StopRecording.Request, response: StopRecording.Response
    ) -> StopRecording.Response:
        silent = await self.wait_for_messages(request.up_to, CLOSE_TIMEOUT_S, self.mode)
        reason = request.notes
        if silent:
            reason = f"{reason}; not heard to the end: {', '.join(silent)}".lstrip("; ")
        recording = self.session.state is State.RECORDING
        status = request.status or ("complete" if recording else "stopped")
        # a client that says how the run ended and what it was has watched it
        watched = request.status and self.requested.has_essential_keys
        fill = None if watched else self.requested.filled_in
        try:
            record = self.session.stop(status, reason=reason, ended=utc_now(), fill=fill)
        except RecordingError as error:
            return fill_response(response, False, str(error))
        self.publish_record()
        if record.cycles_lost:
            lost = f"{record.name}: {record.cycles_lost} lost, {record.cycles_received} there"
            self.troubles.report_occurrence("cycles_lost", lost)
        return fill_response(
            response,
            record.status != "failed",
            "; ".join(filter(None, (record.stop_reason, in_words(record), record.notes))),
            path=str(self.session.path),
            cycles_received=record.cycles_received,
            cycles_lost=record.cycles_lost,
        )

    def on_discard(
        self, _request: Trigger.Request, response: Trigger.Response
    ) -> Trigger.Response:
        try:
            path = self.session.discard()
        except RecordingError as error:
            return fill_response(response, False, str(error))
        self.publish_record()
        return fill_response(response, True, f"{path} is deleted")

    def finish(self) -> None:
        """Close the bag, whatever ends the node."""
        if hasattr(self, "session"):
            self.session.close()


NODE = RecorderNode


def main(args: list[str] | None = None) -> int:
    return run_node(lambda: NODE("recorder"), args)


if __name__ == "__main__":
    raise SystemExit(main())
