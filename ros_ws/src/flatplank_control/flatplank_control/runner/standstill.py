# SPDX-License-Identifier: Apache-2.0
"""What the hub says of an unloaded tire at rest: zero, noise, channels at their limit."""

from __future__ import annotations

import math

from flatplank_control.runner.steps import PlanFailed, Snapshot

LOOKS = 20
MAX_NOISE = 60.0
"""standard deviation of a force at rest [N]"""


class Standstill:
    """A condition for Wait that collects looks until it knows; refuses a bad bench."""

    def __init__(self, when: str) -> None:
        self.when = when
        self.filter_on = False
        self.fx: list[float] = []
        self.fz: list[float] = []

    def __call__(self, s: Snapshot) -> bool:
        if s.hub.saturated:
            channels = [f"C{i + 1}" for i in range(6) if s.hub.saturated >> i & 1]
            raise PlanFailed(
                f"{', '.join(channels)} at the limit {self.when}: check amplifier and cables"
            )
        self.filter_on = s.hub.filter_on
        self.fx.append(s.hub.contact.fx)
        self.fz.append(s.hub.contact.fz)
        if len(self.fx) < LOOKS:
            return False
        noise = max(_spread(self.fx), _spread(self.fz))
        if noise > MAX_NOISE:
            raise PlanFailed(
                f"noise at rest is {noise:.0f} N {self.when}, at most {MAX_NOISE:g} N: "
                "look for loose cables"
            )
        return True

    @property
    def zero(self) -> tuple[float, float]:
        """Mean Fx and Fz [N]; NaN before the first look."""
        return _mean(self.fx), _mean(self.fz)

    def facts(self) -> dict[str, float]:
        """For the journal."""
        fx, fz = self.zero
        return {
            "zero_fx": round(fx, 2),
            "zero_fz": round(fz, 2),
            "noise": round(_spread(self.fz), 2),
        }


def _mean(values: list[float]) -> float:
    return sum(values) / len(values) if values else math.nan


def _spread(values: list[float]) -> float:
    mean = _mean(values)
    return math.sqrt(sum((v - mean) ** 2 for v in values) / max(len(values) - 1, 1))
