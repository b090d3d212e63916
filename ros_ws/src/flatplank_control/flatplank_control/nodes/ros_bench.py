# SPDX-License-Identifier: Apache-2.0
"""The bench for plans, over the topics and services of the ROS graph."""

from __future__ import annotations

import math
import time
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from builtin_interfaces.msg import Time
from rcl_interfaces.srv import GetParameters, SetParametersAtomically
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_srvs.srv import SetBool, Trigger

from flatplank_control.bench.setup import AXIS_NODES, DRIVEN
from flatplank_control.nodes.asking import PendingCalls
from flatplank_control.nodes.bench_samples import BenchSamples
from flatplank_control.nodes.charge import Charge
from flatplank_control.recording.session import NOTHING
from flatplank_control.runner import conditions as when
from flatplank_control.runner import steps as S
from flatplank_control.runner.conditions import (
    QUANTITIES,
    condition_of,
    prompt_of,
    prompt_of_plank,
)
from flatplank_control.runner.measurement import TRIGGER_AT
from flatplank_control.runner.moves import SPEED, by_drive
from flatplank_control.runner.plans import release_axes, safe_end
from flatplank_control.runner.steps import CHUNK, StopDetector, WaitMonitor
from flatplank_data.yaml_text import dump_yaml
from flatplank_hw.drive.requests import RUNNER
from flatplank_msgs.srv import (
    Advance,
    Claim,
    MoveTo,
    PlankSwitch,
    SetOperationMode,
    SetPace,
    SetValue,
    SetWaveform,
    StartRecording,
    StopRecording,
)

PLANT = "simulated_plant"
TICK = 0.25
"""interval between checks of pending calls and of `interrupt` [s]"""
SAMPLES_TIMEOUT_S = 2.0
"""time-out for the samples of a completed cycle [s]"""
ATTEMPTS = 10
"""attempts to get the first samples of a held bus"""
SILENCE = 5.0
"""a bench without messages for this time is gone [s]"""
SERVICE_OF = {
    "load": "load_to",
    "steer_deg": "set_steer_deg",
    "road_camber_deg": "set_road_camber_deg",
    "wheel_camber_deg": "set_wheel_camber_deg",
    "pressure_bar": "set_pressure_bar",
    "cleat_mm": "set_cleat_mm",
}
"""quantity set by hand -> service of the simulated operator"""

AXIS_OF = {node.name: axis for axis, nodes in DRIVEN.items() for node in nodes}
"""node of a driven axis -> the axis"""

Seen = Callable[[], bool]
"""true when the sensors show that it is done"""
Prompt = Callable[[str, Seen], Awaitable[None]]
"""prompt the operator; ends when the operator confirms, or when the sensors show it"""


def _named(name: str, parameters: Mapping[str, float]) -> dict[str, Any]:
    """Fields of a SetWaveform request for a waveform or a profile."""
    values = [float(v) for v in parameters.values()]
    return {"name": name, "parameters": list(parameters), "values": values}


