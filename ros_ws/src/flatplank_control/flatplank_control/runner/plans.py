# SPDX-License-Identifier: Apache-2.0
"""Procedure of each kind of measurement: a generator of steps, for dry run, twin or ROS graph."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from flatplank_control.runner import conditions as when
from flatplank_control.runner import moves
from flatplank_control.runner import steps as S
from flatplank_control.runner.measurement import DIRECTIONS, SLOW, SPEED, Measurement, from_mapping
from flatplank_control.runner.moves import Plan
from flatplank_data.errors import FlatplankError
from flatplank_data.run_record import record_from_dict
from flatplank_data.yaml_text import load_yaml

THREE_TURNS = 1080.0
"""wheel angle of three turns, Appendix C [deg]"""
STANDS_AT = 0.15
"""machine position of a plank under a standing tire, behind the motion trigger [m]"""
CLEAT_AT = 2.0
"""machine position of the cleat [m]"""
PAUSE = 0.5
"""rest before a standing tire is loaded tangentially [s]"""
EXAMPLE = "{measurement: slip, kappa: 0.05, effective_rolling_radius: 0.3108}"
SAYS_WHAT = ("measurement", "kappa", "waveform")
"""keys that state what to measure: a goal needs one of them"""


def slip(m: Measurement) -> Plan:
    """A slip waveform over a rolling tire (thesis 6.2)."""
    yield from moves.go_back(m)
    yield from moves.set_plank_speed(m)
    yield S.SlipWaveform(
        m.waveform, m.slip_parameters(), m.step_position, m.effective_rolling_radius
    )
    yield S.Mode("slip")
    yield S.ShowProgress(f"slip {100 * m.kappa:+g} % at {m.step_position:g} m")
    yield from moves.over_the_road(m)


def free_rolling(m: Measurement) -> Plan:
    """Free rolling: the controller holds the longitudinal force, or the disconnected wheel rolls
    against its own resistance only. Gives r_e by (5.22)."""
    if m.flexplates:
        yield from moves.go_back(m)
        yield S.Mode("free_rolling")
        yield S.ShowProgress("free rolling")
        yield from moves.over_the_road(m)
        return
    yield from moves.back_unloaded(m)
    yield S.Enable(False)
    yield S.Manual("flexplates", 0.0)
    yield S.Manual("load", m.fz)
    yield S.ShowProgress("free rolling, flexplates off")
    yield from moves.over_the_road(m)
    yield S.Manual("unload", 0.0)
    yield S.Manual("flexplates", 1.0)


def unloaded_turn(m: Measurement) -> Plan:
    """Three turns of the unloaded wheel: signal of the preloaded shaft (Appendix C)."""
    yield from moves.set_rim(m)
    yield from moves.to_rest()
    yield S.Manual("unload", 0.0)
    yield from moves.turn(m.start_angle)
    yield S.Record(m.record(), at_once=True)
    yield S.ShowProgress("three turns of the unloaded wheel")
    end = m.start_angle + THREE_TURNS
    yield S.MoveTo(end)
    yield S.Wait("the wheel has made three turns", when.wheel_at(end), 400.0)
    yield S.StopRecord("complete")


def _onto_the_road(m: Measurement, room: float = 0.0) -> Plan:
    """Move the plank past the trigger, so that the plank position is known in the whole record.

    `room`: additional distance, for a road that moves backward [m].
    """
    yield from moves.back_unloaded(m)
    yield S.Arm()
    yield S.Plank(1, stop_at=STANDS_AT + room)
    yield S.Wait("the plank rests on the road", when.plank_rests(), 30.0, at_least=1.0)
    yield S.Plank(0)


def _pause() -> Plan:
    yield S.Wait("the bench rests", lambda _s: True, 2.0 * PAUSE, at_least=PAUSE)


def vertical(m: Measurement) -> Plan:
    """Loading and unloading of the standing tire: C_z from Fz over the loaded radius (G.2)."""
    yield from _onto_the_road(m)
    yield S.Enable(False)
    yield S.FastCycles(1)
    yield S.Record(m.record(), at_once=True)
    yield S.ShowProgress("vertical stiffness: load and unload")
    yield S.Manual("load", m.fz)
    yield from _pause()
    yield S.Manual("unload", 0.0)
    yield S.StopRecord("complete")


def locked_wheel_plan(usual: float, fast: bool) -> Callable[[Measurement], Plan]:
    """Plan in which the road moves under the held wheel: by `usual` [m], or by the distance of
    the measurement."""

    def plan(m: Measurement) -> Plan:
        way, distance = DIRECTIONS[m.direction], m.distance or usual
        yield from _onto_the_road(m, distance if way < 0 else 0.0)
        yield S.Manual("load", m.fz)
        yield S.FastCycles(1)
        yield S.Record(m.record(), at_once=True)
        yield S.ShowProgress(f"{m.measurement}: the locked wheel over {1e3 * distance:g} mm")
        yield from _pause()
        yield S.Plank(way, fast=fast)
        yield S.Wait("the plank moves", when.plank_moves(), 5.0)
        timeout = 2.0 * distance / (SPEED if fast else SLOW) + 10.0
        dragged = when.travelled(distance)
        yield S.Wait("the road was dragged", dragged, timeout, may_end_early=True)
        yield from moves.to_rest()
        yield S.StopRecord("complete")

    return plan


def cleat(m: Measurement) -> Plan:
    """The driven tire rolls over a cleat at zero slip."""
    yield from moves.back_unloaded(m)
    yield S.Manual("cleat_mm", m.cleat_mm)
    yield S.Manual("load", m.fz)
    yield from moves.rolling_freely(m)
    yield from moves.over_the_road(m)
    yield S.Manual("unload", 0.0)
    yield S.Manual("cleat_mm", 0.0)


def parking(m: Measurement) -> Plan:
    """The standing tire is steered back and forth; needs a driven steering axis."""
    yield from _onto_the_road(m)
    yield S.Manual("load", m.fz)
    yield S.Enable(False)
    yield S.FastCycles(1)
    yield S.AxisProfile("steer")
    yield S.Record(m.record(), at_once=True)
    yield S.ShowProgress(f"{m.profile} on the steering axis")
    yield from _pause()
    yield S.AxisProfile("steer", m.profile, dict(m.profile_parameters))
    time = m.profile_time
    yield S.Wait("the profile is over", lambda _s: True, time + 5.0, time, may_end_early=True)
    yield S.StopRecord("complete")
    yield S.AxisProfile("steer", parameters=None)


def turned(axis: str) -> Callable[[Measurement], Plan]:
    """Plan of a rolling tire: from the step position on, an axis follows a profile."""

    def plan(m: Measurement) -> Plan:
        yield from moves.go_back(m)
        yield S.AxisProfile(axis)
        yield from moves.rolling_freely(m)
        profile = S.AxisProfile(axis, m.profile, dict(m.profile_parameters))
        yield from moves.over_the_road(m, m.step_position, (profile,))
        yield S.AxisProfile(axis, parameters=None)

    return plan


PLANS: dict[str, Callable[[Measurement], Plan]] = {
    "slip": slip,
    "free_rolling": free_rolling,
    "unloaded_turn": unloaded_turn,
    "stiffness_vertical": vertical,
    # C_x: Fx over the road's travel; C_y: Fy over the travel across the steered wheel
    "stiffness_longitudinal": locked_wheel_plan(0.006, fast=False),
    "stiffness_lateral": locked_wheel_plan(0.008, fast=False),
    # friction: the road moves until the locked wheel slides
    "locked_wheel": locked_wheel_plan(0.3, fast=True),
    "cleat": cleat,
    "parking": parking,
    # profiles of the steering and of the road camber
    "turning": turned("steer"),
    "camber_sweep": turned("camber"),
}
"""kind of measurement -> its plan"""

AXES: dict[str, tuple[str, ...]] = {
    "parking": ("steer",), "turning": ("steer",), "camber_sweep": ("camber",),
}  # fmt: skip
"""kind of measurement -> driven axes that it needs beside the wheel"""


def plan_of(m: Measurement) -> Plan:
    """The plan of a measurement."""
    if m.measurement not in PLANS:
        raise ValueError(f"measurement is '{m.measurement}'; known are {', '.join(sorted(PLANS))}")
    return PLANS[m.measurement](m)


def safe_end() -> Plan:
    """Stop the plank and switch off the drive of the wheel: the safe end of any plan."""
    yield S.Plank(0)
    yield S.Enable(False)


def release_axes(axes: Iterable[str]) -> Plan:
    """Release further axes from their controllers."""
    for axis in axes:
        yield S.HoldLoad(math.nan) if axis == "vertical" else S.AxisProfile(axis, parameters=None)


def axes_of(m: Measurement) -> tuple[str, ...]:
    """Axes that must have a drive for a measurement, beside the wheel."""
    held = ("vertical",) if m.hold_load else ()
    return held + AXES.get(m.measurement, ())


class GoalError(FlatplankError):
    """Error for a goal that states no measurement; one line."""


def mapping_of(text: str) -> Mapping[str, Any]:
    """Parse the YAML of a goal; GoalError when it is empty or no mapping."""
    data = load_yaml(text, "plan")
    if data is None or data == {}:
        raise GoalError(f"plan: empty; state what to measure, for instance {EXAMPLE}")
    if not isinstance(data, Mapping):
        shown = " ".join(str(data).split())[:40]
        raise GoalError(f"plan: '{shown}' is no plan; give keys and values like {EXAMPLE}")
    return data


def measurement_of(data: Mapping[str, Any]) -> Measurement:
    """The measurement of a goal that is no campaign; ValueError with one line."""
    wanted = from_mapping(data, "plan")
    if not any(key in data for key in SAYS_WHAT):
        known = ", ".join(SAYS_WHAT)
        raise GoalError(f"plan: states how, but not what to measure: add one of {known}")
    plan_of(wanted)
    record_from_dict(wanted.record())
    return wanted
