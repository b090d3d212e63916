# SPDX-License-Identifier: Apache-2.0
"""How each kind of measurement is made: generators of steps, run dry, in the twin or on the
graph.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from flatplank_control.runner import conditions as when
from flatplank_control.runner import standing
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.moves import (
    QUICK,
    SPEED,
    Plan,
    at_speed,
    back_unloaded,
    go_back,
    mounted,
    over_the_road,
    turn,
)
from flatplank_control.runner.steps import (
    AxisProfile,
    Enable,
    HoldLoad,
    Manual,
    Mode,
    MoveTo,
    Plank,
    Record,
    Say,
    SlipWaveform,
    StopRecord,
    Wait,
)

__all__ = ["PLANS", "QUICK", "SPEED", "Plan", "plan_of", "safe_end"]
THREE_TURNS = 1080.0
"""[deg], Appendix C"""


def slip(m: Measurement) -> Plan:
    """A slip waveform over a rolling tire (section 6.2)."""
    yield from go_back(m)
    yield from at_speed(m)
    yield SlipWaveform(
        m.waveform, m.slip_parameters(), m.step_position, m.effective_rolling_radius
    )
    yield Mode("slip")
    yield Say(f"slip {100 * m.kappa:+g} % at {m.step_position:g} m")
    yield from over_the_road(m, m.record())


def free_rolling(m: Measurement) -> Plan:
    """The controller keeps the longitudinal force, or the wheel is off its drive; gives r_e
    by (5.22).
    """
    if not m.flexplates:
        yield from _off_its_drive(m)
        return
    yield from go_back(m)
    yield Mode("free_rolling")
    yield Say("free rolling")
    yield from over_the_road(m, m.record())


def _off_its_drive(m: Measurement) -> Plan:
    """Rolls against its own resistance only; the drive is connected again at the end."""
    yield from back_unloaded(m)
    yield Enable(False)
    yield Manual("flexplates", 0.0)
    yield Manual("load", m.fz)
    yield Say("free rolling, flexplates off")
    yield from over_the_road(m, m.record())
    yield Manual("unload", 0.0)
    yield Manual("flexplates", 1.0)


def unloaded_turn(m: Measurement) -> Plan:
    """Three turns of the free wheel: the parasitic signal of the preloaded shaft (Appendix C)."""
    yield from mounted(m)
    yield Plank(0)
    yield Wait("the plank rests", when.plank_rests(), 10.0)
    yield Manual("unload", 0.0)
    start = m.start_angle
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
    "stiffness_vertical": standing.vertical,
    "stiffness_longitudinal": standing.longitudinal,
    "stiffness_lateral": standing.lateral,
    "locked_wheel": standing.locked_wheel,
    "cleat": standing.cleat,
    "parking": standing.parking,
    "turning": standing.turning,
    "camber_sweep": standing.camber_sweep,
}
"""kind of measurement -> its plan"""


AXES: dict[str, tuple[str, ...]] = {
    "parking": ("steer",), "turning": ("steer",), "camber_sweep": ("camber",),
}  # fmt: skip
"""kind of measurement -> driven axes that it needs"""


def safe_end() -> Plan:
    """Whatever happened: nothing moves, the bag is closed."""
    yield Plank(0)
    yield Enable(False)


def plan_of(m: Measurement) -> Plan:
    """The plan of a measurement."""
    if m.measurement not in PLANS:
        raise ValueError(f"measurement is '{m.measurement}'; known are {', '.join(sorted(PLANS))}")
    return PLANS[m.measurement](m)


def let_go(axes: Iterable[str]) -> Plan:
    """Controllers of further axes leave them to the operator."""
    for axis in axes:
        yield HoldLoad(math.nan) if axis == "vertical" else AxisProfile(axis, parameters=None)


def axes_of(m: Measurement) -> tuple[str, ...]:
    """Axes that must have a drive for it, beside the wheel."""
    held = ("vertical",) if m.hold_load else ()
    return held + AXES.get(m.measurement, ())
