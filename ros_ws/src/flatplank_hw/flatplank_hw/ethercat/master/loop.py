# SPDX-License-Identifier: Apache-2.0
"""The loop of the bus process, in one thread; outputs are written just before they are sent."""

from __future__ import annotations

import time
from collections import deque
from typing import Any, NamedTuple

from flatplank_hw.bus.histogram import Histogram
from flatplank_hw.bus.image import AXES, BusInputs, Health
from flatplank_hw.ethercat.busfile import BusFile
from flatplank_hw.ethercat.master.guard import Cause, Guard
from flatplank_hw.ethercat.master.health import (
    CycleObservation,
    HealthMonitor,
    RecoveryPolicy,
    RecoveryStep,
)
from flatplank_hw.ethercat.master.image import InputImage, OutputImage
from flatplank_hw.ethercat.master.interface import BusError, link_trouble
from flatplank_hw.ethercat.master.link import ParentLink
from flatplank_hw.ethercat.master.pacing import AnswerWait, CommandInbox, CycleClock
from flatplank_hw.ethercat.master.sdo import SdoQueue
from flatplank_hw.ethercat.master.soem import SoemBus

STATE_POLL = 10
"""cycles between readings of the AL states; they are also read when a fault is suspected"""
MAILBOX_POLL_S = 0.008
"""time between checks of one mailbox; the mailboxes take turns [s]"""
SILENT = 25
"""cycles without an answer after which the wire counts as silent"""
LINK_POLL = 5
"""cycles between checks of the interface on a silent wire"""
STOP_S = 0.4
"""longest wait for the axes to stop before the bus is shut down [s]"""
TURNING = 2000
"""an axis turns above this motor speed [counts/s]"""
EMERGENCIES = 20
"""number of emergency messages kept for the diagnostics"""


class Timing(NamedTuple):
    """Timing options of the loop; the defaults are for a real bus."""

    slip: bool = False
    """after a stall the cycle numbers go on without a gap"""
    reply_timeout_s: float = 0.0
    """a later answer counts as lost; 0: 2 ms, at most 0.6 of the period [s]"""
    node_timeout_s: float = 0.0
    """longest wait of a cycle for the nodes' answer to the last one; 0: no wait [s]"""
    batch: int = 1
    """the nodes answer the last of this many cycles"""


class Emergency(NamedTuple):
    """An emergency message of a slave."""

    cycle: int
    slave: str
    code: int
    register: int


