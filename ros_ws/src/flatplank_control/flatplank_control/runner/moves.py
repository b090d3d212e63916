# SPDX-License-Identifier: Apache-2.0
"""Sequences of steps that several kinds of measurement share."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from flatplank_control.runner import conditions as when
from flatplank_control.runner import steps as S
from flatplank_control.runner.measurement import SLOW, SPEED, Measurement

Plan = Iterator[S.Step]
QUICK = 10
"""cycles per message while nothing is measured, 40 ms at 250 Hz; fewer at a lower rate"""
ENOUGH = "enough: ended here by the operator"
"""note in the record of a run that the operator ended early"""


def set_rim(m: Measurement) -> Plan:
    """Set the rim constants of the hub that the plan names."""
    if rim := m.rim():
        yield S.Constants(rim)


def set_plank_speed(m: Measurement) -> Plan:
    """Set the plank speed of the plan in the slip sequencer."""
    yield S.Constants({"commanded_speed": m.speed}, "slip_sequencer")


def by_drive(step: S.Plank) -> Plan:
    """Steps of a plank with a drive in place of the switch."""
    if step.direction == 0:
        yield S.Enable(False, "plank")
        return
    yield S.Mode("velocity", 0.0, "plank")
    yield S.Enable(True, "plank")
    yield S.Wait("the plank drive has answered", lambda _s: True, 2.0, 0.5)
    if math.isfinite(step.stop_at):
        # a position set-point is needed at every cycle, a speed may hold for a batch
        yield S.FastCycles(1)
        yield S.Mode("position", step.stop_at, "plank")
        return
    fast = step.fast or step.direction < 0
    yield S.Mode("velocity", step.direction * (SPEED if fast else SLOW), "plank")


def to_rest() -> Plan:
    """Stop the plank."""
    yield S.Plank(0)
    yield S.Wait("the plank rests", when.plank_rests(), 10.0)


def back_unloaded(m: Measurement) -> Plan:
    """Unload, return the plank, set pressure and angles, turn the wheel to its start."""
    yield S.ShowProgress("unload, return the plank, turn the wheel, load")
    yield from set_rim(m)
    yield S.FastCycles(QUICK)
    yield from to_rest()
    yield S.Manual("unload", 0.0)
    yield S.Plank(-1)
    yield S.Wait("the plank is back", when.plank_rests(), 200.0, at_least=1.0)
    yield S.Plank(0)
    yield S.Manual("pressure_bar", m.pressure)
    yield S.Manual("steer_deg", m.alpha_deg)
    if m.wheel_camber_deg is not None:
        yield S.Manual("wheel_camber_deg", m.wheel_camber_deg)
    yield S.Manual("road_camber_deg", m.gamma_deg - (m.wheel_camber_deg or 0.0))
    yield from turn(m.start_angle)


def go_back(m: Measurement) -> Plan:
    """`back_unloaded`, then load."""
    yield from back_unloaded(m)
    yield S.Manual("load", m.fz)


def turn(angle_deg: float) -> Plan:
    """Turn the unloaded wheel to an angle."""
    yield S.Mode("position", math.radians(angle_deg))
    yield S.Enable(True)
    yield S.Wait("the wheel drive is enabled", when.enabled(), 2.0)
    yield S.MoveTo(angle_deg)
    yield S.Wait(f"the wheel is at {angle_deg:g} deg", when.wheel_at(angle_deg), 200.0)


def over_the_road(m: Measurement, at: float = math.nan, then: Sequence[S.Step] = ()) -> Plan:
    """Record while the plank moves from the trigger to the end position; at plank position `at`
    [m] do `then`."""
    yield S.FastCycles(1)
    if m.hold_load:
        yield S.HoldLoad(m.fz)
    if m.optical_trigger > 0.0:
        yield S.Trigger(m.optical_trigger)
    yield S.Arm()
    yield S.Record(m.record())
    yield S.Plank(1, fast=m.fast)
    yield S.Wait("the plank moves", when.plank_moves(), 5.0)
    if then:
        timeout = 1.5 * at / m.speed + 20.0
        yield S.Wait(f"the plank is at {at:g} m", when.plank_beyond(at), timeout)
        yield from then
    at_the_end = when.CachedCondition(when.plank_beyond(m.end_position))
    timeout = 1.5 * m.end_position / m.speed + 20.0
    yield S.Wait(f"the plank is at {m.end_position:g} m", at_the_end, timeout, may_end_early=True)
    yield from to_rest()
    yield S.StopRecord("complete", "" if at_the_end.held else ENOUGH)
    if m.optical_trigger > 0.0:
        yield S.Trigger(-1.0)
    if m.hold_load:
        yield S.HoldLoad(math.nan)


def rolling_freely(m: Measurement) -> Plan:
    """Turn the wheel with the road at zero slip."""
    at = m.step_position
    yield from set_plank_speed(m)
    yield S.SlipWaveform("constant", {"kappa": 0.0}, at, m.effective_rolling_radius)
    yield S.Mode("slip")
    yield S.ShowProgress(f"{m.measurement}: rolling without slip")
