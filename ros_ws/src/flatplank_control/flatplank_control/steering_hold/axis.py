# SPDX-License-Identifier: Apache-2.0
"""Angle of a driven steering or camber axis: held, or led along a profile."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from flatplank_control.steering_hold.hold import HoldParameters, SteeringHold
from flatplank_control.steering_hold.profiles import PROFILES, Profile
from flatplank_data.params import ParameterError, describe, from_mapping, nearest, param
from flatplank_hw.answers import Answer, refused
from flatplank_hw.samples import EncoderSample, HubSample, Reference

SOURCE = "follow"
ANGLES: dict[str, Callable[[EncoderSample], float]] = {
    "steer": lambda e: e.steer_angle,
    "camber": lambda e: e.road_camber,
}
"""axis -> its angle [rad] in the encoders' sample"""
OK = Answer(True, "", 0)


@dataclass(frozen=True)
class AngleParameters(HoldParameters):
    """The hold, and which axis it has."""

    axis: str = param("steer", "axis that is led", choices=sorted(ANGLES), read_only=True)
    rate_hz: float = param(250.0, "bus rate", unit="Hz", bounds=(10.0, 4000.0))
    limit: float = param(0.8378, "largest angle: 48 deg", unit="rad", bounds=(0.0, math.pi))


class AngleControl:
    """`reference` gives the speed of the axis; without a profile it holds the angle of its
    beginning."""

    def __init__(self, p: AngleParameters) -> None:
        self.parameters = p
        self._hold = SteeringHold(p)
        self._read = ANGLES[p.axis]
        self._profile: Profile | None = None
        self._since = 0.0
        self.wanted = math.nan
        self._base = math.nan

    def reset(self) -> None:
        """Hold what is there, from the next cycle on."""
        self._profile, self.wanted, self._base = None, math.nan, math.nan
        self._hold.reset()

    def hold(self, angle: float) -> Answer:
        """Hold this angle [rad]."""
        if not abs(angle) <= self.parameters.limit:
            return refused(f"angle of {angle:.3g} rad is beyond {self.parameters.limit:.3g} rad")
        self._profile, self.wanted = None, angle
        self._base = angle
        return OK

    def set_profile(self, name: str, values: Mapping[str, float]) -> Answer:
        """Lead the axis along a profile, from the next cycle on; refused as a whole."""
        kind = PROFILES.get(name)
        if kind is None:
            return refused(f"unknown profile '{name}'{nearest(name, PROFILES)}")
        # a message has no whole numbers
        whole = {i.name for i in describe(kind) if isinstance(i.default, int)}
        values = {k: int(v) if k in whole and v == v // 1 else v for k, v in values.items()}
        try:
            profile: Profile = from_mapping(kind, values, f"profile {name}")  # type: ignore[type-var]
        except ParameterError as error:
            return refused(str(error))
        if profile.largest() > self.parameters.limit:
            return refused(f"profile {name} reaches {profile.largest():.3g} rad, beyond "
                           f"{self.parameters.limit:.3g} rad")  # fmt: skip
        self._profile, self._since = profile, 0.0
        return OK

    def reference(self, hub: HubSample, encoders: EncoderSample) -> Reference:
        """Set-point of the axis in mode `follow` [rad/s]."""
        p = self.parameters
        angle = self._read(encoders)
        if self._base != self._base:
            self._base = self.wanted = angle
        ahead = 0.0
        if self._profile is not None:
            wanted = self._profile.angle(self._since)
            self._since += 1.0 / p.rate_hz
            ahead = (self._profile.angle(self._since) - wanted) * p.rate_hz
            self.wanted = wanted
        # a moment [N m] about z of the tire turns the hub within the play of its worm
        speed = ahead + self._hold.step(self.wanted, angle, hub.contact.mz)
        speed = min(max(speed, -p.speed_limit), p.speed_limit)
        return Reference(encoders.cycle, encoders.stamp_ns, SOURCE, speed, True)
