# SPDX-License-Identifier: Apache-2.0
"""Angle over time of an axis: what LabVIEW gave the camber axis, and parking for the steering."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

from flatplank_data.params import Params, param

ANGLE = (-math.pi, math.pi)
TIME = (1e-3, 1e4)


@dataclass(frozen=True)
class Profile(Params):
    """`angle(t)` [rad] for t >= 0 [s]."""

    name: ClassVar[str]

    def angle(self, t: float) -> float:
        raise TypeError(f"{type(self).__name__} must define angle")

    def largest(self) -> float:
        """Of |angle| [rad]."""
        p: Any = self
        return abs(p.amplitude) + abs(getattr(p, "offset", 0.0))

    def shown_after(self) -> float:
        """When it has reached its largest angle, or is over where it has an end [s]."""
        p: Any = self
        return 0.25 * p.period


@dataclass(frozen=True)
class Sine(Profile):
    """offset + amplitude sin(2 pi t / period)."""

    name = "sine"
    amplitude: float = param(0.0, "of the angle", unit="rad", bounds=ANGLE)
    period: float = param(10.0, "of the sine", unit="s", bounds=TIME)
    offset: float = param(0.0, "mean angle", unit="rad", bounds=ANGLE)

    def angle(self, t: float) -> float:
        return self.offset + self.amplitude * math.sin(math.tau * t / self.period)


@dataclass(frozen=True)
class Triangle(Profile):
    """offset + amplitude times a triangle that starts upwards from 0."""

    name = "triangle"
    amplitude: float = param(0.0, "of the angle", unit="rad", bounds=ANGLE)
    period: float = param(10.0, "of the triangle", unit="s", bounds=TIME)
    offset: float = param(0.0, "mean angle", unit="rad", bounds=ANGLE)

    def angle(self, t: float) -> float:
        quarter = (t / self.period + 0.25) % 1.0
        return self.offset + self.amplitude * (1.0 - 4.0 * abs(quarter - 0.5))


@dataclass(frozen=True)
class Parking(Profile):
    """To and fro at a constant rate on the standing tire, so many times, then back to zero."""

    name = "parking"
    amplitude: float = param(0.3, "largest angle", unit="rad", bounds=ANGLE)
    rate: float = param(0.017, "1 deg/s", unit="rad/s", bounds=(1e-4, 1.0))
    cycles: int = param(1, "to both sides", bounds=(1, 100))

    def angle(self, t: float) -> float:
        if t >= self.shown_after():
            return 0.0
        period = self.shown_after() / self.cycles
        quarter = (t / period + 0.25) % 1.0
        return self.amplitude * (1.0 - 4.0 * abs(quarter - 0.5))

    def shown_after(self) -> float:
        return self.cycles * 4.0 * abs(self.amplitude) / self.rate


@dataclass(frozen=True)
class Impulse(Profile):
    """A short turn of the steering and back: the impulse of a rolling tire."""

    name = "impulse"
    amplitude: float = param(0.02, "angle at its top", unit="rad", bounds=ANGLE)
    start: float = param(1.0, "of the impulse", unit="s", bounds=(0.0, 1e4))
    length: float = param(1.0, "there and back", unit="s", bounds=TIME)

    def angle(self, t: float) -> float:
        share = (t - self.start) / self.length
        return self.amplitude * (1.0 - abs(2.0 * share - 1.0)) if 0.0 < share < 1.0 else 0.0

    def shown_after(self) -> float:
        return self.start + self.length


PROFILES: dict[str, Callable[..., Profile]] = {
    kind.name: kind for kind in (Sine, Triangle, Parking, Impulse)
}
"""name -> profile; a new one is a class and its place here"""
