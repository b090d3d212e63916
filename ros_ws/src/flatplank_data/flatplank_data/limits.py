# SPDX-License-Identifier: Apache-2.0
"""Ranges of the settings of the machine, for services, plans, panel and simulated bench; and wider
ranges for run records in files."""

from __future__ import annotations

from typing import NamedTuple

from flatplank_data.machine import USABLE_ROAD


class Limit(NamedTuple):
    """Range of one setting."""

    low: float
    high: float
    unit: str
    source: str = ""

    @property
    def bounds(self) -> tuple[float, float]:
        """Lowest and highest value."""
        return self.low, self.high

    def refusal(self, name: str, value: float) -> str:
        """Reason why a value cannot be set, the same text for all callers; empty when it can."""
        if self.low <= value <= self.high:
            return ""
        amount = f"{value:g} {self.unit}".rstrip()
        return f"{name} is {amount}, must be within {self.low:g} .. {self.high:g}"


LIMITS: dict[str, Limit] = {
    "kappa": Limit(-0.5, 0.5, "", "slip control, thesis section 4.2"),
    "fz": Limit(0.0, 8000.0, "N", "measurement hub, thesis section 2.2"),
    "pressure": Limit(0.5, 6.0, "bar", "compressor; placeholder, not in the thesis"),
    "camber_deg": Limit(
        -15.0, 15.0, "deg", "of road and hub each; placeholder, not in the thesis"
    ),
    "steer_deg": Limit(-48.0, 48.0, "deg", "the motor hits the pillar, thesis section 3.1"),
    "effective_rolling_radius": Limit(0.15, 0.5, "m", "wheels that fit the hub; placeholder"),
    "step_position": Limit(0.0, USABLE_ROAD, "m", "the road"),
    "end_position": Limit(0.0, USABLE_ROAD, "m", "the road"),
    "cleat_mm": Limit(0.0, 20.0, "mm", "placeholder, not in the thesis"),
}
"""setting -> range, in the unit that `Limit` states"""

RECORDED: dict[str, Limit] = {
    **{
        key: LIMITS[key]
        for key in ("kappa", "fz", "pressure", "effective_rolling_radius", "step_position")
    },
    "alpha_deg": LIMITS["steer_deg"],
    "wheel_camber_deg": LIMITS["camber_deg"],
}
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
