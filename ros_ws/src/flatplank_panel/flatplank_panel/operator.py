# SPDX-License-Identifier: Apache-2.0
"""All actions of the operator, checked on the server: who asks, and with what values.

The first argument of a method is the identity of the page; a ValueError is a refusal with its
reason. Pages have no other way to the bench.
"""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any
from uuid import uuid4

from flatplank_data.limits import LIMITS
from flatplank_data.machine import ROAD_LENGTH
from flatplank_data.measured import UNKNOWN
from flatplank_data.params import from_mapping
from flatplank_data.waveforms import WAVEFORMS
from flatplank_data.yaml_text import dump_yaml
from flatplank_hw.drive.modes import MODES
from flatplank_panel import validation as check
from flatplank_panel.charge import PageInCharge
from flatplank_panel.host import Host
from flatplank_panel.link import BenchLink, Reply
from flatplank_panel.validation import CONSTANTS

PREDETERMINED = (0.0, 120.0, 240.0, 360.0, 1080.0)
"""predefined wheel angles, thesis 4.1 [deg]"""
HANDS = {
    "load_to": ("Load", "fz"),
    "pressure": ("Pressure", "pressure"),
    "steer": ("Steering", "steer_deg"),
    "wheel_camber": ("Wheel camber", "wheel_camber_deg"),
    "road_camber": ("Road camber", "road_camber_deg"),
}
"""request -> label and setting, for manual settings of the simulated machine"""
VALUES = {
    "position": ("position", "deg", math.radians(1.0), 100_000.0),
    "velocity": ("velocity", "rad/s", 1.0, 100.0),
    "torque": ("torque", "N m", 1.0, 100.0),
}
"""mode -> name of its value, unit on the page, factor to SI, largest value"""

RENEWAL = 1.0
"""interval between renewals of the claim at the drive [s]"""


