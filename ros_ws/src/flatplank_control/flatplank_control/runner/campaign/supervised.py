# SPDX-License-Identifier: Apache-2.0
"""A run as a campaign makes it: the hub is looked at unloaded before and after."""

from __future__ import annotations

from dataclasses import replace

from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.plans import QUICK, Plan, plan_of
from flatplank_control.runner.standstill import Standstill
from flatplank_control.runner.steps import Enable, Manual, MoveTo, Quick, Wait
from flatplank_control.runner.turn_watch import TurnWatch

LOOK = 60.0
"""[s]"""


def supervised(
    m: Measurement, before: Standstill, after: Standstill, turn: TurnWatch | None = None
) -> Plan:
    """The plan of a measurement with both looks; `turn` sees the unloaded wheel on its way."""
    turning = False
    for step in plan_of(m):
        if turn is not None and turning and isinstance(step, Wait):
            step = replace(step, until=turn.watching(step.until))
        turning = isinstance(step, MoveTo)
        if isinstance(step, Manual) and step.quantity == "load":
            yield from _look(before)
            yield Quick(QUICK)
            # the wheel stands at this angle: the spurious force of the preloaded shaft is known
            step = replace(step, zero=before.zero[1])
        yield step
    yield Enable(False)
    yield Manual("unload", 0.0)
    yield from _look(after)


def _look(standstill: Standstill) -> Plan:
    yield Quick(1)
    yield Wait(f"the hub is quiet {standstill.when}", standstill, LOOK, at_least=0.5)
