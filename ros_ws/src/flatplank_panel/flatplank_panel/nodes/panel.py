# SPDX-License-Identifier: Apache-2.0
"""ROS side of the panel: reads topics into its state, sends requests to the services of the bench.

It puts almost no load on the graph: readers are best effort with depth 1, no writer waits for
them, and a thread takes the latest sample of each 20 times a second instead of callbacks.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
from rcl_interfaces.srv import GetParameters, SetParametersAtomically
from rclpy.action import ActionClient
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

from flatplank_control.runner.steps import BUSY
from flatplank_hw.bus.timing import told_times
from flatplank_hw.nodes import convert
from flatplank_hw.nodes.qos import LATCHED, LATEST
from flatplank_msgs import srv
from flatplank_msgs.action import RunMeasurement
from flatplank_msgs.msg import BusInputs, DriveStatus, EncoderState, HubState, Run, SequencerState
from flatplank_panel.bench_state import POLL_HZ, BenchState, Progress, RunStatus, Samples, Slip
from flatplank_panel.link import Reply

TOPICS = {
    "inputs": (BusInputs, "bus/inputs"),
    "contact": (WrenchStamped, "measurement_hub/wrench_contact"),
    "hub": (HubState, "measurement_hub/state"),
    "encoders": (EncoderState, "encoders/state"),
    "drive": (DriveStatus, "wheel_drive/status"),
    "slip": (SequencerState, "slip_sequencer/state"),
}

ANSWER_TIMEOUT_S = 10.0
"""time-out for an answer of the bench [s]"""
LATE = f"no answer within {ANSWER_TIMEOUT_S:g} s"

PLANT = "simulated_plant"
REQUESTS: dict[str, tuple[type, str]] = {
    "enable": (SetBool, "wheel_drive/enable"),
    "reset_fault": (Trigger, "wheel_drive/reset_fault"),
    "quick_stop": (Trigger, "wheel_drive/quick_stop"),
    "mode": (srv.SetOperationMode, "wheel_drive/set_operation_mode"),
    "move_to": (srv.MoveTo, "wheel_drive/move_to"),
    "waveform": (srv.SetWaveform, "slip_sequencer/set_waveform"),
    "claim": (srv.Claim, "operator/claim"),
    "tare": (Trigger, "measurement_hub/tare"),
    "filter": (SetBool, "measurement_hub/set_parasitic_filter"),
    "load_fit": (srv.LoadParasiticFit, "measurement_hub/load_parasitic_fit"),
    "record": (srv.StartRecording, "recorder/start"),
    "stop_record": (srv.StopRecording, "recorder/stop"),
    "discard": (Trigger, "recorder/discard"),
    "confirm": (Trigger, "measurement_runner/confirm"),
    "plank": (srv.PlankSwitch, f"{PLANT}/plank"),
    "load_to": (srv.SetValue, f"{PLANT}/load_to"),
    "unload": (Trigger, f"{PLANT}/unload"),
    "pressure": (srv.SetValue, f"{PLANT}/set_pressure_bar"),
    "steer": (srv.SetValue, f"{PLANT}/set_steer_deg"),
    "wheel_camber": (srv.SetValue, f"{PLANT}/set_wheel_camber_deg"),
    "road_camber": (srv.SetValue, f"{PLANT}/set_road_camber_deg"),
    "emergency_stop": (SetBool, f"{PLANT}/emergency_stop"),
}
"""request -> service"""
UP_TO = {"stop_record": "up_to"}
"""request -> field for the stamp of the latest bus cycle: a recording has all that was shown"""


def reply_of(response: Any) -> Reply:
    """Convert an answer of the bench: accepted or not, the reason, and the other fields."""
    fields = {name: getattr(response, name) for name in response.get_fields_and_field_types()}
    accepted = bool(fields.pop("accepted", fields.pop("success", True)))
    reason = str(fields.pop("reason", fields.pop("message", "")))
    return Reply(accepted, reason, fields)


class PanelNode:
    """The two ROS nodes and two threads of the panel; a context manager."""

    def __init__(self, state: BenchState, name: str = "panel", namespace: str = "") -> None:
        """`namespace`: ROS namespace of the bench."""
        self.state = state
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        self.node = Node(name, namespace=namespace)
        self._reader = Node(
            f"{name}_reader",
            namespace=namespace,
            start_parameter_services=False,
            enable_rosout=False,
        )
        self._subscriptions = {
            key: self._reader.create_subscription(kind, topic, lambda _m: None, LATEST)
            for key, (kind, topic) in TOPICS.items()
        }
        self._latest: dict[str, Any] = {}
        self._services: dict[str, Any] = {}
        self._heartbeat = self.node.create_publisher(String, "operator/heartbeat", 10)
        self.node.create_subscription(Run, "run", self._on_run, LATCHED)
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, 10)
        self._runner = ActionClient(self.node, RunMeasurement, "run_measurement")
        self._goal: Any = None
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self._over = threading.Event()
        self._threads = [
            threading.Thread(target=work, name=f"panel {work.__name__}", daemon=True)
            for work in (self._spin, self._poll)
        ]

    def __enter__(self) -> PanelNode:
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._executor.shutdown(timeout_sec=2.0)
        for thread in self._threads:
            thread.join(2.0)
        self.node.destroy_node()
        self._reader.destroy_node()
        rclpy.try_shutdown()

    # threads
    def _spin(self) -> None:
        try:
            while not self._over.is_set():
                self._executor.spin_once(timeout_sec=0.2)
        except ExternalShutdownException:
            pass

    def _poll(self) -> None:
        while not self._over.wait(1.0 / POLL_HZ):
            self.take_samples()

    def take_samples(self) -> None:
        """Take the latest message of every topic, and update the state."""
        for key, subscription in self._subscriptions.items():
            with subscription.handle:
                taken = subscription.handle.take_message(subscription.msg_type, False)
            if taken is not None:
                self._latest[key] = taken[0]
        self.state.accept(self._samples(), time.monotonic())

    def _samples(self) -> Samples:
        m = self._latest
        samples = Samples()
        if "inputs" in m:
            samples.inputs = convert.inputs_from_msg(m["inputs"]).cycles[-1]
        if "hub" in m and "contact" in m:
            contact = convert.wrench_from_msg(m["contact"]).wrench
            samples.hub = convert.hub_from_msg(m["hub"])._replace(contact=contact)
        if "encoders" in m:
            samples.encoders = convert.encoders_from_msg(m["encoders"])
        if "drive" in m:
            samples.drive = convert.drive_from_msg(m["drive"])
        if "slip" in m:
            samples.slip = Slip(m["slip"].cycle, m["slip"].reference_slip, m["slip"].actual_slip)
        return samples

    def _on_run(self, msg: Run) -> None:
        self.state.run = RunStatus(msg.name, msg.status)

    def _on_diagnostics(self, msg: DiagnosticArray) -> None:
        """Note the troubles of this bench, and the times of its bus."""
        ours = f"{self.node.get_namespace().rstrip('/')}/"
        own = [s for s in msg.status if s.name.rpartition("/")[0] + "/" == ours]
        if not own:
            return
        self.state.troubles = {
            s.name: s.message for s in own if int.from_bytes(s.level, "little") > 0
        }
        times = (told_times({v.key: v.value for v in s.values}) for s in own)
        self.state.times = next(filter(None, times), None)

    # requests
    async def ask(self, request: str, **fields: Any) -> Reply:
        kind, name = REQUESTS[request]
        if request in UP_TO and "inputs" in self._latest:
            fields[UP_TO[request]] = self._latest["inputs"].header.stamp
        return await self._call(kind, name, fields, reply_of)

    async def _call(
        self, kind: Any, name: str, fields: Mapping[str, Any], read: Callable[[Any], Reply]
    ) -> Reply:
        client = self._services.get(name)
        if client is None:
            client = self._services[name] = self.node.create_client(kind, name)
            self._executor.wake()
        if not await self._wait(client.service_is_ready):
            return Reply(False, f"{client.service_name} does not answer: is the bench running?")
        try:
            response = await self._result(client.call_async(kind.Request(**fields)))
        except asyncio.TimeoutError:
            return Reply(False, f"{client.service_name}: {LATE}")
        return read(response)

    async def set_parameters(self, node: str, values: Mapping[str, Any]) -> Reply:
        parameters = [Parameter(k, value=v).to_parameter_msg() for k, v in values.items()]
        return await self._call(
            SetParametersAtomically,
            f"{node}/set_parameters_atomically",
            {"parameters": parameters},
            lambda r: Reply(r.result.successful, r.result.reason),
        )

    async def get_parameters(self, node: str, names: Sequence[str]) -> dict[str, Any]:
        reply = await self._call(
            GetParameters, f"{node}/get_parameters", {"names": list(names)}, reply_of
        )
        if not reply.accepted:
            return {}
        return {
            name: parameter_value_to_python(value)
            for name, value in zip(names, reply.values["values"], strict=False)
        }

    def send_heartbeat(self, token: str) -> None:
        self._heartbeat.publish(String(data=token))

    def offers(self, request: str) -> bool:
        service = self.node.resolve_service_name(REQUESTS[request][1])
        return any(name == service for name, _ in self.node.get_service_names_and_types())

    def nodes(self) -> list[str]:
        """Nodes of this bench."""
        ours = self.node.get_namespace()
        found = self.node.get_node_names_and_namespaces()
        return sorted({name for name, namespace in found if namespace == ours})

    # measurements
    async def measure(self, plan: str, folder: str, simulated: bool) -> Reply:
        if not await self._wait(self._runner.server_is_ready):
            return Reply(False, "the measurement runner is not there: is the bench running?")
        goal = RunMeasurement.Goal(plan=plan, folder=folder, simulated=simulated, resume=True)

        def send() -> Any:
            sent = self._runner.send_goal_async(goal, self._on_feedback)
            # also for a late answer, so that the measurement can be stopped
            sent.add_done_callback(self._on_goal)
            return sent

        try:
            handle = await self._answer(send)
        except asyncio.TimeoutError:
            return Reply(False, f"the measurement runner: {LATE}")
        return Reply(True) if handle.accepted else Reply(False, BUSY)

    async def cancel(self) -> Reply:
        if self._goal is None or not self.state.progress.active:
            return Reply(False, "no measurement is being made")
        try:
            await self._answer(self._goal.cancel_goal_async)
        except asyncio.TimeoutError:
            return Reply(False, f"the measurement runner: {LATE}; STOP stops the wheel")
        return Reply(True)

    def _on_goal(self, future: Any) -> None:
        handle = future.result()
        if handle.accepted:
            self._goal = handle
            self.state.progress = Progress(active=True, step="begun")
            handle.get_result_async().add_done_callback(self._on_result)

    def _on_feedback(self, message: Any) -> None:
        f = message.feedback
        self.state.progress = Progress(
            True, f.step, f.prompt, f.measurement, f.measurements, f.progress,
            time_left=f.time_left,
        )  # fmt: skip

    def _on_result(self, future: Any) -> None:
        result = future.result().result
        self.state.progress = Progress(message=result.message, bags=list(result.bags))

    # between the event loops
    async def _wait(self, ready: Callable[[], bool], timeout: float = 3.0) -> bool:
        end = time.monotonic() + timeout
        while not ready():
            if time.monotonic() > end:
                return False
            await asyncio.sleep(0.02)
        return True

    async def _answer(self, send: Callable[[], Any]) -> Any:
        """Send to the runner from the thread that receives its answers: an action client has no
        lock, and an answer that arrives before its request is registered is lost.
        """
        return await self._result(await self._result(self._executor.create_task(send)))

    async def _result(self, future: Any) -> Any:
        """Result of a future of rclpy in the event loop of the page."""
        loop = asyncio.get_running_loop()
        ours: asyncio.Future = loop.create_future()

        def hand_over(theirs: Any) -> None:
            if not ours.done():
                ours.set_result(theirs.result())

        def done(theirs: Any) -> None:
            loop.call_soon_threadsafe(hand_over, theirs)

        future.add_done_callback(done)
        return await asyncio.wait_for(ours, ANSWER_TIMEOUT_S)
