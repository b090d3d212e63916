# SPDX-License-Identifier: Apache-2.0
"""Runs that the bench could make beside those of the data: one axis at a time gets a new level."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..information import Candidate
from .points import SteadyPoints

GRAIN = {
    "fz": 200.0,
    "kappa": 0.005,
    "alpha": np.radians(0.5),
    "gamma": np.radians(0.5),
    "pressure": 5e3,
}
"""Levels closer than this are one level."""
REACH = {
    "fz": (1000.0, 2000.0, 3000.0, 4000.0, 5000.0, 6000.0, 7000.0, 8000.0),
    "kappa": (-0.15, -0.1, -0.05, -0.02, -0.01, 0.0, 0.01, 0.02, 0.05, 0.1, 0.15),
    "alpha": tuple(np.radians((-10.0, -5.0, -2.0, -1.0, 0.0, 1.0, 2.0, 5.0, 10.0, 15.0))),
    "gamma": tuple(np.radians((-5.0, -2.5, 0.0, 2.5, 5.0))),
    "pressure": (150e3, 180e3, 200e3, 220e3, 250e3, 280e3, 300e3, 330e3),
}
"""What the flat plank bench can set."""
SHOW: dict[str, Callable[[float], str]] = {
    "fz": lambda v: f"a load of {v:.0f} N",
    "kappa": lambda v: f"a slip of {100 * v:+.0f} %",
    "alpha": lambda v: f"a slip angle of {np.degrees(v):+.0f} deg",
    "gamma": lambda v: f"a camber of {np.degrees(v):+.1f} deg",
    "pressure": lambda v: f"a pressure of {v / 1e5:.1f} bar",
}
LEVEL: dict[str, Callable[[float], str]] = {
    "fz": lambda v: f"{round(v, -1):.0f} N",
    "kappa": lambda v: f"{100 * v:+.0f} %",
    "alpha": lambda v: f"{np.degrees(v):+.0f} deg",
    "gamma": lambda v: f"{np.degrees(v):+.0f} deg",
    "pressure": lambda v: f"{v / 1e5:.1f} bar",
}
NAMES = {
    "fz": "loads",
    "kappa": "slips",
    "alpha": "slip angles",
    "gamma": "cambers",
    "pressure": "pressures",
}


def levels_of(points: SteadyPoints, axis: str) -> np.ndarray:
    """Distinct settings of one axis in the data, increasing."""
    values = np.sort(getattr(points, axis))
    if not len(values):
        return values
    breaks = np.flatnonzero(np.diff(values) > GRAIN[axis]) + 1
    return np.array([group.mean() for group in np.split(values, breaks)])


def describe_levels(points: SteadyPoints, axis: str) -> str:
    """What the data have of one axis, in words: "2 pressures (2.0 bar, 2.5 bar)"."""
    levels = levels_of(points, axis)
    name = NAMES[axis] if len(levels) != 1 else NAMES[axis].rstrip("s")
    shown = f" ({', '.join(LEVEL[axis](v) for v in levels)})" if len(levels) <= 5 else ""
    return f"{len(levels)} {name}{shown}"


def proposals(points: SteadyPoints, rows: Callable[[SteadyPoints], np.ndarray]) -> list[Candidate]:
    """Every new level of one axis, measured at the points that the data already have."""
    base = _representative(points)
    found = []
    for axis, reach in REACH.items():
        have, told = levels_of(points, axis), describe_levels(points, axis)
        for value in reach:
            if np.any(np.abs(have - value) < 2.0 * GRAIN[axis]):
                continue
            moved = {name: getattr(base, name) for name in GRAIN}
            moved[axis] = np.full(len(base), value)
            new = SteadyPoints(**moved, run=base.run, measured={})
            found.append(Candidate(SHOW[axis](value), told, rows(new)))
    return found


def _representative(points: SteadyPoints, most: int = 400) -> SteadyPoints:
    """One point per distinct setting (repeats add nothing to a proposal), at most `most`."""
    keys = np.column_stack([np.round(getattr(points, a) / GRAIN[a]) for a in GRAIN])
    first = np.sort(np.unique(keys, axis=0, return_index=True)[1])
    return points.rows(first[:: max(1, len(first) // most)])