class Operator:
    """The actions of the pages on the bench."""

    def __init__(self, link: BenchLink, host: Host, data: Path) -> None:
        self.link, self.host, self.data = link, host, data
        self.charge = PageInCharge()
        self._me = f"panel-{uuid4().hex[:8]}"
        self._token = ""
        self._claimed_at = -math.inf
        self._claim_refused = ""

    # charge
    def take_charge(self, page: str, name: str) -> None:
        self.charge.take_charge(page, check.note(name)[:40] or "another page", time.monotonic())

    async def release_page(self, page: str) -> None:
        if self.charge.holder == page:
            self.charge.release_page(page)
            await self._release()

    def register_heartbeat(self, page: str) -> None:
        """Register a heartbeat of a page; that of the page in charge goes on to the drive."""
        if self.charge.register_heartbeat(page, time.monotonic()) and self._token:
            self.link.send_heartbeat(self._token)

    async def supervise(self) -> None:
        """Keep the claim at the drive consistent with the page in charge; call a few times a
        second. A measurement ends with its page: the drive would take nobody for in charge, and
        the wheel would turn again without a heartbeat."""
        now = time.monotonic()
        if self.charge.release_if_silent(now):
            self.add_to_log("the page in charge has gone; nobody is in charge")
            if self.link.state.progress.active:
                reply = await self.link.cancel()
                self.add_to_log(reply.reason or "measurement is being stopped")
            await self._release()
        if not self.link.state.running(now):
            self._token = ""
        elif not self.charge.holder:
            await self._release()
        elif not self._token or now - self._claimed_at > RENEWAL:
            reason = await self._claim()
            if reason and reason != self._claim_refused:
                self.add_to_log(f"charge of the drive: {reason}")
            self._claim_refused = reason

    async def _claim(self) -> str:
        """Claim the drive or renew the claim, which lapses without heartbeats; returns the
        refusal."""
        self._claimed_at = time.monotonic()
        reply = await self.link.ask("claim", client=self._me)
        self._token = str(reply.values["token"]) if reply.accepted else ""
        return "" if reply.accepted else reply.reason

    async def _release(self) -> None:
        token, self._token = self._token, ""
        if token and self.link.state.running(time.monotonic()):
            await self.link.ask("claim", client="")

    # bench
    async def start_bench(self, page: str, wishes: Mapping[str, Any]) -> str:
        """Start the nodes; `wishes`: arguments of `Host.start`."""
        self.charge.require_charge(page)
        if self.link.state.running(time.monotonic()):
            raise ValueError("a bench is running already, started elsewhere; the page uses it")
        setup = await asyncio.to_thread(partial(self.host.start, **wishes))
        return self.add_to_log(f"bench {setup.kind} started, tire {setup.tire}")

    async def stop_bench(self, page: str) -> str:
        self.charge.require_charge(page)
        if not self.host.running:
            raise ValueError("this page has not started the bench; stop it where it was started")
        self._token = ""
        await asyncio.to_thread(self.host.stop)
        return self.add_to_log("bench stopped")

    async def emergency_stop(self, page: str) -> str:
        """Emergency stop, allowed for every page: stops the wheel, and presses the button of a
        simulated plant.

        Raises ValueError when a part has refused."""
        del page
        mushroom = self.link.offers("emergency_stop")
        jobs = [self.link.ask("quick_stop")]
        if mushroom:
            jobs.append(self.link.ask("emergency_stop", data=True))
        replies = await asyncio.gather(*jobs)
        parts = [
            f"{what} stops" if reply.accepted else f"{what} NOT stopped: {reply.reason}"
            for what, reply in zip(("wheel", "plank"), replies, strict=False)
        ]
        if not mushroom:
            parts.append("the plank is stopped by its own switch")
        text = self.add_to_log("STOP: " + "; ".join(parts))
        if not all(reply.accepted for reply in replies):
            raise ValueError(text)
        return text

    async def release_emergency_stop(self, page: str) -> str:
        return await self._send_claimed(
            page, "emergency_stop", "emergency stop released", data=False
        )

    def log_ended_nodes(self) -> None:
        """Log nodes started by this panel that have ended by themselves."""
        for name, code in self.host.newly_ended().items():
            self.add_to_log(
                f"{name} has ended by itself (exit code {code}), see {self.host.log.name}; "
                "stop the bench and start it again"
            )

    # drive
    async def enable(self, page: str, on: bool) -> str:
        if not on:
            return await self._send(page, "enable", "disabled", data=False)
        return await self._send_claimed(page, "enable", "enabled", data=True)

    async def reset_fault(self, page: str) -> str:
        return await self._send_claimed(page, "reset_fault", "fault reset")

    async def quick_stop(self, page: str) -> str:
        return await self._send(page, "quick_stop", "quick stop")

    async def set_mode(self, page: str, mode: str, value: Any = 0.0) -> str:
        check.choice(mode, MODES, "mode")
        text, si = mode, 0.0
        if mode in VALUES:
            what, unit, factor, largest = VALUES[mode]
            given = check.number(value, what, -largest, largest, unit)
            text, si = f"{mode} {given:g} {unit}", given * factor
        return await self._send_claimed(page, "mode", f"mode {text}", mode=mode, value=si)

    async def move_to(self, page: str, angle_deg: Any) -> str:
        angle = check.number(angle_deg, "position", -1e5, 1e5, "deg")
        return await self._send_claimed(page, "move_to", f"turn to {angle:g} deg", angle_deg=angle)

    async def set_waveform(
        self, page: str, name: str, values: Mapping[str, Any], start: Any, radius: Any
    ) -> str:
        """Set the waveform and select slip control."""
        self.charge.require_charge(page)
        wave = waveform_of(name, values)
        known = {k: float(getattr(wave, k)) for k in values}
        text = f"{name} from {start} m with r_e {radius} m"
        request = {
            "name": name, "parameters": list(known), "values": list(known.values()),
            "start_position": check.setting(start, "step_position"),
            "effective_rolling_radius": check.setting(radius, "effective_rolling_radius"),
        }  # fmt: skip
        await self._send_claimed(page, "waveform", text, **request)
        return await self.set_mode(page, "slip")

    # measurement hub
    async def tare(self, page: str) -> str:
        text = await self._send_claimed(page, "tare", "zero is being taken")
        self.link.state.zero_taken = True
        return text

    async def set_filter(self, page: str, on: bool) -> str:
        text = f"parasitic filter {'on' if on else 'off'}"
        return await self._send_claimed(page, "filter", text, data=bool(on))

    async def load_fit(self, page: str, file: str) -> str:
        path = check.inside(self.data, file, "file")
        text = f"parasitic fit {path.name} loaded"
        return await self._send_claimed(page, "load_fit", text, file=str(path))

    async def set_constants(self, page: str, values: Mapping[str, Any]) -> str:
        """Set parameters of hub and encoders; for each node all or none."""
        self.charge.require_charge(page)
        by_node: dict[str, dict[str, float]] = {}
        for name, value in values.items():
            constant = CONSTANTS[check.choice(name, CONSTANTS, "constant")]
            low, high = constant.info.bounds or (-math.inf, math.inf)
            number = check.number(value, constant.info.note, low, high, constant.info.unit)
            by_node.setdefault(constant.node, {})[name] = number
        for node, part in by_node.items():
            self._judge(await self.link.set_parameters(node, part))
        return self.add_to_log("constants: " + ", ".join(f"{k} = {v}" for k, v in values.items()))

    async def constants(self) -> dict[str, float]:
        """Present constants of the nodes."""
        found: dict[str, float] = {}
        for node in sorted({c.node for c in CONSTANTS.values()}):
            names = [c.name for c in CONSTANTS.values() if c.node == node]
            found |= await self.link.get_parameters(node, names)
        return found

    # recording
    async def record(
        self, page: str, name: str, folder: str, note: str, at_once: bool, facts: Mapping[str, Any]
    ) -> str:
        """Arm the recorder; it writes from the motion trigger on, or at once."""
        self.charge.require_charge(page)
        record = {"tire": UNKNOWN} | dict(facts)
        record |= {"name": check.name(name), "notes": check.note(note)}
        record["operator"] = self.charge.name
        where = str(check.folder_below(self.data, folder))
        request = {"name": record["name"], "folder": where, "at_once": bool(at_once)}
        request["record"] = dump_yaml(record)
        return await self._send_claimed(page, "record", f"recording {name}", **request)

    async def save_recording(self, page: str) -> str:
        return await self._send_claimed(
            page, "stop_record", "recording saved", status="complete", notes=""
        )

    async def discard_recording(self, page: str) -> str:
        return await self._send_claimed(page, "discard", "recording discarded")

    async def measure(self, page: str, plan: str | Mapping[str, Any], folder: str) -> str:
        """Make a whole measurement, or a campaign from the text of its plan."""
        await self._in_charge(page)
        text = plan if isinstance(plan, str) else dump_yaml(dict(plan))
        target = str(check.folder_below(self.data, folder))
        # the simulated operator makes manual settings without a prompt
        simulated = self.link.offers("load_to")
        self._judge(await self.link.measure(text, target, simulated))
        return self.add_to_log("measurement begun")

    async def cancel_measurement(self, page: str) -> str:
        self.charge.require_charge(page)
        self._judge(await self.link.cancel())
        return self.add_to_log("measurement is being stopped")

    async def confirm_prompt(self, page: str) -> str:
        return await self._send_claimed(page, "confirm", "confirmed")

    # manual settings of the simulated machine
    async def set_by_hand(self, page: str, what: str, value: Any) -> str:
        label, setting = HANDS[check.choice(what, HANDS, "quantity")]
        number = check.setting(value, setting)
        text = f"{label} {number:g} {LIMITS[setting].unit}"
        return await self._send_claimed(page, what, text, value=number)

    async def unload(self, page: str) -> str:
        return await self._send_claimed(page, "unload", "wheel lifted")

    async def move_plank(
        self, page: str, direction: int, fast: bool = True, stop_at: Any = None
    ) -> str:
        word = {1: "forward", 0: "stop", -1: "reverse"}[int(direction)]
        limit = math.nan
        if stop_at not in (None, ""):
            limit = check.number(stop_at, "stop position", -1.0, ROAD_LENGTH, "m")
        move = self._send_claimed if direction else self._send
        request = {"direction": int(direction), "fast": bool(fast), "stop_at": limit}
        return await move(page, "plank", f"plank {word}", **request)

    # helpers
    async def _in_charge(self, page: str) -> None:
        """Raise ValueError unless the page is in charge here and this panel at the drive."""
        self.charge.require_charge(page)
        self._judge(Reply(not (reason := await self._claim()), reason))

    async def _send_claimed(self, page: str, request: str, text: str, /, **fields: Any) -> str:
        """Send a request that may cause motion; the drive must be claimed before."""
        await self._in_charge(page)
        return await self._send(page, request, text, **fields)

    async def _send(self, page: str, request: str, text: str, /, **fields: Any) -> str:
        """Send a request that needs no claim, such as a stop."""
        self.charge.require_charge(page)
        self._judge(await self.link.ask(request, **fields))
        return self.add_to_log(text)

    def _judge(self, reply: Reply) -> None:
        if not reply.accepted:
            self.add_to_log(f"refused: {reply.reason}")
            raise ValueError(reply.reason)

    def add_to_log(self, text: str) -> str:
        """Add a line to the log that every page shows."""
        self.link.state.log.appendleft((time.strftime("%H:%M:%S"), text))
        return text


def waveform_of(name: str, values: Mapping[str, Any]) -> Any:
    """The waveform from the inputs of a page, slips as fractions; ValueError names the fault."""
    kind = WAVEFORMS[check.choice(name, WAVEFORMS, "waveform")]
    numbers = {k: check.number(v, k, -1e6, 1e6) for k, v in values.items()}
    return from_mapping(kind, numbers, f"waveform {name}")
