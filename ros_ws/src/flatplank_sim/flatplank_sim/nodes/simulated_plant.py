# SPDX-License-Identifier: Apache-2.0
"""Node of the simulated plant; it owns the bus with a simulated process image."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

from rclpy.task import Future
from rosgraph_msgs.msg import Clock

from flatplank_data.limits import Limit
from flatplank_data.params import Params, param
from flatplank_hw.bus.commanders import CommandGate
from flatplank_hw.bus.histogram import percentile
from flatplank_hw.bus.image import AXES, AxisCommand
from flatplank_hw.bus.pacing import PACES, Pacer
from flatplank_hw.bus.timing import BusTiming
from flatplank_hw.cia402 import ENABLE_OPERATION
from flatplank_hw.nodes import convert, exchanges
from flatplank_hw.nodes.partners import LOOK_S, Partners
from flatplank_hw.nodes.qos import STREAM
from flatplank_hw.nodes.reporting import SHOWN
from flatplank_hw.nodes.responses import fill_response
from flatplank_hw.nodes.running import run_node
from flatplank_hw.nodes.second_commander import COMMANDS, report_refused_commands
from flatplank_hw.nodes.support import BenchNode
from flatplank_msgs.srv import Advance, SetPace
from flatplank_sim.nodes.operator_services import OperatorServices
from flatplank_sim.plant import Plant, PlantConfig

MAX_BATCH = 50
LONGEST_ADVANCE_S = 3600.0
"""longest bench time of one call of `advance` [s]"""
CLOCK_CYCLES = 10
"""fewest cycles between two messages on /clock"""


@dataclass(frozen=True)
class PlantParameters(Params):
    """Parameters of the simulated plant and its pace."""

    tire: str = param("toyo", "tire mounted: toyo, continental, michelin, racing or your own file")
    preset: str = param("", "defects switched on together, for instance thesis2023; empty: none")
    config: str = param("", "YAML file that is laid over the plant's own; empty: none")
    seed: int = param(1, "seed of noise and of anything random", bounds=(0, 2**31 - 1))
    rate_hz: int = param(250, "bus rate", unit="Hz", bounds=(50, 1000))
    batch: int = param(1, "cycles per message", bounds=(1, MAX_BATCH))
    pace: str = param("realtime", "how bench time runs", choices=PACES)
    wall_timeout: float = param(
        1.0, "lockstep: an answer is overdue after this time", unit="s", bounds=(0.001, 60.0)
    )
    driven_axes: tuple[str, ...] = param(
        ("wheel",),
        f"axes with a drive, whose nodes are waited for in lockstep, of {', '.join(AXES)}",
    )


class SimulatedPlant(BenchNode):
    """Publishes /bus/inputs, subscribes to /bus/outputs, has the services of the operator."""

    PARAMETERS = PlantParameters
    OWNS_BUS = True

    def configure(self, p: PlantParameters) -> None:
        config = PlantConfig.load(
            p.tire, preset=p.preset or None, file=p.config or None,
            overrides={"driven_axes": list(p.driven_axes)} if len(p.driven_axes) > 1 else None,
        )  # fmt: skip
        self.driven = frozenset(AXES.index(axis) for axis in config.driven_axes)
        self.plant = Plant(config, p.seed, p.rate_hz)
        Plant(config, p.seed, p.rate_hz).step()  # load the kernels before the clock starts
        self.period_ns = 1_000_000_000 // p.rate_hz
        self.pacer = Pacer(p.pace, p.batch, self.driven, p.wall_timeout)
        self.commands: dict[int, AxisCommand] = {}
        self.commanders = Partners()
        self.gate = CommandGate()
        self.cycle, self.clock_cycle = -1, -CLOCK_CYCLES
        """latest cycle, and that of the latest message on /clock"""
        self.t0 = 0 if p.pace != "realtime" else time.time_ns() // self.period_ns * self.period_ns
        self.waiting: list[tuple[int, Future]] = []
        self.ages = [0] * 64
        """histogram of the age of commands [cycles]"""
        self.timing = BusTiming()

    def connect(self) -> None:
        p = self.parameters
        self.clock = Clock()
        self.publish = self.add_sample_publisher(
            exchanges.INPUTS, "bus/inputs", STREAM, frame="bus", needed=True
        )
        self.publish_clock = self.add_publisher(Clock, "clock", 10)
        count = self.add_sample_subscription(
            exchanges.COMMAND, COMMANDS, self.on_command, STREAM,
            from_inside=lambda stamped: self.on_command(stamped, inside=True),
        )  # fmt: skip
        self.commanders.add(COMMANDS, count)
        self.skipped, self.slow_at = 0, 0.0
        """number of reported lost batches, and time of the report [s]"""
        self.tick = self.add_timer(p.batch / p.rate_hz, self.on_tick)
        self.add_timer(LOOK_S, self.look_for_drives)
        self.add_timer(1.0, self.on_second)
        self.add_service(Advance, "~/advance", self.on_advance)
        self.add_service(SetPace, "~/set_pace", self.on_pace)
        operator = self.plant.operator
        OperatorServices(
            self, lambda name, *values: getattr(operator, name)(*values), lambda: self.cycle
        )

    # time
    def on_command(self, stamped: convert.StampedCommand, inside: bool = False) -> None:
        command = stamped.command
        if command.cycle > self.cycle:
            return  # an answer to the bus before a clean-up
        if not self.gate.accept(command.axis, stamped.stamp_ns, inside=inside):
            return
        if not self.gate.contested(command.axis):
            self.commands[command.axis] = command
        self.ages[min(self.cycle - command.cycle, len(self.ages) - 1)] += 1
        self.timing.add_command(command.cycle)
        # a drive that does not stop answers with the number of an old cycle
        answers_last = stamped.stamp_ns == self.gate.sent_ns
        go_on = answers_last and self.pacer.register_answer(command.axis)
        self.release()
        if go_on and not self.idle():
            self.go()

    def bench_ns(self) -> int:
        return self.gate.sent_ns

    def diagnostic_values(self) -> dict[str, Any]:
        """Delays of the graph, for /diagnostics."""
        return {
            "cycle": self.cycle,
            "pace": self.pacer.pace,
            "skipped": self.pacer.skipped,
            "command age p99": percentile(self.ages, 0.99),
            "command age max": max((k for k, n in enumerate(self.ages) if n), default=0),
            **(self.timing.values() if self.pacer.pace == "realtime" else {}),
        }

    def on_second(self) -> None:
        report_refused_commands(self, self.gate)
        pacer = self.pacer
        if pacer.skipped > self.skipped:
            self.skipped, self.slow_at = pacer.skipped, time.monotonic()
            self.troubles.begin("too_slow", f"{pacer.skipped} batches left out so far")
        elif time.monotonic() - self.slow_at > SHOWN:
            self.troubles.end("too_slow")
        silent = ", ".join(AXES[axis] for axis in sorted(pacer.missing))
        waited = pacer.waited(time.monotonic())
        lasting = {"drives_silent": silent} if pacer.absent else {}
        if waited and not pacer.absent:
            lasting["bus_waits"] = f"{silent}, for {waited:.0f} s"
        self.troubles.set_lasting(lasting, ("drives_silent", "bus_waits"))

    def release(self) -> None:
        """Answer the services that wait for a completed cycle."""
        while self.waiting and self.waiting[0][0] <= self.cycle and not self.pacer.missing:
            self.waiting.pop(0)[1].set_result(None)

    def on_tick(self) -> None:
        pacer, now = self.pacer, time.monotonic()
        if pacer.stop_waiting(now):
            self.release()
        due = pacer.batches_due(now, self.parameters.rate_hz, idle=self.idle())
        if due and pacer.pace == "realtime":
            tick_ns = self.tick.timer_period_ns
            self.timing.add_wake_up(due * tick_ns - self.tick.time_until_next_call())
            self.timing.late += (due - 1) * pacer.batch
        for _ in range(due):
            self.go()

    def look_for_drives(self) -> None:
        """Tell the pacer when a drive node has left the graph."""
        if self.commanders.look():
            self.pacer.register_leaving()

    def idle(self) -> bool:
        """True in lockstep when nothing moves, no drive is in operation and nobody waits for
        cycles."""
        if self.pacer.pace != "lockstep" or self.pacer.until is not None:
            return False
        if any(c.control_word == ENABLE_OPERATION for c in self.commands.values()):
            return False
        view = self.plant.operator.view
        return view.at_target and not view.plank_moving

    def go(self) -> None:
        """Make one batch of cycles and publish it."""
        batch = [self.plant.step(tuple(self.commands.values())) for _ in range(self.pacer.batch)]
        self.cycle, now_ns = batch[-1].cycle, time.monotonic_ns()
        if self.pacer.pace == "realtime":
            self.timing.add_frame(self.cycle, len(batch), now_ns)
        self.pacer.register_batch(self.cycle, now_ns * 1e-9)
        sent = convert.batch_of(batch, self.period_ns, self.t0)
        self.gate.send(sent.cycles[-1].stamp_ns)
        self.publish(sent)
        if self.pacer.pace != "realtime" and self.cycle - self.clock_cycle >= CLOCK_CYCLES:
            self.clock_cycle = self.cycle
            convert.set_time(self.clock.clock, sent.cycles[-1].stamp_ns)
            self.publish_clock(self.clock)
        self.tell_each_second()

    async def on_advance(
        self, request: Advance.Request, response: Advance.Response
    ) -> Advance.Response:
        most = int(LONGEST_ADVANCE_S * self.parameters.rate_hz)
        if reason := Limit(0, most, "cycles").refusal("cycles", request.cycles):
            return fill_response(response, False, reason, cycle=self.cycle)
        if request.cycles:
            until = self.pacer.advance(self.cycle, request.cycles)
            future = Future()
            self.waiting.append((until, future))
            self.waiting.sort(key=lambda pair: pair[0])
            if self.pacer.all_have_answered():
                self.go()
            await future
        return fill_response(
            response, True, f"{request.cycles} cycles made, up to {self.cycle}", cycle=self.cycle
        )

    def on_pace(self, request: SetPace.Request, response: SetPace.Response) -> SetPace.Response:
        if request.pace not in PACES:
            return fill_response(
                response, False, f"unknown pace {request.pace!r}; one of {', '.join(PACES)}"
            )
        if request.batch > MAX_BATCH:
            return fill_response(response, False, f"batch is {request.batch}, at most {MAX_BATCH}")
        self.pacer.set_pace(request.pace, time.monotonic())
        self.pacer.batch = request.batch or self.pacer.batch
        self.timing = BusTiming()
        if self.pacer.all_have_answered():
            self.go()
        return fill_response(response, True, f"pace is {request.pace}", cycle=self.cycle + 1)


NODE = SimulatedPlant


def main(args: list[str] | None = None) -> int:
    return run_node(lambda: NODE("simulated_plant"), args)


if __name__ == "__main__":
    raise SystemExit(main())
