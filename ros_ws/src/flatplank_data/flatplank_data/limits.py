# SPDX-License-Identifier: Apache-2.0
"""Ranges of the settings of the machine, for services, plans, panel and simulated bench; and wider
ranges for run records in files."""

from __future__ import annotations

import math
from typing import NamedTuple

from flatplank_data.machine import ROAD_LENGTH, USABLE_ROAD
from flatplank_data.wording import displayed

SHARE = "1"
"""unit of a share, of a slip: people read it in %"""


class Limit(NamedTuple):
    """Range of one number, and the gate that every number passes before a core uses it."""

    low: float
    high: float
    unit: str
    source: str = ""
    quotation: str = ""
    """sentence of the thesis that gives the limit; empty: the thesis has no such limit"""

    @property
    def bounds(self) -> tuple[float, float]:
        """Lowest and highest value."""
        return self.low, self.high

    def admits(self, value: float) -> bool:
        """True for a finite number within the range."""
        return self.low <= value <= self.high and math.isfinite(value)

    def refusal(self, name: str, value: float) -> str:
        """Reason why a number is refused, the same text for all callers; empty when it is not."""
        if self.admits(value):
            return ""
        if not math.isfinite(value):
            return f"{name} is {value}, must be finite"
        factor, unit = displayed(self.unit) if self.unit == SHARE else (1.0, self.unit)
        amount = f"{factor * value:g} {unit}".rstrip()
        given = f" ({name} = {value:g})" if factor != 1.0 else ""
        ends = f"{factor * self.low:g} .. {factor * self.high:g}"
        shown = f" {unit}" if given else ""
        return f"{name} is {amount}{given}, must be within {ends}{shown}"


TIRE_RADIUS = (0.210, 0.387)
"""smallest and largest free radius of a tire on the hub [m]"""
_MOUNTED = "The allowable tire radius that can be mounted ranges from 0.210 m to 0.387 m."
_ROAD = f"the road length is now equal to {ROAD_LENGTH} m"

LIMITS: dict[str, Limit] = {
    "kappa": Limit(-0.5, 0.5, SHARE, "placeholder: the measured steps go to 30 %, figure 2.5"),
    "fz": Limit(
        0.0, 8000.0, "N", "thesis 2.2", "The maximum allowed vertical force is 8 kN."
    ),
    "pressure": Limit(0.5, 6.0, "bar", "placeholder: the measured tires have 2 .. 2.8 bar"),
    "wheel_camber_deg": Limit(
        -30.0, 30.0, "deg", "thesis 2.2", "The measurement hub can also be cambered to ±30°"
    ),
    "road_camber_deg": Limit(
        -15.0, 15.0, "deg", "thesis 2.2",
        "the plank can be tilted to ±15° to represent road camber",
    ),
    "gamma_deg": Limit(
        -45.0, 45.0, "deg", "thesis 2.2, hub and road together",
        "thus allowing a total range of ±45°",
    ),
    "steer_deg": Limit(
        -90.0, 90.0, "deg", "thesis 2.2",
        "It is possible to steer the wheel 360°, but in practice, the used range is ±90°.",
    ),
    "free_radius": Limit(*TIRE_RADIUS, "m", "thesis 2.2", _MOUNTED),
    "effective_rolling_radius": Limit(
        0.175, TIRE_RADIUS[1], "m",
        "thesis 2.2; the smallest tire pressed in by half: r_e = r_0 - deflection / 3", _MOUNTED,
    ),
    "step_position": Limit(0.0, USABLE_ROAD, "m", "thesis 3.1", _ROAD),
    "end_position": Limit(0.0, USABLE_ROAD, "m", "thesis 3.1", _ROAD),
    "cleat_mm": Limit(0.0, 20.0, "mm", "placeholder: the thesis has cleats without a height"),
}  # fmt: skip
"""setting -> range, in the unit that `Limit` states"""

PILLAR_DEG = 48.0
"""steering angle beyond which the motor of the wheel hits the pillar, unless the hub is moved
inward [deg]; thesis 3.1: "The servomotor hits the pillar when a steering angle larger than 48° is
desired." """
FORCE = Limit(-1e6, 1e6, "N", "a hundred times what the hub is made for")
"""measured forces that a controller takes"""

RECORDED: dict[str, Limit] = {
    **{
        key: LIMITS[key]
        for key in (
            "kappa", "fz", "pressure", "effective_rolling_radius", "step_position",
            "wheel_camber_deg", "gamma_deg",
        )
    },
    "alpha_deg": LIMITS["steer_deg"],
}  # fmt: skip
"""key of a plan or run record -> range"""


def _angle(most: float) -> Limit:
    return Limit(-most, most, "deg")


IN_FILES: dict[str, Limit] = {
    "kappa": LIMITS["kappa"],
    "fz": Limit(0.0, 20_000.0, "N"),
    "pressure": Limit(0.0, 10.0, "bar"),
    "alpha_deg": LIMITS["steer_deg"],
    "gamma_deg": _angle(90.0),
    "effective_rolling_radius": Limit(0.01, 2.0, "m"),
    "step_position": Limit(0.0, 10.0, "m"),
    "speed": Limit(0.0, 5.0, "m/s"),
    "et_value": Limit(-1.0, 1.0, "m"),
    "adapter_thickness": Limit(-1.0, 1.0, "m"),
    "wheel_camber_deg": _angle(90.0),
    "road_camber_offset_deg": _angle(90.0),
    "slip_angle_offset_deg": _angle(90.0),
    "start": Limit(1, 3, "-"),
    "start_angle_deg": _angle(360.0),
    "cycles_received": Limit(0, 2**63, "-"),
    "cycles_lost": Limit(0, 2**63, "-"),
}
"""key of a run record in a file -> range; wider than that of the machine, so that files from other
benches can be read"""


def refusal(setting: str, value: float) -> str:
    """Reason why a setting cannot have a value; empty when it can."""
    return LIMITS[setting].refusal(setting, value)
