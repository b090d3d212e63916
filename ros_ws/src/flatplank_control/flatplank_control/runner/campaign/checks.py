# SPDX-License-Identifier: Apache-2.0
"""Checks, before anything moves, whether a run is possible on this machine with this tire."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from flatplank_control.runner.campaign.tires import TireEntry
from flatplank_control.runner.measurement import DRAGGED, PROFILED, ROAD_LENGTH, Measurement
from flatplank_control.runner.plans import CLEAT_AT, PLANS, STANDS_AT
from flatplank_control.steering_hold import PROFILES
from flatplank_data.limits import LIMITS, PILLAR_DEG
from flatplank_data.names import nearest_hint
from flatplank_data.params import ParameterError, from_mapping
from flatplank_data.waveforms import LENGTH, WAVEFORMS

"""largest steering angle [deg]"""


@dataclass(frozen=True)
class SetUp:
    """Restrictions of the present machine set-up."""

    blocked: tuple[tuple[float, float], ...] = ()
    """ranges of the wheel angle (from, to) [deg] with a collision; a range may include 0"""
    steer_limit: float = PILLAR_DEG
    """largest steering angle of this set-up [deg]"""


Problem = tuple[str, str]
"""(key at fault, reason)"""
LEAST_ANGLE = 5.0
"""smallest steering angle of a lateral stiffness run [deg]"""
LEAST_ROAD = 0.2
"""shortest road after the start of a slip waveform [m]"""


def problems_of_run(m: Measurement, tire: TireEntry, set_up: SetUp) -> Iterator[Problem]:
    """All reasons against a run."""
    if m.measurement not in PLANS:
        yield (
            "measurement",
            f"measurement is '{m.measurement}'{nearest_hint(m.measurement, PLANS)}",
        )
    yield from _of_the_tire(m, tire)
    yield from _of_the_road(m)
    yield from _of_the_angles(m, set_up)
    if m.measurement in PROFILED:
        yield from _of_the_profile(m, set_up)


def _of_the_tire(m: Measurement, tire: TireEntry) -> Iterator[Problem]:
    if m.fz == 0.0 and m.measurement != "unloaded_turn":
        yield "fz", f"fz of 0 N: give a load, up to {tire.max_load:g} N"
    elif not 0.0 < m.fz <= tire.max_load and m.measurement != "unloaded_turn":
        yield "fz", f"fz of {m.fz:g} N: the {tire.name} stands up to {tire.max_load:g} N"
    low, high = tire.pressure_range
    if not low <= m.pressure <= high:
        words = f"pressure of {m.pressure:g} bar"
        yield "pressure", f"{words}: the {tire.name} takes {low:g} .. {high:g} bar"


def _of_the_road(m: Measurement) -> Iterator[Problem]:
    """Check that the waveform fits on the road after its start, and that a cleat is reached."""
    if m.measurement in DRAGGED and m.distance > 0.0 and STANDS_AT + m.distance > ROAD_LENGTH:
        left = ROAD_LENGTH - STANDS_AT
        yield "distance", f"distance of {m.distance:g} m: there are {left:g} m"
    elif m.measurement == "slip":
        yield from _of_the_waveform(m)
    elif m.measurement == "cleat" and m.end_position < (needed := CLEAT_AT + LEAST_ROAD):
        there = f"the cleat is at {CLEAT_AT:g} m, give {needed:g} m or more"
        yield "end_position", f"end_position of {m.end_position:g} m: {there}"


def _of_the_waveform(m: Measurement) -> Iterator[Problem]:
    try:
        needed = max(waveform_length(m), LEAST_ROAD)
    except ParameterError as error:
        yield "waveform_parameters", str(error)
        return
    left = m.end_position - m.step_position
    if needed > left + 1e-9:
        key = "waveform_parameters" if m.waveform_parameters else "step_position"
        behind = f"the {m.waveform} needs {needed:g} m of road behind {m.step_position:g} m"
        yield key, f"{behind}, there are {left:g} m up to {m.end_position:g} m"


def _of_the_angles(m: Measurement, set_up: SetUp) -> Iterator[Problem]:
    """Check the angles against obstacles at the wheel (valve, balance weight) and the steering
    limit; a lateral stiffness needs a steered wheel."""
    angle = m.start_angle
    given = m.start_angle_deg is None
    key, name = ("start", f"start {m.start}") if given else ("start_angle_deg", "start_angle_deg")
    for low, high in set_up.blocked:
        if high - low >= 360.0 or (angle - low) % 360.0 <= (high - low) % 360.0:
            blocked = f"{low:g} .. {high:g} deg of the wheel are blocked in set_up"
            yield key, f"{name} ({angle:g} deg) collides: {blocked}; take another start"
            break
    alpha = f"alpha of {m.alpha_deg:g} deg"
    if abs(m.alpha_deg) > set_up.steer_limit:
        pillar = f"the motor hits the pillar at {set_up.steer_limit:g} deg"
        more = "with the hub moved inward give set_up its steer_limit_deg"
        yield "alpha_deg", f"{alpha}: {pillar}; {more}"
    if m.measurement == "stiffness_lateral" and abs(m.alpha_deg) < LEAST_ANGLE:
        least = f"{LEAST_ANGLE:g} deg or more"
        yield "alpha_deg", f"{alpha}: a lateral stiffness needs {least}"


def _of_the_profile(m: Measurement, set_up: SetUp) -> Iterator[Problem]:
    """Check that the profile stays within the range of its axis and fits into the run."""
    profile = from_mapping(PROFILES[m.profile], m.profile_parameters, "profile")
    limit = (
        LIMITS["road_camber_deg"].high if m.measurement == "camber_sweep" else set_up.steer_limit
    )
    most = math.degrees(profile.largest())
    if most > limit:
        reach = f"the {m.profile} reaches {most:.3g} deg"
        yield "profile_parameters", f"{reach}, the axis {limit:g} deg"
    standing = m.measurement == "parking"
    there = m.profile_time if standing else (m.end_position - m.step_position) / m.speed
    needed = profile.shown_after()
    if needed > there + 1e-9:
        key = "profile_time" if standing else "profile_parameters"
        yield key, f"the {m.profile} needs {needed:.3g} s, there are {there:.3g} s"


def waveform_length(m: Measurement) -> float:
    """Length of the waveform on the road by its parameters [m]; 0 when it has no end."""
    wave = from_mapping(WAVEFORMS[m.waveform], m.slip_parameters(), f"waveform {m.waveform}")
    length = float(getattr(wave, "length", getattr(wave, "wavelength", 0.0)))
    return length if length < LENGTH[1] else 0.0
