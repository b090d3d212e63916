# SPDX-License-Identifier: Apache-2.0
"""How each kind of measurement is made: generators of steps, run dry, in the twin or on the
graph.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

from flatplank_control.runner import conditions as when
from flatplank_control.runner.measurement import START_ANGLES, Measurement
from flatplank_control.runner.steps import (
    Arm,
    Enable,
    Manual,
    Mode,
    MoveTo,
    Plank,
    Quick,
    Record,
    Say,
    SlipWaveform,
    Step,
    StopRecord,
    Wait,
)

Plan = Iterator[Step]
SPEED = 0.03092
"""fast speed of the plank [m/s]"""
THREE_TURNS = 1080.0
"""[deg], Appendix C"""
QUICK = 10
"""cycles per message while nothing is measured; 40 ms at 250 Hz, younger than any time-out"""


def go_back(m: Measurement) -> Plan:
    """Unload, return the plank, turn the wheel to its start, set the angles, load again."""
    yield Say("unload, return the plank, turn the wheel, load")
    yield Quick(QUICK)
    yield Plank(0)
    yield Wait("the plank rests", when.plank_rests(), 10.0)
    yield Manual("unload", 0.0)
    yield Plank(-1)
    yield Wait("the plank is back", when.plank_rests(), 200.0, at_least=1.0)
    yield Plank(0)
    yield Manual("pressure_bar", m.pressure)
    yield Manual("steer_deg", m.alpha_deg)
    yield Manual("road_camber_deg", m.gamma_deg)
    yield from turn(START_ANGLES[m.start])
    yield Manual("load", m.fz)


def turn(angle_deg: float) -> Plan:
    """Turn the unloaded wheel to an angle."""
    yield Mode("position", math.radians(angle_deg))
    yield Enable(True)
    yield Wait("the wheel drive is enabled", when.enabled(), 2.0)
    yield MoveTo(angle_deg)
    yield Wait(f"the wheel is at {angle_deg:g} deg", when.wheel_at(angle_deg), 200.0)


def over_the_road(m: Measurement, record: dict) -> Plan:
    """Record while the plank goes from the trigger to the end position."""
    yield Quick(1)
    yield Arm()
    yield Record(record)
    yield Plank(1)
    yield Wait("the plank moves", when.plank_moves(), 5.0)
    yield Wait(
        f"the plank is at {m.end_position:g} m",
        when.plank_beyond(m.end_position),
        1.5 * m.end_position / SPEED + 20.0,
        may_end_early=True,
    )
    yield Plank(0)
    yield Wait("the plank rests", when.plank_rests(), 10.0)
    yield StopRecord("complete")


def slip(m: Measurement) -> Plan:
    """A slip waveform over a rolling tire (section 6.2)."""
    yield from go_back(m)
    yield SlipWaveform(
        m.waveform, m.slip_parameters(), m.step_position, m.effective_rolling_radius
    )
    yield Mode("slip")
    yield Say(f"slip {100 * m.kappa:+g} % at {m.step_position:g} m")
    yield from over_the_road(m, m.record())


def free_rolling(m: Measurement) -> Plan:
    """The controller keeps the longitudinal force; gives r_e by (5.22)."""
    yield from go_back(m)
    yield Mode("free_rolling")
    yield Say("free rolling")
    yield from over_the_road(m, m.record())


def unloaded_turn(m: Measurement) -> Plan:
    """Three turns of the free wheel: the parasitic signal of the preloaded shaft (Appendix C)."""
    yield Plank(0)
    yield Wait("the plank rests", when.plank_rests(), 10.0)
    yield Manual("unload", 0.0)
    start = START_ANGLES[m.start]
    yield from turn(start)
    yield Record(m.record(), at_once=True)
    yield Say("three turns of the unloaded wheel")
    yield MoveTo(start + THREE_TURNS)
    yield Wait("the wheel has made three turns", when.wheel_at(start + THREE_TURNS), 400.0)
    yield StopRecord("complete")


PLANS: dict[str, Callable[[Measurement], Plan]] = {
    "slip": slip,
    "free_rolling": free_rolling,
    "unloaded_turn": unloaded_turn,
}
"""kind of measurement -> its plan"""


def safe_end() -> Plan:
    """Whatever happened: nothing moves, the bag is closed."""
    yield Plank(0)
    yield Enable(False)


def plan_of(m: Measurement) -> Plan:
    """The plan of a measurement."""
    if m.measurement not in PLANS:
        raise ValueError(f"measurement is '{m.measurement}'; known are {', '.join(sorted(PLANS))}")
    return PLANS[m.measurement](m)
