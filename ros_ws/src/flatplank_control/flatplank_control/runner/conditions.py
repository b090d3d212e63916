# SPDX-License-Identifier: Apache-2.0
"""Conditions that a plan waits for, by the measured samples alone; and settings made by hand."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from flatplank_control.runner.measurement import TRIGGER_AT
from flatplank_control.runner.steps import Manual, Plank, Snapshot
from flatplank_hw.cia402 import State
from flatplank_hw.encoders.params import SETUP_CONSTANTS as OF_ENCODERS
from flatplank_hw.hub.params import SETUP_CONSTANTS as OF_HUB

Condition = Callable[[Snapshot], bool]
AT_ANGLE = math.radians(0.2)
"""tolerance of a wheel angle [rad]"""
STILL = 1e-3
"""a wheel stands below this speed [rad/s]"""
PRELOAD = 300.0
"""largest force of the preloaded shaft while the parasitic filter is off [N], thesis 3.1"""
RADIUS_STILL = 3e-4
"""an axle rests while its height changes by less [m]"""
STILL_FOR = 300_000_000
"""time for which an axle must rest [ns]"""


def plank_rests() -> Condition:
    return lambda s: not s.encoders.plank_moving


def plank_moves() -> Condition:
    return lambda s: s.encoders.plank_moving


def travelled(distance: float) -> Condition:
    """Condition: the plank has travelled `distance` [m] since the first call, or rests."""
    first: float | None = None

    def check(s: Snapshot) -> bool:
        nonlocal first
        if first is None:
            first = s.encoders.plank_position
        gone = abs(s.encoders.plank_position - first)
        return gone >= distance or not s.encoders.plank_moving

    return check


def plank_beyond(position: float) -> Condition:
    """Condition: the plank has passed `position` [m], or rests before it."""
    return lambda s: s.encoders.plank_position >= position or not s.encoders.plank_moving


class CachedCondition:
    """Condition that keeps its last result in `held`."""

    def __init__(self, condition: Condition) -> None:
        self._condition = condition
        self.held = False

    def __call__(self, s: Snapshot) -> bool:
        self.held = self._condition(s)
        return self.held


def enabled() -> Condition:
    return lambda s: s.drive.state == State.OPERATION_ENABLED


def wheel_at(angle_deg: float) -> Condition:
    angle = math.radians(angle_deg)
    return lambda s: abs(s.drive.position - angle) < AT_ANGLE and abs(s.drive.velocity) < STILL


def loaded(fz: float, zero: float = math.nan) -> Condition:
    """Condition: the load [N] is reached, within 1 % and 10 N.

    `zero`: Fz of the unloaded hub at this wheel angle [N]. Without it the tolerance includes the
    largest spurious force of the preloaded shaft.
    """
    known = not math.isnan(zero)

    def check(s: Snapshot) -> bool:
        hidden = 0.0 if known or s.hub.filter_on else PRELOAD
        offset = zero if known else 0.0
        return abs(s.hub.fz_filtered - offset - fz) < 10.0 + 0.01 * fz + hidden

    return check


def unloaded() -> Condition:
    """Condition: the force is small, and the axle rests."""
    radius, since = math.inf, 0

    def check(s: Snapshot) -> bool:
        nonlocal radius, since
        stamp = s.encoders.stamp_ns
        if abs(s.hub.loaded_radius - radius) > RADIUS_STILL:
            radius, since = s.hub.loaded_radius, stamp
        still = stamp - since >= STILL_FOR
        return still and abs(s.hub.fz_filtered) < 100.0 + PRELOAD

    return check


@dataclass(frozen=True)
class Quantity:
    """A quantity that is set by hand."""

    prompt: str
    """text with {value}"""
    verify: Callable[..., Condition]
    """value, for a load also the zero of the hub [N] -> condition that confirms the setting"""
    timeout: float = 120.0
    """time-out of a simulated operator [s of bench time]"""


def _near(read: Callable[[Snapshot], float], tolerance: float) -> Callable[[float], Condition]:
    return lambda value: lambda s: abs(read(s) - value) < tolerance


def _not_measured(_value: float) -> Condition:
    return lambda _: True


def condition_of(step: Manual) -> Condition:
    """Condition by which the sensors confirm a manual setting."""
    quantity = QUANTITIES[step.quantity]
    if step.zero == step.zero:
        return quantity.verify(step.value, step.zero)
    return quantity.verify(step.value)


def prompt_of(step: Manual) -> str:
    """Prompt for the operator; a load includes the zero of the display."""
    quantity = QUANTITIES[step.quantity]
    value = step.value + step.zero if step.zero == step.zero else step.value
    return quantity.prompt.format(value=round(value, 2))


def prompt_of_plank(step: Plank) -> str:
    """Prompt for the plank's switch; the position is that of the encoder."""
    speed = {1: ", fast" if step.fast else ", slow"}.get(step.direction, "")
    stop = step.stop_at - TRIGGER_AT
    until = f"; stop it {stop:g} m behind the trigger" if not math.isnan(stop) else ""
    return f"turn the plank switch to {SWITCH[step.direction]}{speed}{until}"


SWITCH = {1: "forward", 0: "stop", -1: "reverse"}
"""direction of the plank -> label at its switch"""

QUANTITIES: dict[str, Quantity] = {
    "unload": Quantity("lift the wheel off the road", lambda _: unloaded()),
    "load": Quantity("lower the axle until Fz is {value:g} N", loaded),
    "steer_deg": Quantity(
        "set the steering angle to {value:g} deg at the protractor",
        _near(lambda s: math.degrees(s.encoders.steer_angle), 0.5),
    ),
    "road_camber_deg": Quantity(
        "set the road camber to {value:g} deg",
        _near(lambda s: math.degrees(s.encoders.road_camber), 0.5),
    ),
    "cleat_mm": Quantity("fasten a cleat of {value:g} mm on the road; 0: none", _not_measured),
    "flexplates": Quantity(
        "flexplates: {value:g} (1: connect wheel and drive, 0: take them off)", _not_measured
    ),
    "pressure_bar": Quantity("set the inflation pressure to {value:g} bar", _not_measured),
    "wheel_camber_deg": Quantity("set the camber of the hub to {value:g} deg", _not_measured),
}
SET_UP = {"measurement_hub": OF_HUB, "encoders": OF_ENCODERS}
"""node -> set-up constants that are copied to every run record"""
