# SPDX-License-Identifier: Apache-2.0
"""Plan of a run in a campaign: the zero of the unloaded hub is checked before and after."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from flatplank_control.calibration.fits import turning_amplitude
from flatplank_control.runner import steps as S
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.moves import QUICK, Plan
from flatplank_control.runner.plans import plan_of
from flatplank_hw.samples import flagged

LOOKS = 20
"""number of samples of a check at rest"""
MAX_NOISE = 60.0
"""largest standard deviation of a force at rest [N]"""


class Standstill:
    """Condition for Wait that collects samples at rest; PlanFailed for a channel at its limit or
    too much noise."""

    def __init__(self, when: str) -> None:
        self.when = when
        self.filter_on = False
        self.fx: list[float] = []
        self.fz: list[float] = []

    def __call__(self, s: S.Snapshot) -> bool:
        if s.hub.saturated:
            channels = ", ".join(flagged(s.hub.saturated))
            raise S.PlanFailed(f"{channels} at the limit {self.when}: check amplifier and cables")
        self.filter_on = s.hub.filter_on
        self.fx.append(s.hub.contact.fx)
        self.fz.append(s.hub.contact.fz)
        if len(self.fx) < LOOKS:
            return False
        noise = max(_spread(self.fx), _spread(self.fz))
        if noise > MAX_NOISE:
            raise S.PlanFailed(
                f"noise at rest is {noise:.0f} N {self.when}, at most {MAX_NOISE:g} N: "
                "look for loose cables"
            )
        return True

    @property
    def zero(self) -> tuple[float, float]:
        """Mean Fx and Fz [N]; NaN without samples."""
        return _mean(self.fx), _mean(self.fz)

    def facts(self) -> dict[str, float]:
        """Zeros and noise for the journal."""
        fx, fz = self.zero
        noise = _spread(self.fz)
        return {"zero_fx": round(fx, 2), "zero_fz": round(fz, 2), "noise": round(noise, 2)}


def _mean(values: list[float]) -> float:
    return sum(values) / len(values) if values else math.nan


def _spread(values: list[float]) -> float:
    mean = _mean(values)
    return math.sqrt(sum((v - mean) ** 2 for v in values) / max(len(values) - 1, 1))


LEAST_TURN = 2.0 * math.pi / 3.0
"""smallest turn for a once-per-turn amplitude [rad]"""
FEWEST = 12
"""smallest number of samples for it"""


class TurnWatch:
    """Watches the unloaded wheel while it turns to its start; `left` [N] is its once-per-turn
    force, NaN when it turns too little."""

    def __init__(self) -> None:
        self.filter_on = False
        self._rows: list[tuple[float, float, float]] = []

    def watching(self, until: Callable[[S.Snapshot], bool]) -> Callable[[S.Snapshot], bool]:
        """The condition `until`, wrapped so that it also collects every sample."""

        def check(s: S.Snapshot) -> bool:
            self.filter_on = s.hub.filter_on
            self._rows.append((s.encoders.wheel_angle, s.hub.contact.fx, s.hub.contact.fz))
            return until(s)

        return check

    @property
    def left(self) -> float:
        if len(self._rows) < FEWEST:
            return math.nan
        angle, fx, fz = np.array(self._rows).T
        if np.ptp(angle) < LEAST_TURN:
            return math.nan
        # a partial turn: fit no drift beside the sine
        return float(turning_amplitude(angle, np.column_stack([fx, fz])).max())


LOOK = 60.0
"""time-out of a check at rest [s]"""


def supervised(
    m: Measurement, before: Standstill, after: Standstill, turn: TurnWatch | None = None
) -> Plan:
    """Plan of a measurement with both checks; `turn` watches the unloaded wheel."""
    turning = False
    for step in plan_of(m):
        if turn is not None and turning and isinstance(step, S.Wait):
            step = replace(step, until=turn.watching(step.until))
        turning = isinstance(step, S.MoveTo)
        if isinstance(step, S.Manual) and step.quantity == "load":
            yield from _look(before)
            yield S.FastCycles(QUICK)
            # the spurious force of the preloaded shaft is known at this wheel angle
            step = replace(step, zero=before.zero[1])
        yield step
    yield S.Enable(False)
    yield S.Manual("unload", 0.0)
    yield from _look(after)


def _look(standstill: Standstill) -> Plan:
    yield S.FastCycles(1)
    yield S.Wait(f"the hub is quiet {standstill.when}", standstill, LOOK, at_least=0.5)