class BusLoop:
    """One running bus."""

    def __init__(
        self, bus: BusFile, soem: SoemBus, link: ParentLink, scheduling: str, timing: Timing
    ) -> None:
        self.bus = bus
        self.soem = soem
        self.link = link
        self.scheduling = scheduling
        self.running = True
        self.outputs = OutputImage(bus)
        self.decoder = InputImage(bus)
        self.monitor = HealthMonitor(soem.expected)
        self.guard = Guard(bus.rate_hz, bus.command_timeout_ms)
        self.recovery = RecoveryPolicy()
        self.sdos = SdoQueue(bus, link.send_message)
        self.cycle_times, self.round_trips = Histogram(), Histogram()
        self.emergencies: deque[Emergency] = deque(maxlen=EMERGENCIES)
        self.health = Health.LOST
        self.inputs: BusInputs | None = None
        self.inbox = CommandInbox()
        self.waiting = AnswerWait(timing.node_timeout_s, timing.batch)
        self.timing = timing
        self.clock = CycleClock(bus.period_ns, time.perf_counter_ns(), timing.slip)
        self._reply_timeout_s = timing.reply_timeout_s or min(bus.period_ns * 0.6e-9, 0.002)
        self._mailboxes = [i for i, s in enumerate(bus.slaves) if s.mailbox is not None]
        self._turn = 0
        self._mailbox_poll = max(round(MAILBOX_POLL_S * bus.rate_hz), 2)
        self._last_start = 0
        self._blank = [bytes((s.input_bits + 7) // 8) for s in bus.slaves]
        self._trouble = ""
        self._arrived = False
        self._missed = 0
        soem.emergency = self._emergency

    def start(self) -> None:
        """Bring the bus to OP; BusError on failure."""
        self.soem.scan()
        self.soem.configure()
        self.soem.to_op(self.outputs.encode((), 0, 0))
        self.clock = CycleClock(self.bus.period_ns, time.perf_counter_ns(), self.timing.slip)

    def run(self) -> None:
        """Cycle until told to stop or the parent has ended; then stop the axes."""
        while self.running and not self.link.parent_gone:
            self.run_cycle()
        self._stop_axes()

    def run_cycle(self) -> None:
        """One cycle, and housekeeping in the remaining time."""
        waited = self.waiting.waited_ns
        commands = self.waiting.wait_for_cycle(
            self.clock.cycle + 1,
            self._last_start,
            self.clock.due(),
            self.link.await_commands,
            lambda: self.running and not self.link.parent_gone,
        )
        self.clock.extend(self.waiting.waited_ns - waited)
        now = time.perf_counter_ns()
        if self._last_start:
            self.cycle_times.add(now - self._last_start)
        self._last_start = now
        cycle = self.clock.advance(now)
        self.inbox.commands_in_force(commands)
        self.inputs = self._exchange(cycle)
        self.link.publish(self.guard.with_held_axes_in_fault(self.inputs))
        self._housekeeping(cycle)

    def _exchange(self, cycle: int) -> BusInputs:
        """Exchange one frame with the slaves; returns the inputs of this cycle."""
        asked = self.guard.step(cycle, self.inbox.current, self.inputs, self.health)
        digital = 0
        for command in asked:
            digital |= command.digital_outputs
        data = self.outputs.encode(asked, digital, cycle)
        result = self.soem.exchange(data, self._reply_timeout_s)
        echo_ok = True
        if result.arrived:
            self.round_trips.add(result.round_trip_ns)
            if self.outputs.echo is not None:
                echo_ok = self.soem.output_byte(*self.outputs.echo) == cycle & 0xFF
        self._arrived = result.arrived
        self.health = self.monitor.observe(
            CycleObservation(result.arrived, result.counter, echo_ok)
        )
        good = self.health in (Health.OK, Health.DEGRADED) and result.arrived
        return self._decode(cycle, self.soem.inputs() if good or self.inputs is None else None)

    def _decode(self, cycle: int, data: list[bytes] | None) -> BusInputs:
        """New inputs, or the last good ones with the new cycle number and the present health."""
        stamp = cycle * self.bus.period_ns
        if data is not None and len(data) == len(self._blank):
            return self.decoder.decode(data, cycle, stamp, self.health)
        if self.inputs is None:
            return self.decoder.decode(self._blank, cycle, stamp, self.health)
        return self.inputs._replace(cycle=cycle, stamp_ns=stamp, health=self.health)

    def _housekeeping(self, cycle: int) -> None:
        """One task per cycle: AL states when a fault is suspected, else states, mailboxes or SDOs
        in turn."""
        for request in self.link.requests():
            self._serve(request)
        bad = self.health not in (Health.OK, Health.DEGRADED)
        if bad and not self._arrived and self.monitor.in_a_row % LINK_POLL == 0:
            self.monitor.link = link_trouble(self.soem.interface)
        if self._look_at_states(cycle):
            self.monitor.register_states(self.soem.states())
        elif cycle % self._mailbox_poll == 0 and self._mailboxes and self._arrived and not bad:
            self._turn = (self._turn + 1) % len(self._mailboxes)
            self.soem.poll_mailbox(self._mailboxes[self._turn])
        elif self._arrived or bad:
            self.sdos.serve(self.soem)
        if self.health != Health.OK:
            self._recover()
        else:
            self.recovery.step(time.monotonic(), self.health, ())

    def _look_at_states(self, cycle: int) -> bool:
        """True when the AL states are due: after a stall, and often during a fault; seldom on a
        silent wire, where reading takes 10 ms."""
        if self.clock.missed != self._missed:
            self._missed = self.clock.missed
            return True
        if self._arrived:
            return cycle % STATE_POLL == 0 or (self.monitor.states_in_doubt and cycle % 2 == 0)
        return self.monitor.in_a_row > SILENT and cycle % SILENT == 0

    def _recover(self) -> None:
        states = tuple(s.state for s in self.monitor.faulty)
        step = self.recovery.step(time.monotonic(), self.health, states, not self._arrived)
        if step == RecoveryStep.NONE:
            return
        self.link.send_message(
            {"event": "recovery", "step": step.name, "reason": self.monitor.reason}
        )
        try:
            _RECOVERY[step](self)
        except BusError as error:
            self._trouble = str(error)
        else:
            self._trouble = ""

    def _reconfigure(self) -> None:
        self.soem.reopen()
        if self.soem.mapped and self.soem.reconfigure():
            self.monitor.register_states(self.soem.states())
            self.soem.acknowledge()

    def _rescan(self) -> None:
        self.soem.reopen()
        self.soem.scan()
        self.soem.configure()
        self.soem.to_op(self.outputs.encode((), 0, 0))

    def _serve(self, request: dict[str, Any]) -> None:
        word = request.get("do")
        if word in ("sdo_read", "sdo_write"):
            self.sdos.put(request)
        elif word == "diagnostics":
            self.link.send_message({"id": request["id"], "ok": True, "diagnostics": self.report()})
        elif word == "stop":
            self.running = False
        else:
            self.link.send_message(
                {"id": request["id"], "ok": False, "reason": f"unknown '{word}'"}
            )

    def report(self) -> dict[str, Any]:
        """Data for the diagnostics."""
        m = self.monitor
        return {
            "health": self.health.name,
            "reason": self._trouble or m.reason,
            "not_in_op": {s.name: s.state for s in m.faulty},
            "cycle": self.clock.cycle,
            "rate_hz": self.bus.rate_hz,
            "scheduling": self.scheduling,
            "sent": m.sent,
            "received": m.received,
            "lost": m.lost,
            "missed": self.clock.missed,
            "waited_ms": round(self.waiting.waited_ns / 1e6),
            "given_up": self.waiting.given_up,
            "wrong_counter": m.wrong_counter,
            "stale": m.stale,
            "unread": self.link.unread,
            "history": m.history,
            "recovery": self.recovery.taken,
            "stops": self.guard.stops,
            "held": {AXES[axis]: cause.name for axis, cause in self.guard.latched.items()},
            "emergencies": [e._asdict() for e in self.emergencies],
            "cycle_time": self.cycle_times.report(),
            "round_trip": self.round_trips.report(),
            "echo": self.outputs.echo is not None,
        }

    def _emergency(self, slave: str, code: int, register: int) -> None:
        self.emergencies.append(Emergency(self.clock.cycle, slave, code, register))
        self.link.send_message(
            {"event": "emergency", "slave": slave, "code": code, "register": register}
        )

    def _stop_axes(self) -> None:
        """Quick stop, wait until no axis turns, then disable the voltage."""
        self.guard.hold_all(self.clock.cycle, Cause.STALE_COMMAND)
        until = self.clock.cycle + round(STOP_S * self.bus.rate_hz)
        while self.clock.cycle < until and self._turning():
            self.run_cycle()
        self.guard.braking = 0
        for _ in range(5):
            self.run_cycle()

    def _turning(self) -> bool:
        if self.inputs is None or not self.soem.mapped:
            return False
        return any(abs(axis.velocity) > TURNING for axis in self.inputs.axes)


_RECOVERY = {
    RecoveryStep.REOPEN: lambda loop: loop.soem.reopen(),
    RecoveryStep.ACKNOWLEDGE: lambda loop: loop.soem.acknowledge(),
    RecoveryStep.RECONFIGURE: BusLoop._reconfigure,
    RecoveryStep.RESCAN: BusLoop._rescan,
}
