# SPDX-License-Identifier: Apache-2.0
"""Why a run cannot be made on this machine with this tire; asked before anything moves."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from flatplank_control.runner.campaign.tires import TireEntry
from flatplank_control.runner.measurement import (
    DRAGGED,
    PROFILED,
    ROAD_LENGTH,
    Measurement,
)
from flatplank_control.runner.plans import PLANS
from flatplank_control.runner.standing import CLEAT_AT, STANDS_AT
from flatplank_control.sequencer.waveforms import WAVEFORMS
from flatplank_control.sequencer.waveforms.base import LENGTH
from flatplank_control.steering_hold.profiles import PROFILES, Profile
from flatplank_data.limits import LIMITS
from flatplank_data.params import ParameterError, from_mapping, nearest

STEER_LIMIT = LIMITS["steer_deg"].high
"""[deg]"""


@dataclass(frozen=True)
class SetUp:
    """What of the machine, as it stands now, is in the way."""

    blocked: tuple[tuple[float, float], ...] = ()
    """wheel angles from .. to [deg] at which something would collide; may go through 0"""
    steer_limit: float = STEER_LIMIT
    """[deg]"""


Check = Callable[[Measurement, TireEntry, SetUp], tuple[str, str] | None]
"""(measurement, tire, set_up) -> key at fault and reason, or None"""
LEAST_ANGLE = 5.0
"""[deg]"""
LEAST_ROAD = 0.2
"""a slip needs at least so much road behind its start to be seen [m]"""


def load(m: Measurement, tire: TireEntry, set_up: SetUp) -> tuple[str, str] | None:
    if 0.0 < m.fz <= tire.max_load or m.measurement == "unloaded_turn":
        return None
    if m.fz == 0.0:
        return "fz", f"fz of 0 N: give a load, up to {tire.max_load:g} N"
    return "fz", f"fz of {m.fz:g} N: the {tire.name} stands up to {tire.max_load:g} N"


def pressure(m: Measurement, tire: TireEntry, set_up: SetUp) -> tuple[str, str] | None:
    low, high = tire.pressure_range
    if low <= m.pressure <= high:
        return None
    return "pressure", (
        f"pressure of {m.pressure:g} bar: the {tire.name} takes {low:g} .. {high:g} bar"
    )


def kind(m: Measurement, tire: TireEntry, set_up: SetUp) -> tuple[str, str] | None:
    if m.measurement in PLANS:
        return None
    return "measurement", f"measurement is '{m.measurement}'{nearest(m.measurement, PLANS)}"


def road(m: Measurement, tire: TireEntry, set_up: SetUp) -> tuple[str, str] | None:
    """The waveform, from its start on, must fit on the road."""
    if m.measurement in DRAGGED and m.distance > 0.0 and STANDS_AT + m.distance > ROAD_LENGTH:
        return "distance", f"distance of {m.distance:g} m: there are {ROAD_LENGTH - STANDS_AT:g} m"
    if m.measurement != "slip":
        return None
    try:
        needed = max(waveform_length(m), LEAST_ROAD)
    except ParameterError as error:
        return "waveform_parameters", str(error)
    left = m.end_position - m.step_position
    if needed <= left + 1e-9:
        return None
    return "waveform_parameters" if m.waveform_parameters else "step_position", (
        f"the {m.waveform} needs {needed:g} m of road behind {m.step_position:g} m, "
        f"there are {left:g} m up to {m.end_position:g} m"
    )


def cleat(m: Measurement, tire: TireEntry, set_up: SetUp) -> tuple[str, str] | None:
    """The tire must roll over the cleat and down again."""
    needed = CLEAT_AT + LEAST_ROAD
    if m.measurement != "cleat" or m.end_position >= needed:
        return None
    return "end_position", (
        f"end_position of {m.end_position:g} m: the cleat is at {CLEAT_AT:g} m, "
        f"give {needed:g} m or more"
    )


def collision(m: Measurement, tire: TireEntry, set_up: SetUp) -> tuple[str, str] | None:
    """Wheel angles at which something of the set-up stands in the way (valve, balance weight)."""
    angle = m.start_angle
    given = m.start_angle_deg is None
    key, name = ("start", f"start {m.start}") if given else ("start_angle_deg", "start_angle_deg")
    for low, high in set_up.blocked:
        if high - low >= 360.0 or (angle - low) % 360.0 <= (high - low) % 360.0:
            return key, (
                f"{name} ({angle:g} deg) collides: {low:g} .. {high:g} deg of the wheel "
                "are blocked in set_up; take another start"
            )
    return None


def steering(m: Measurement, tire: TireEntry, set_up: SetUp) -> tuple[str, str] | None:
    if abs(m.alpha_deg) <= set_up.steer_limit:
        return None
    return "alpha_deg", (
        f"alpha of {m.alpha_deg:g} deg: the motor hits the pillar at {set_up.steer_limit:g} deg"
    )


def oblique(m: Measurement, tire: TireEntry, set_up: SetUp) -> tuple[str, str] | None:
    """The lateral stiffness comes from a road that moves across the wheel."""
    if m.measurement == "stiffness_lateral" and abs(m.alpha_deg) < LEAST_ANGLE:
        return "alpha_deg", (
            f"alpha of {m.alpha_deg:g} deg: a lateral stiffness needs {LEAST_ANGLE:g} deg or more"
        )
    return None


def _profile(m: Measurement) -> Profile:
    found: Any = from_mapping(PROFILES[m.profile], m.profile_parameters, "profile")  # type: ignore[type-var]
    return found


def angles(m: Measurement, tire: TireEntry, set_up: SetUp) -> tuple[str, str] | None:
    """A profile must stay within what its axis can."""
    if m.measurement not in PROFILED:
        return None
    limit = LIMITS["camber_deg"].high if m.measurement == "camber_sweep" else set_up.steer_limit
    most = math.degrees(_profile(m).largest())
    if most <= limit:
        return None
    return "profile_parameters", f"the {m.profile} reaches {most:.3g} deg, the axis {limit:g} deg"


def in_time(m: Measurement, tire: TireEntry, set_up: SetUp) -> tuple[str, str] | None:
    """A profile must have shown itself before the run is over."""
    if m.measurement not in PROFILED:
        return None
    standing = m.measurement == "parking"
    there = m.profile_time if standing else (m.end_position - m.step_position) / m.speed
    needed = _profile(m).shown_after()
    if needed <= there + 1e-9:
        return None
    return "profile_time" if standing else "profile_parameters", (
        f"the {m.profile} needs {needed:.3g} s, there are {there:.3g} s"
    )


CHECKS: tuple[Check, ...] = (
    kind, load, pressure, road, cleat, collision, steering, oblique, angles, in_time,
)  # fmt: skip


def refuse(m: Measurement, tire: TireEntry, set_up: SetUp) -> Iterator[tuple[str, str]]:
    """(key at fault, reason) of everything that speaks against a run."""
    for check in CHECKS:
        found = check(m, tire, set_up)
        if found:
            yield found


def waveform_length(m: Measurement) -> float:
    """Road that the waveform takes by its own parameters [m]; 0 when it has no end."""
    wave = from_mapping(WAVEFORMS[m.waveform], m.slip_parameters(), f"waveform {m.waveform}")
    names = ("length", "wavelength", "distance")
    length = float(next((getattr(wave, n) for n in names if hasattr(wave, n)), 0.0))
    return length if length < LENGTH[1] else 0.0
