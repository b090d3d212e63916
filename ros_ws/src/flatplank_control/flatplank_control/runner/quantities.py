# SPDX-License-Identifier: Apache-2.0
"""What an operator sets by hand: how to say it, how the sensors verify it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from flatplank_control.runner import conditions as when
from flatplank_control.runner.steps import Snapshot


@dataclass(frozen=True)
class Quantity:
    """A manual setting."""

    prompt: str
    """with {value}"""
    verify: Callable[[float], when.Condition]
    timeout: float = 120.0
    """for a simulated operator [s of bench time]"""


def _near(
    read: Callable[[Snapshot], float], tolerance: float
) -> Callable[[float], when.Condition]:
    return lambda value: lambda s: abs(read(s) - value) < tolerance


def _not_measured(_value: float) -> when.Condition:
    return lambda _: True


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
    "pressure_bar": Quantity("set the inflation pressure to {value:g} bar", _not_measured),
    "wheel_camber_deg": Quantity("set the camber of the hub to {value:g} deg", _not_measured),
}
