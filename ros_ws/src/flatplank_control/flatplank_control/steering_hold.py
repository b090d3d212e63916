# SPDX-License-Identifier: Apache-2.0
"""Controls the angle of a driven steering or camber axis: holds it, or follows a profile.

The hold keeps the hub's angle in spite of the play in its worm drive. An encoder on the hub
measures the play. An encoder on the worm, as in the thesis (3.1, issue 10), does not; then the
sign of the tire's moment about z shows on which side of the play the hub rests. The pre-flight
sheet (`flatplank calibrate sheet`) has the size of the play."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from flatplank_data.limits import Limit
from flatplank_data.names import nearest_hint
from flatplank_data.params import (
    ParameterError,
    Params,
    from_mapping,
    param,
    parameter_infos,
)
from flatplank_data.waveforms import in_words, triangle
from flatplank_hw.answers import Answer, refused
from flatplank_hw.samples import FOLLOW, EncoderSample, HubSample, Reference

ANGLE = (-math.pi, math.pi)
TIME = (1e-3, 1e4)


@dataclass(frozen=True)
class Profile(Params):
    """Angle over time: `angle(t)` [rad] for t >= 0 [s]."""

    name: ClassVar[str]

    def angle(self, t: float) -> float:
        raise TypeError(f"{type(self).__name__} must define angle")

    def largest(self) -> float:
        """Largest |angle| [rad]."""
        p: Any = self
        return abs(p.amplitude)

    def shown_after(self) -> float:
        """Time until the largest angle, or until the end of a finite profile [s]."""
        raise TypeError(f"{type(self).__name__} must define shown_after")


@dataclass(frozen=True)
class Wave(Profile):
    """Periodic angle without end."""

    amplitude: float = param(0.0, "amplitude of the angle", unit="rad", bounds=ANGLE)
    period: float = param(10.0, "period of the wave", unit="s", bounds=TIME)
    offset: float = param(0.0, "mean angle", unit="rad", bounds=ANGLE)

    def largest(self) -> float:
        return abs(self.amplitude) + abs(self.offset)

    def shown_after(self) -> float:
        return 0.25 * self.period


@dataclass(frozen=True)
class Sine(Wave):
    """offset + amplitude sin(2 pi t / period)."""

    name = "sine"

    def angle(self, t: float) -> float:
        return self.offset + self.amplitude * math.sin(math.tau * t / self.period)


@dataclass(frozen=True)
class Triangle(Wave):
    """offset + amplitude times a triangle that starts upwards from 0."""

    name = "triangle"

    def angle(self, t: float) -> float:
        return self.offset + self.amplitude * triangle(t / self.period)


@dataclass(frozen=True)
class Parking(Profile):
    """`cycles` triangles of the angle at a constant rate, then 0; for a standing tire."""

    name = "parking"
    amplitude: float = param(0.3, "largest angle", unit="rad", bounds=ANGLE)
    rate: float = param(0.017, "rate of the angle: 1 deg/s", unit="rad/s", bounds=(1e-4, 1.0))
    cycles: int = param(1, "number of triangles, to both sides", bounds=(1, 100))

    def angle(self, t: float) -> float:
        if t >= self.shown_after():
            return 0.0
        return self.amplitude * triangle(t / (self.shown_after() / self.cycles))

    def shown_after(self) -> float:
        return self.cycles * 4.0 * abs(self.amplitude) / self.rate


@dataclass(frozen=True)
class Impulse(Profile):
    """One triangular pulse of the angle, for a rolling tire."""

    name = "impulse"
    amplitude: float = param(0.02, "largest angle", unit="rad", bounds=ANGLE)
    start: float = param(1.0, "start of the impulse", unit="s", bounds=(0.0, 1e4))
    length: float = param(1.0, "duration of the impulse", unit="s", bounds=TIME)

    def angle(self, t: float) -> float:
        share = (t - self.start) / self.length
        return self.amplitude * (1.0 - abs(2.0 * share - 1.0)) if 0.0 < share < 1.0 else 0.0

    def shown_after(self) -> float:
        return self.start + self.length


PROFILES: dict[str, type[Profile]] = {
    kind.name: kind for kind in (Sine, Triangle, Parking, Impulse)
}
"""name -> profile; add a new one as a class and an entry here"""


@dataclass(frozen=True)
class HoldParameters(Params):
    """Parameters of the hold. `play` is 0 when the encoder is on the hub."""

    enabled: bool = param(True, "hold the hub's angle instead of the motor's")
    gain: float = param(6.0, "speed over angle error", unit="1/s", bounds=(0.1, 100.0))
    dead_band: float = param(
        3.5e-4, "error without a correction: 0.02 deg", unit="rad", bounds=(0.0, 0.1)
    )
    speed_limit: float = param(0.035, "largest speed: 2 deg/s", unit="rad/s", bounds=(1e-4, 1.0))
    play: float = param(
        0.0, "gap of the worm that the encoder does not measure", unit="rad", bounds=(0.0, 0.1)
    )
    play_moment: float = param(
        15.0, "moment about z from which the hub has crossed the gap", unit="N m",
        bounds=(0.0, 1e4),
    )  # fmt: skip


class SteeringHold:
    """Proportional controller of the hub's angle with a dead band; `step` returns the speed of
    the axis [rad/s]."""

    def __init__(self, p: HoldParameters) -> None:
        self.parameters = p
        self.reset()

    def reset(self) -> None:
        """Assume that the hub is in the middle of the play."""
        self.side = 0.0

    def step(self, wanted: float, angle: float, moment: float = 0.0) -> float:
        """Axis speed for the wanted and measured angle [rad] and the tire's moment about z [N m];
        0 when off."""
        p = self.parameters
        if abs(moment) > p.play_moment:
            # a positive moment turns the wheel to the left, which lowers the slip angle
            self.side = -0.5 * p.play if moment > 0.0 else 0.5 * p.play
        error = wanted - angle - self.side
        if not p.enabled or abs(error) < p.dead_band:
            return 0.0
        return min(max(p.gain * error, -p.speed_limit), p.speed_limit)


ANGLES: dict[str, Callable[[EncoderSample], float]] = {
    "steer": lambda e: e.steer_angle,
    "camber": lambda e: e.road_camber,
}
"""axis -> its angle [rad] in an encoder sample"""


@dataclass(frozen=True)
class AngleParameters(HoldParameters):
    """Parameters of the hold and of its axis."""

    axis: str = param("steer", "controlled axis", choices=sorted(ANGLES), read_only=True)
    rate_hz: float = param(250.0, "bus rate", unit="Hz", bounds=(10.0, 4000.0))
    limit: float = param(0.8378, "largest angle", unit="rad", bounds=(0.0, math.pi))


class AngleControl:
    """Controller of a driven axis: holds its present angle or a given one, or follows a profile.

    `reference` returns the speed of the axis.
    """

    def __init__(self, p: AngleParameters) -> None:
        self.parameters = p
        self._hold = SteeringHold(p)
        self._read = ANGLES[p.axis]
        self._profile: Profile | None = None
        self._since = 0.0
        self.wanted = math.nan

    def reset(self) -> None:
        """Hold the present angle from the next cycle on."""
        self._profile, self.wanted = None, math.nan
        self._hold.reset()

    def hold(self, angle: float) -> Answer:
        """Hold this angle [rad]."""
        most = self.parameters.limit
        if reason := Limit(-most, most, "rad").refusal("angle", angle):
            return refused(reason)
        self._profile, self.wanted = None, angle
        return Answer(True, f"the angle is held at {math.degrees(angle):+.4g} deg", 0)

    def set_profile(self, name: str, values: Mapping[str, float]) -> Answer:
        """Follow a profile from the next cycle on; a faulty one is refused as a whole."""
        kind = PROFILES.get(name)
        if kind is None:
            return refused(f"unknown profile '{name}'{nearest_hint(name, PROFILES)}")
        # the message has floats only
        whole = {i.name for i in parameter_infos(kind) if isinstance(i.default, int)}
        values = {k: int(v) if k in whole and v == v // 1 else v for k, v in values.items()}
        try:
            profile = from_mapping(kind, values, f"profile {name}")
        except ParameterError as error:
            return refused(str(error))
        if profile.largest() > self.parameters.limit:
            return refused(f"profile {name} reaches {profile.largest():.3g} rad, beyond "
                           f"{self.parameters.limit:.3g} rad")  # fmt: skip
        self._profile, self._since = profile, 0.0
        return Answer(True, f"{name} of {in_words(profile, values)}", 0)

    def reference(self, hub: HubSample, encoders: EncoderSample) -> Reference:
        """Set-point of the axis in mode `follow` [rad/s]."""
        p = self.parameters
        angle = self._read(encoders)
        if self.wanted != self.wanted:
            self.wanted = angle
        ahead = 0.0
        if self._profile is not None:
            wanted = self._profile.angle(self._since)
            self._since += 1.0 / p.rate_hz
            ahead = (self._profile.angle(self._since) - wanted) * p.rate_hz
            self.wanted = wanted
        # the tire's moment about z [N m] turns the hub within the play of its worm
        speed = ahead + self._hold.step(self.wanted, angle, hub.contact.mz)
        speed = min(max(speed, -p.speed_limit), p.speed_limit)
        return Reference(encoders.cycle, encoders.stamp_ns, FOLLOW, speed, True)
