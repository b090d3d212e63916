# SPDX-License-Identifier: Apache-2.0
"""Conditions that switch or scale a proposed effect."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.contact_patch.tire_runs import TireRuns


@dataclass(frozen=True)
class Modulator:
    """A factor on an effect."""

    name: str
    words: str
    factor: Callable[[TireRuns], np.ndarray] | None = None
    """its values in some runs, broadcast to (runs, samples); None: 1 everywhere"""

    def values(self, data: TireRuns) -> np.ndarray:
        """Its values in these runs (runs, samples)."""
        ones = np.ones(data.position.shape)
        return ones if self.factor is None else ones * self.factor(data)


def _slip(data: TireRuns) -> np.ndarray:
    return data.kappa[:, None]


def _after(data: TireRuns) -> np.ndarray:
    """1 after the step, 0 before (runs, samples)."""
    return data.since_step > 0.0


MODULATORS: tuple[Modulator, ...] = (
    Modulator("", ""),
    Modulator("driving", "only while driving", lambda d: (_slip(d) > 0.0) * _after(d)),
    Modulator("braking", "only while braking", lambda d: (_slip(d) < 0.0) * _after(d)),
    Modulator("slipping", "only while it slips", lambda d: (_slip(d) != 0.0) * _after(d)),
    Modulator(
        "sign of slip", "with the sign of the slip", lambda d: np.sign(_slip(d)) * _after(d)
    ),
    Modulator(
        "slip", "in proportion to the slip; the size is that at 5 %",
        lambda d: _slip(d) / 0.05 * _after(d),
    ),
    Modulator(
        "size of slip", "in proportion to the size of the slip; the size is that at 5 %",
        lambda d: np.abs(_slip(d)) / 0.05 * _after(d),
    ),
    Modulator(
        "little slip",
        "the less the more it slips; the size is that without slip, at 2 % it is a third",
        lambda d: np.exp(-np.abs(_slip(d)) * _after(d) / 0.02),
    ),
    Modulator(
        "load", "in proportion to the load; the size is that at 4000 N", lambda d: d.load / 4000.0
    ),
    Modulator(
        "speed", "in proportion to the speed of the plank; the size is that at 0.03 m/s",
        lambda d: d.runs.facts["speed"][:, None] / 0.03,
    ),
)  # fmt: skip
BY_NAME = {m.name: m for m in MODULATORS}
