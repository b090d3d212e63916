# SPDX-License-Identifier: Apache-2.0
"""What an operator sets by hand: how to say it, how the sensors verify it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from flatplank_control.runner import conditions as when
from flatplank_control.runner.measurement import TRIGGER_AT
from flatplank_control.runner.steps import Manual, Plank, Snapshot
from flatplank_hw.encoders.params import SETUP_CONSTANTS as OF_ENCODERS
from flatplank_hw.hub.params import SETUP_CONSTANTS as OF_HUB


@dataclass(frozen=True)
class Quantity:
    """A manual setting."""

    prompt: str
    """with {value}"""
    verify: Callable[..., when.Condition]
    timeout: float = 120.0
    """for a simulated operator [s of bench time]"""


def _near(
    read: Callable[[Snapshot], float], tolerance: float
) -> Callable[[float], when.Condition]:
    return lambda value: lambda s: abs(read(s) - value) < tolerance


def _not_measured(_value: float) -> when.Condition:
    return lambda _: True


def condition_of(step: Manual) -> when.Condition:
    """What the sensors must say when it is done."""
    quantity = QUANTITIES[step.quantity]
    if step.zero == step.zero:
        return quantity.verify(step.value, step.zero)
    return quantity.verify(step.value)


def prompt_of(step: Manual) -> str:
    """What an operator reads; a load is read with the zero of the display."""
    quantity = QUANTITIES[step.quantity]
    value = step.value + step.zero if step.zero == step.zero else step.value
    return quantity.prompt.format(value=round(value, 2))


def prompt_of_plank(step: Plank) -> str:
    """What an operator reads at the plank's switch; the position is the encoder's."""
    speed = {1: ", fast" if step.fast else ", slow"}.get(step.direction, "")
    stop = step.stop_at - TRIGGER_AT
    until = f"; stop it {stop:g} m behind the trigger" if not math.isnan(stop) else ""
    return f"turn the plank switch to {SWITCH[step.direction]}{speed}{until}"


SWITCH = {1: "forward", 0: "stop", -1: "reverse"}
"""direction of the plank -> word at its switch"""

QUANTITIES: dict[str, Quantity] = {
    "unload": Quantity("lift the wheel off the road", lambda _: when.unloaded()),
    "load": Quantity("lower the axle until Fz is {value:g} N", when.loaded),
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
"""node -> constants of the set-up that every run record copies from it"""
