# SPDX-License-Identifier: Apache-2.0
"""Generated series of sweeps: forty with causes of the library or none, twenty with causes that
are in no library."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flatplank_validation.sweep_sets.brush import Brush

NULLS, OF_EACH = 20, 4
CAUSES = {
    "over_temperature": ("grip_temperature", (0.001, 0.006)),
    "over_pressure": ("grip_pressure", (0.1, 0.6)),
    "over_distance": ("wear", (0.01, 0.06)),
    "crosstalk": ("crosstalk", (0.005, 0.03)),
    "turned": ("ply_steer", (0.05, 0.3)),
}
"""field of `Brush` -> identifier of its effect, smallest and largest size"""
OUTSIDE = {
    "zero_by_temperature": ("signal", ("temperature",), (0.5, 4.0)),
    "pull_by_pressure": ("signal", ("pressure",), (20.0, 100.0)),
    "late": ("gain", ("time", "distance"), (0.02, 0.1)),
    "angle_by_distance": ("motion", ("time", "distance"), (0.1, 0.5)),
}
"""field of `Brush` -> family of its hook, its coordinates, smallest and largest size"""
OF_EACH_OUTSIDE = 5
SERIES = NULLS + OF_EACH * len(CAUSES)
NOISE = (5.0, 40.0)
"""smallest and largest standard deviation of the side force [N]"""


@dataclass(frozen=True)
class Case:
    """A series: its tire and bench, its seed, and the name of what is hidden ("": nothing)."""

    number: int
    brush: Brush
    hidden: str


def cases(seed: int) -> Iterator[Case]:
    """The forty series of a seed; sizes and noise are spread evenly in their logarithm."""
    random = np.random.default_rng(seed)
    plan = [""] * NULLS + [cause for cause in CAUSES for _ in range(OF_EACH)]
    for number, cause in enumerate(plan):
        noise = _between(random, *NOISE)
        if not cause:
            yield Case(number, Brush(noise=noise), "")
            continue
        name, sizes = CAUSES[cause]
        yield Case(number, Brush(noise=noise, **{cause: _between(random, *sizes)}), name)


def cases_outside(seed: int) -> Iterator[Case]:
    """Twenty series, each with a cause that is in no library; `hidden` is its field of `Brush`."""
    random = np.random.default_rng(seed)
    for number, cause in enumerate(c for c in OUTSIDE for _ in range(OF_EACH_OUTSIDE)):
        noise, size = _between(random, *NOISE), _between(random, *OUTSIDE[cause][2])
        yield Case(number, Brush(noise=noise, **{cause: size}), cause)


def _between(random: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(random.uniform(np.log(low), np.log(high))))
