# SPDX-License-Identifier: Apache-2.0
"""The step of the nonlinear model as machine code, where numba is installed.

Same equations and same numbers as the array code in `nonlinear.py`, about thirty times faster for
a tabulated law; a test holds the two together. Without numba nothing else changes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from .contact import LOWEST_SHARE

try:
    from numba import njit
except ImportError:
    njit = None

NEWTON = 3
HOLDS = 0.5
"""Share of the patch's relaxation length that a falling law may take: where it takes more, the
spring cannot hold the contact point, and the slip goes on without it"""
CLOSE = 1e-9
"""Change of the slip after which another Newton step would change nothing [-]"""


def march(
    slip: np.ndarray,
    u: np.ndarray,
    compliance: np.ndarray,
    travel: np.ndarray,
    moved: np.ndarray,
    half: np.ndarray,
    follow: np.ndarray,
    theta: np.ndarray,
    first: float,
    step: float,
    table: np.ndarray,
    longitudinal: bool,
) -> np.ndarray:
    """Force (lanes, runs, samples); see `nonlinear._Stepper.march` for the equations.

    `slip`, `u`, `compliance` (lanes, runs); `travel`, `moved`, `half`, `follow` (runs, samples);
    `theta` (1 or lanes, 1 or runs, 1 or samples); `table` (1 or lanes, 1 or runs, nodes).
    """
    lanes, runs = slip.shape
    samples, last = travel.shape[1], table.shape[2] - 2
    out = np.empty((lanes, runs, samples))
    for lane in range(lanes):
        for run in range(runs):
            forces = table[min(lane, table.shape[0] - 1), min(run, table.shape[1] - 1)]
            limits = theta[min(lane, theta.shape[0] - 1), min(run, theta.shape[1] - 1)]
            k, d = slip[lane, run], u[lane, run]
            place = (k - first) / step
            cell = int(min(max(place, 0.0), last))
            slope = (forces[cell + 1] - forces[cell]) / step
            force = forces[cell] + (place - cell) * (forces[cell + 1] - forces[cell])
            for i in range(samples):
                way, a, share = travel[run, i], half[run, i], follow[run, i]
                limit = limits[min(i, limits.shape[0] - 1)]
                soft = compliance[lane, run] * share
                before = k
                base = max(1.0 + k, 0.1) if longitudinal else 1.0
                sigma = max(1.0 - limit * abs(k) / base, LOWEST_SHARE) * a / base
                ratio = max(way / (sigma + soft * max(slope, 0.0)), 1e-4)
                late = (-1.0 / np.expm1(-ratio) - 1.0 / ratio) * way
                goal = moved[run, i] - (way - late) * k
                for _ in range(NEWTON):
                    middle = 0.5 * (k + before)
                    base = max(1.0 + middle, 0.1) if longitudinal else 1.0
                    sigma = max(1.0 - limit * abs(middle) / base, LOWEST_SHARE) * a / base
                    shrink = 0.0
                    if sigma * base > LOWEST_SHARE * a:
                        shrink = 0.5 * limit * a * abs(k - before)
                    drawn = soft * force - share * d if soft * slope > -HOLDS * sigma else 0.0
                    error = goal - sigma * (k - before) - late * k - drawn
                    rate = sigma - min(shrink, 0.5 * sigma) + late + soft * max(slope, 0.0)
                    change = error / rate
                    k += change
                    place = (k - first) / step
                    cell = int(min(max(place, 0.0), last))
                    slope = (forces[cell + 1] - forces[cell]) / step
                    force = forces[cell] + (place - cell) * (forces[cell + 1] - forces[cell])
                    if abs(change) < CLOSE:
                        break
                out[lane, run, i] = force
                d += share * (force * compliance[lane, run] - d)
    return out


compiled: Callable[..., Any] | None = None if njit is None else njit(cache=True)(march)
"""The same function as machine code, or None without numba."""
