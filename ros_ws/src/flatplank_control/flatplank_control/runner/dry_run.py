# SPDX-License-Identifier: Apache-2.0
"""Dry run of a plan: performs it by kinematics alone, for bench time, progress, road and load."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from flatplank_control.runner import steps as S
from flatplank_control.runner.campaign.plan import CampaignPlan
from flatplank_control.runner.conditions import QUANTITIES, condition_of
from flatplank_control.runner.measurement import TRIGGER_AT
from flatplank_control.runner.moves import SLOW, SPEED
from flatplank_control.runner.plans import plan_of
from flatplank_control.runner.steps import PlanFailed, WaitMonitor
from flatplank_data.machine import ROAD_LENGTH
from flatplank_hw.cia402 import State
from flatplank_hw.samples import DriveSample, EncoderSample, HubSample, Wrench

STEP = 0.1
"""time step [s]"""
WHEEL_SPEED = 0.15
"""wheel speed of a move [rad/s]"""
SETTING_TIME_S = {
    "load": 7.0, "unload": 5.0, "pressure_bar": 0.2, "cleat_mm": 0.2, "flexplates": 0.2,
}  # fmt: skip
"""setting -> typical time of an operator on the simulated bench [s]; all others are angles"""
ANGLE_SPEED = 2.0
"""speed at which an operator changes an angle [deg/s]"""


class DryBench:
    """Bench with kinematics only; `time` is the bench time of all performed steps [s]."""

    def __init__(self) -> None:
        self.time = 0.0
        self.plank = self.wheel = 0.0
        """machine position of the plank [m], angle of the wheel [rad]"""
        self.road_used = 0.0
        """farthest position of the plank from the trigger [m]"""
        self.steps: list[S.Step] = []
        self._direction, self._fast, self._stop_at = 0, True, math.nan
        self._target = math.nan
        self._omega = 0.0
        self._enabled = False
        self._set: dict[str, float] = {}
        self._do: dict[type, Callable[[Any], None]] = {
            S.Manual: self._manual,
            S.Plank: self._switch,
            S.Enable: lambda s: setattr(self, "_enabled", s.on),
            S.Mode: self._mode,
            S.MoveTo: lambda s: setattr(self, "_target", math.radians(s.angle_deg)),
            S.Wait: self._wait,
        }

    def perform(self, plan: Iterable[S.Step]) -> None:
        """Perform a plan; PlanFailed when it waits for something that never happens."""
        for step in plan:
            self.steps.append(step)
            act = self._do.get(type(step))
            if act:
                act(step)

    def _manual(self, step: S.Manual) -> None:
        before = self._set.get(step.quantity, 0.0)
        self._set[step.quantity] = step.value
        if step.quantity == "unload":
            self._set["load"] = 0.0
        needed = SETTING_TIME_S.get(step.quantity)
        needed = abs(step.value - before) / ANGLE_SPEED if needed is None else needed
        quantity = QUANTITIES[step.quantity]
        self._wait(S.Wait(quantity.prompt, condition_of(step), quantity.timeout, needed + 0.2))

    def _switch(self, step: S.Plank) -> None:
        self._direction, self._fast, self._stop_at = step.direction, step.fast, step.stop_at

    def _mode(self, step: S.Mode) -> None:
        self._target = math.nan
        self._omega = 0.0

    def _wait(self, step: S.Wait) -> None:
        monitor = WaitMonitor(step, self.time)
        while not monitor.over(self.snapshot(), self.time):
            self._advance()

    def _advance(self) -> None:
        self.time += STEP
        speed = self._speed
        self.plank = min(max(self.plank + speed * STEP, -0.01), ROAD_LENGTH)
        if self._direction > 0 and self.plank >= self._stop_at:
            self.plank, self._direction = self._stop_at, 0
        if self._direction > 0:
            self.road_used = max(self.road_used, self.plank - TRIGGER_AT)
        self._omega = 0.0
        if self._target == self._target and self._enabled:
            left = self._target - self.wheel
            step = math.copysign(min(abs(left), WHEEL_SPEED * STEP), left)
            self.wheel, self._omega = self.wheel + step, step / STEP
        elif self._direction > 0:
            self.wheel += speed * STEP / 0.31

    @property
    def _speed(self) -> float:
        """Speed of the plank by its switch [m/s]."""
        return self._direction * (SPEED if self._fast or self._direction < 0 else SLOW)

    @property
    def _moves(self) -> bool:
        return (
            self._direction > 0
            and self.plank < ROAD_LENGTH
            or self._direction < 0
            and self.plank > -0.01
        )

    def snapshot(self) -> S.Snapshot:
        """Samples as measured on a bench without noise."""
        stamp, cycle = round(self.time * 1e9), round(self.time / STEP)
        moves = self._moves
        fz = self._set.get("load", 0.0)
        force = Wrench(0.0, 0.0, fz, 0.0, 0.0, 0.0)
        speed = self._speed if moves else 0.0
        steer = math.radians(self._set.get("steer_deg", 0.0))
        camber = math.radians(self._set.get("road_camber_deg", 0.0))
        encoders = EncoderSample(
            cycle, stamp, self.plank - TRIGGER_AT, speed, self.wheel, self._omega, steer, camber,
            math.nan, 0.0, 0.0, moves, self.plank > TRIGGER_AT, 0.0,
        )  # fmt: skip
        hub = HubSample(cycle, stamp, force, force, 0.3, camber, fz, False, 0)
        state = State.OPERATION_ENABLED if self._enabled else 0
        drive = DriveSample(
            cycle, stamp, state, 0, self.wheel, self._omega, 0.0, 0.0, 0.0, 0.0, 0, 0
        )
        return S.Snapshot(encoders, hub, drive)


class Progress:
    """Progress of a plan: `step` steps are done, the next one has taken `seconds` so far."""

    def __init__(self, ends: Sequence[float]) -> None:
        """`ends`: bench time at the end of each step in the dry run [s]."""
        self._ends = list(ends)
        self.total = self._ends[-1] if self._ends else 0.0

    def left(self, step: int, seconds: float = 0.0) -> float:
        """Remaining bench time [s]; a step that takes longer than planned counts as done."""
        begin = self._ends[step - 1] if step else 0.0
        end = self._ends[min(step, len(self._ends) - 1)] if self._ends else 0.0
        return self.total - min(begin + seconds, end)

    def done(self, step: int, seconds: float = 0.0) -> float:
        """Completed share, 0 .. 1."""
        return 1.0 - self.left(step, seconds) / self.total if self.total else 1.0


def dry_run_progress(plan: Iterable[S.Step]) -> Progress:
    """Dry-run a plan; a wait for something that the dry run does not simulate takes no time."""
    bench, ends = DryBench(), []
    for step in plan:
        with suppress(PlanFailed):
            bench.perform([step])
        ends.append(bench.time)
    return Progress(ends)


@dataclass(frozen=True)
class DryRun:
    """Expected effort of a campaign."""

    durations: dict[str, float]
    """key of a run -> bench time [s]"""
    kinds: dict[str, int]
    """kind of measurement and role -> number of runs"""
    road: float
    """farthest position of the plank [m]"""
    largest_load: float
    """largest load [N]"""
    prompts: int
    """number of settings made by hand"""

    @property
    def total(self) -> float:
        """Total bench time [s]."""
        return sum(self.durations.values())

    def lines(self, plan: CampaignPlan) -> list[str]:
        """Summary for the terminal."""
        kinds = ", ".join(f"{n} {kind}" for kind, n in self.kinds.items())
        hours = self.total / 3600.0
        return [
            f"plan {plan.name}: {len(plan.runs)} runs ({kinds}) with the {plan.tire.name}",
            f"bench time {hours:.1f} h without repeats ({self.total / len(plan.runs):.0f} s each)",
            f"road {self.road:.2f} m of {ROAD_LENGTH:.2f} m, up to {self.largest_load:.0f} N, "
            f"{self.prompts} settings by hand",
        ]


def dry_run(plan: CampaignPlan) -> DryRun:
    """Dry-run all runs, one after the other; PlanFailed names line and reason."""
    bench = DryBench()
    durations: dict[str, float] = {}
    for run in plan.runs:
        before = bench.time
        try:
            bench.perform(plan_of(run.measurement))
        except ValueError as error:
            raise PlanFailed(f"{plan.where}:{run.line}: {error}") from None
        durations[run.key] = bench.time - before
    kinds = Counter(
        run.measurement.measurement if run.role == "run" else f"{run.role} run"
        for run in plan.runs
    )
    by_hand = [step for step in bench.steps if isinstance(step, S.Manual)]
    loads = [step.value for step in by_hand if step.quantity == "load"]
    return DryRun(durations, dict(kinds), bench.road_used, max(loads, default=0.0), len(by_hand))