class RosBench:
    """Performs the steps of a plan by service calls; prompts the operator where there is no
    service."""

    def __init__(
        self,
        node: Node,
        samples: BenchSamples,
        *,
        held: bool,
        simulated: bool,
        driven_plank: bool = False,
        folder: str = "",
        prompt: Prompt | None = None,
        say: Callable[[str], None] = lambda _text: None,
    ) -> None:
        """`node`: for clients of services. `held`: the simulated bus makes cycles only on request,
        so that a run can be repeated exactly. `driven_plank`: the plank has a drive instead of the
        switch.
        """
        self.node, self.driven_plank = node, driven_plank
        self.held, self.simulated, self.folder = held, simulated, folder
        self.axes: tuple[str, ...] = ()
        """driven axes that the plan moves beside the wheel; released at a safe end"""
        self.bags: list[str] = []
        self.batch = 1
        self._rate_hz: float | None = None
        self.enough = False
        """true when the operator wants to end the present run and keep it"""
        self.interrupt: Callable[[], None] = lambda: None
        """called during waits; raises when the plan is to end"""
        self.prompt, self._say = prompt, say
        self.begun = False
        """true once a step was performed"""
        self.on_step_time: Callable[[float], None] = lambda _seconds: None
        """called during waits with the time waited [s of bench time]"""
        self._charge = Charge(node)
        self._stops = StopDetector()
        self._stopped = False
        """true when the operator has turned the plank's switch to stop"""
        self._clients: dict[str, Any] = {}
        self._asking = PendingCalls(node)
        self.samples = samples
        self._ticking = node.create_timer(TICK, self._tick)
        call = self.call
        self._do: dict[type, Callable[[Any], Awaitable[Any]]] = {
            S.Manual: self._manual,
            S.Plank: self._plank,
            S.Enable: lambda s: call(SetBool, f"{s.axis}_drive/enable", data=s.on),
            S.Mode: self._mode,
            S.MoveTo: lambda s: call(MoveTo, "wheel_drive/move_to", angle_deg=s.angle_deg),
            S.SlipWaveform: self._waveform,
            S.Arm: lambda _s: call(Trigger, "encoders/arm"),
            S.Record: self._record,
            S.StopRecord: self._stop_record,
            S.FastCycles: self._quick,
            S.Wait: self._wait,
            S.ShowProgress: self._on_say,
            S.Trigger: lambda s: call(SetValue, "wheel_drive/set_trigger", value=s.distance),
            S.HoldLoad: self._hold_load,
            S.AxisProfile: self._profile,
            S.Constants: self._constants,
        }

    def close(self) -> None:
        self.node.destroy_timer(self._ticking)
        self._charge.close()
        self.samples.close()
        for client in self._clients.values():
            self.node.destroy_client(client)

    async def perform(self, step: S.Step) -> None:
        """Perform one step; PlanFailed with the reason when the bench refuses."""
        if not self.begun:
            self.begun = True
            await self._take_charge()
        await self._do[type(step)](step)

    async def _take_charge(self) -> None:
        """Let the axes stop when this process dies, unless a person is in charge. Bench time of
        its own pace does not go with the heartbeats."""
        if self.held or self.simulated and not await self._real_time():
            return
        answer = await self._asking.call(self._charge.claim, Claim.Request(client=RUNNER))
        self._charge.token = answer.token if answer.accepted else ""

    async def _real_time(self) -> bool:
        name = f"{PLANT}/get_parameters"
        found = await self.call(GetParameters, name, names=["pace"])
        return found.values[0].string_value == "realtime"

    async def release_charge(self) -> None:
        """Leave the axes to others, when this process was in charge of them."""
        if self._charge.token:
            self._charge.token = ""
            await self._asking.call(self._charge.claim, Claim.Request(client=""))

    async def end_safely(self, status: str, why: str) -> list[str]:
        """Safe end: disable all drives and close the bag with `status`.

        It does not wait for the operator, only informs, and ignores his requests. Returns the
        refusals, except for a bag that is closed already.
        """
        refused = []
        prompt, interrupt = self.prompt, self.interrupt
        self.prompt, self.interrupt = self._show_to_operator, lambda: None
        for step in (*safe_end(), *release_axes(self.axes), S.StopRecord(status, why)):
            try:
                await self.perform(step)
            except S.PlanFailed as refusal:
                if not str(refusal).endswith(NOTHING):
                    refused.append(str(refusal))
        self.prompt, self.interrupt = prompt, interrupt
        self._stopped = False
        return refused

    async def _show_to_operator(self, text: str, _seen: Seen) -> None:
        self._say(text)

    # waiting
    async def wait_until(self, condition: Callable[[], bool]) -> None:
        """Wait until `condition()`, without limit and also without samples.

        `interrupt` may end the wait.
        """
        while not condition():
            self.interrupt()
            await self.samples.wait_for_sample(listening=False)

    def _tick(self) -> None:
        self._asking.fail_ended_calls()
        self.samples.wake()

    async def advance(self, cycles: int) -> None:
        """Let a held bus make cycles, and wait for the samples of the last one.

        Samples are lost only before DDS has connected a node with this one. A held bus sends no
        more by itself, so until the first samples arrive it is asked for one more cycle.
        """
        cycle = (await self.call(Advance, f"{PLANT}/advance", cycles=cycles)).cycle
        for _ in range(ATTEMPTS):
            heard = self.samples.snapshot() is not None
            end = time.monotonic() + SAMPLES_TIMEOUT_S * (ATTEMPTS if heard else 1)
            while self.samples.sources_without(cycle) and time.monotonic() < end:
                await self.samples.wait_for_sample()
            if not self.samples.sources_without(cycle):
                return
            if heard:
                break
            cycle = (await self.call(Advance, f"{PLANT}/advance", cycles=1)).cycle
        raise S.PlanFailed(
            f"no samples of {', '.join(self.samples.sources_without(cycle))}; is the node running?"
        )

    # services
    async def call(self, kind: Any, name: str, /, **fields: Any) -> Any:
        """Call a service; PlanFailed when it is missing, refuses, or ends without an answer."""
        client = self._clients.get(name)
        if client is None:
            client = self._clients[name] = self.node.create_client(kind, name)
        if not client.wait_for_service(timeout_sec=5.0):
            axis = AXIS_OF.get(name.split("/")[0])
            hint = f" (bench --axes {axis})" if axis else ""
            raise S.PlanFailed(
                f"{client.service_name}: the service is not there; is its node running?{hint}"
            )
        response = await self._asking.call(client, kind.Request(**fields))
        accepted = getattr(response, "accepted", getattr(response, "success", True))
        if not accepted:
            reason = getattr(response, "reason", "") or getattr(response, "message", "")
            raise S.PlanFailed(f"{client.service_name}: {reason}")
        return response

    # steps
    async def _manual(self, step: S.Manual) -> None:
        text = prompt_of(step)
        if not self.simulated:
            if self.prompt is None:
                raise S.PlanFailed(f"nobody to ask: {text}")
            await self.prompt(text, lambda: False)  # no sensor measures it
        elif step.quantity == "unload":
            await self.call(Trigger, f"{PLANT}/unload")
        elif step.quantity == "flexplates":
            await self.call(SetBool, f"{PLANT}/connect_flexplates", data=bool(step.value))
        else:
            await self.call(SetValue, f"{PLANT}/{SERVICE_OF[step.quantity]}", value=step.value)
        timeout = QUANTITIES[step.quantity].timeout
        await self._wait(S.Wait(f"done: {text}", condition_of(step), timeout, 0.2))

    async def _plank(self, step: S.Plank) -> None:
        self._stops.register_command(step)
        if self.driven_plank:
            for part in by_drive(step):
                await self.perform(part)
        elif self.simulated:
            asked = {"direction": step.direction, "fast": step.fast, "stop_at": step.stop_at}
            await self.call(PlankSwitch, f"{PLANT}/plank", **asked)
        elif self.prompt is not None:
            await self._plank_by_hand(step)

    async def _plank_by_hand(self, step: S.Plank) -> None:
        """Prompt for the plank's switch; the encoder confirms a change of motion, otherwise the
        operator."""
        moves = step.direction != 0
        if self._stopped and not moves and not self.samples.plank_moves():
            return
        self._stopped = False
        changes = self.samples.plank_moves() != moves
        assert self.prompt is not None, "asked by _plank"
        await self.prompt(
            prompt_of_plank(step), lambda: changes and self.samples.plank_moves() == moves
        )
        self._stopped = not moves
        if not math.isnan(step.stop_at):
            at = step.stop_at - TRIGGER_AT
            timeout = 1.5 * step.stop_at / SPEED + 20.0
            await self._wait(S.Wait("the plank moves", when.plank_moves(), 5.0))
            await self._wait(S.Wait(f"the plank is at {at:g} m", when.plank_beyond(at), timeout))
            await self._plank_by_hand(S.Plank(0))

    async def _mode(self, step: S.Mode) -> None:
        name = f"{step.axis}_drive/set_operation_mode"
        await self.call(SetOperationMode, name, mode=step.mode, value=step.value)

    async def _waveform(self, step: S.SlipWaveform) -> None:
        await self.call(
            SetWaveform,
            "slip_sequencer/set_waveform",
            **_named(step.name, step.parameters),
            start_position=step.start_position,
            effective_rolling_radius=step.effective_rolling_radius,
        )

    async def _hold_load(self, step: S.HoldLoad) -> None:
        on = not math.isnan(step.fz)
        if on:
            name = AXIS_NODES["vertical"].controller.name
            await self.call(SetValue, f"{name}/set_load", value=step.fz)
        await self._follow("vertical", on)

    async def _profile(self, step: S.AxisProfile) -> None:
        if step.name:
            name = f"{AXIS_NODES[step.axis].controller.name}/set_profile"
            await self.call(SetWaveform, name, **_named(step.name, step.parameters or {}))
            return
        await self._follow(step.axis, step.parameters is not None)

    async def _follow(self, axis: str, on: bool) -> None:
        """Switch the controller of a driven axis on or off."""
        drive = f"{AXIS_NODES[axis].drive.name}"
        if on:
            await self.call(SetOperationMode, f"{drive}/set_operation_mode", mode="follow")
            await self._wait(S.Wait("the mode is heard", lambda _s: True, 1.0, 0.1))
        await self.call(SetBool, f"{drive}/enable", data=on)
        await self._wait(S.Wait(f"the {axis} drive has answered", lambda _s: True, 2.0, 0.5))

    async def _constants(self, step: S.Constants) -> None:
        name = f"{step.node}/set_parameters_atomically"
        wanted = [Parameter(k, value=v).to_parameter_msg() for k, v in step.values.items()]
        answer = await self.call(SetParametersAtomically, name, parameters=wanted)
        if not answer.result.successful:
            raise S.PlanFailed(f"{name}: {answer.result.reason}")

    async def _record(self, step: S.Record) -> None:
        response = await self.call(
            StartRecording,
            "recorder/start",
            name=str(step.record.get("name", "")),
            folder=self.folder,
            record=dump_yaml(dict(step.record)),
            after=self._now(),
            at_once=step.at_once,
        )
        self.bags.append(response.path)

    def _now(self) -> Time:
        """Stamp of the latest samples."""
        s = self.samples.snapshot()
        seconds, nanoseconds = divmod(s.encoders.stamp_ns if s else 0, 1_000_000_000)
        return Time(sec=seconds, nanosec=nanoseconds)

    async def _stop_record(self, step: S.StopRecord) -> None:
        asked = {"status": step.status, "notes": step.notes, "up_to": self._now()}
        await self.call(StopRecording, "recorder/stop", **asked)

    async def _quick(self, step: S.FastCycles) -> None:
        if self.held:
            self.batch = step.fitting(await self._rate())
            await self.call(SetPace, f"{PLANT}/set_pace", pace="hold", batch=self.batch)

    async def _rate(self) -> float:
        """Bus rate of the simulated plant [Hz], requested once."""
        if self._rate_hz is None:
            found = await self.call(GetParameters, f"{PLANT}/get_parameters", names=["rate_hz"])
            self._rate_hz = float(found.values[0].integer_value)
        return self._rate_hz

    async def _wait(self, step: S.Wait) -> None:
        s = self.samples.snapshot() or await self._look_again()
        monitor = WaitMonitor(step, s.encoders.stamp_ns * 1e-9)
        while not monitor.over(s, now := s.encoders.stamp_ns * 1e-9):
            self._stops.check_sample(s.drive)
            self.on_step_time(now - monitor.start)
            self.interrupt()
            if self.enough and step.may_end_early:
                break
            s = await self._look_again()
        self.enough = False

    async def _look_again(self) -> S.Snapshot:
        """The samples of later cycles."""
        if self.held:
            await self.advance(CHUNK * self.batch)
        else:
            before, end = self.samples.raw_drive_message(), time.monotonic() + SILENCE
            while self.samples.raw_drive_message() is before or self.samples.snapshot() is None:
                self.interrupt()
                if time.monotonic() > end:
                    raise S.PlanFailed("the bench is silent: have its nodes ended?")
                await self.samples.wait_for_sample()
        found = self.samples.snapshot()
        assert found is not None, "both branches have waited for samples"
        return found

    async def _on_say(self, step: S.ShowProgress) -> None:
        self._say(step.text)
