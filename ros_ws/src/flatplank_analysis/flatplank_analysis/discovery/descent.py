# SPDX-License-Identifier: Apache-2.0
"""Bounded least squares in curved valleys: Levenberg-Marquardt with geodesic acceleration.

Where parameters are strongly correlated, the sum of squares has a long, narrow, curved valley. A
straight step leaves the valley at once, and a step damped enough to stay inside advances by
hundredths of the distance. The second derivative along a step gives the curvature of the valley
(M. K. Transtrum, J. P. Sethna, arXiv:1201.5885). It costs one prediction, a Jacobian one per
parameter. So several dampings are tried at once, straight and corrected, in two calls.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

SPREAD = (0.1, 1.0, 10.0)
"""dampings that are tried, relative to the last successful one"""
LEAST, FIRST, MOST = 1e-7, 1e-3, 10.0
"""damping (relative to the diagonal of the Hessian): smallest, first, and largest value"""
PROBE = 0.05
"""fraction of a step at which its second derivative is measured"""
KEPT = 0.75
"""least fraction of the predicted decrease at which the undamped step is accepted at once"""
SHARPEST = 3.0
"""largest second-order correction of a step, relative to its length"""
FAR = 0.3
"""relative decrease of the sum of squares above which the end is still far away, so that
Broyden's update replaces a new Jacobian"""


@dataclass(frozen=True)
class Problem:
    """What is minimised: the sum of squares of a residual in some metric plus the weighted squared
    distance of the parameters from their priors. A point is a parameter vector."""

    measured: np.ndarray
    """(channels, runs, samples)"""
    predict: Callable[[list[np.ndarray]], np.ndarray]
    """points -> predictions (points, channels, runs, samples), all in one call"""
    jacobian: Callable[[np.ndarray, np.ndarray], np.ndarray]
    """point and its prediction -> derivatives (parameters, channels, runs, samples)"""
    metric: Callable[[np.ndarray], np.ndarray]
    """linear: (n, channels, runs, samples) -> n rows whose squares are summed"""
    enough: Callable[[float], float]
    """sum of squares -> decrease below which the descent ends"""
    lower: np.ndarray
    upper: np.ndarray
    centre: np.ndarray
    strength: np.ndarray
    """weight of the squared distance from the centre"""

    def measure(self, values: np.ndarray) -> np.ndarray:
        """Values in the metric, shape (n, m)."""
        return self.metric(values).reshape(len(values), -1)

    def points(self, places: Sequence[np.ndarray], near: Sequence[np.ndarray] = ()) -> list[Point]:
        """Predictions at `places` and `near` in one call; the energy only at `places` (NaN at
        the others)."""
        inside = [np.clip(z, self.lower, self.upper) for z in [*places, *near]]
        if not inside:
            return []
        predicted = self.predict(inside)
        count = len(places)
        e = self.measure(self.measured - predicted[:count])
        prior = (np.array(inside[:count]) - self.centre) ** 2 @ self.strength
        energy = [*(np.einsum("ij,ij->i", e, e) + prior), *(np.nan for _ in near)]
        return [Point(*row) for row in zip(inside, predicted, energy, strict=True)]


class Point(NamedTuple):
    """A parameter vector, its prediction, and its energy (the minimised sum)."""

    z: np.ndarray
    predicted: np.ndarray
    energy: float


@dataclass(frozen=True)
class Descent:
    """Result of a descent."""

    point: Point
    columns: np.ndarray
    """the last Jacobian"""
    fresh: bool
    """True when the Jacobian was computed at this very point"""
    steps: int


def descend(
    problem: Problem,
    z: np.ndarray,
    columns: np.ndarray | None = None,
    steps: int = 25,
    jacobians: int = 25,
) -> Descent:
    """Minimise from a point; every step lowers the energy, or the descent ends.

    Args:
        problem: what is minimised.
        z: start.
        columns: a Jacobian that is valid there; otherwise it is computed.
        steps: largest number of steps.
        jacobians: largest number of Jacobians, not counting the first one.
    """
    at = problem.points([z])[0]
    fresh, damping, count = columns is None, FIRST, 0
    if columns is None:
        columns = problem.jacobian(at.z, at.predicted)
    here = True  # the Jacobian was computed at this point, or given for it
    fan = None
    while count < steps:
        count += 1
        fan = fan or _DampedSteps(problem, at, columns)
        enough = problem.enough(at.energy)
        if fan.promised > enough:
            end, damping = fan.best(damping)
            gain = at.energy - end.energy
            if gain > 0.0:
                as_said = here and abs(fan.promised - gain) < enough
                columns = _broyden(columns, end.z - at.z, end.predicted - at.predicted)
                at, fan, fresh, here = end, None, False, False
                if as_said and _inside(problem, at.z):
                    break
                if gain > FAR * at.energy:
                    continue
            elif fresh and damping < MOST:
                continue
            elif fresh:
                break
        elif here:
            break
        if jacobians <= 0:
            break
        jacobians -= 1
        columns, fan, fresh, here = problem.jacobian(at.z, at.predicted), None, True, True
    return Descent(at, columns, fresh, count)


class _DampedSteps:
    """Steps from one point with different dampings, straight and corrected."""

    def __init__(self, problem: Problem, at: Point, columns: np.ndarray) -> None:
        self.problem, self.at, self.columns = problem, at, columns
        self.white = problem.measure(columns)
        e = problem.measure((problem.measured - at.predicted)[None])[0]
        self.hessian = self.white @ self.white.T + np.diag(problem.strength)
        self.slope = self.white @ e - problem.strength * (at.z - problem.centre)
        self.full = self.step(self.slope, at.z, LEAST)
        self.promised = float(2.0 * self.full @ self.slope - self.full @ self.hessian @ self.full)

    def step(self, slope: np.ndarray, z: np.ndarray, damping: float) -> np.ndarray:
        low, high = self.problem.lower - z, self.problem.upper - z
        return bounded_step(self.hessian, slope, low, high, damping)

    def best(self, damping: float) -> tuple[Point, float]:
        """The lowest point and its damping; when none is lower, the start point and the next
        damping to try."""
        undamped = self.problem.points([self.at.z + self.full])[0]
        if self.at.energy - undamped.energy > KEPT * self.promised:
            return undamped, max(SPREAD[0] * damping, LEAST)
        dampings = [float(np.clip(damping * s, LEAST, MOST)) for s in SPREAD]
        moves = [self.step(self.slope, self.at.z, d) for d in dampings]
        near = [self.at.z + PROBE * m for m in moves]
        points = self.problem.points([self.at.z + m for m in moves], near)
        straight, probed = points[: len(moves)], points[len(moves) :]
        tried = [(undamped, LEAST), *zip(straight, dampings, strict=True)]
        tried += self.second_order(moves, dampings, probed)
        lower = [t for t in tried if t[0].energy < self.at.energy]
        again = self.at, min(damping / SPREAD[0], MOST)
        return min(lower, key=lambda t: t[0].energy, default=again)

    def second_order(
        self, moves: list[np.ndarray], dampings: list[float], probed: list[Point]
    ) -> list[tuple[Point, float]]:
        """The same steps with half of their second derivative as correction."""
        rates = np.tensordot(np.array(moves), self.columns, axes=1)
        predicted = np.array([p.predicted for p in probed])
        bends = (2.0 / PROBE) * ((predicted - self.at.predicted) / PROBE - rates)
        pulls = -0.5 * self.problem.measure(bends) @ self.white.T
        scale = np.sqrt(np.diag(self.hessian))
        ends, used = [], []
        for move, damping, pull in zip(moves, dampings, pulls, strict=True):
            if not np.isfinite(pull).all():
                continue
            end = np.clip(self.at.z + move, self.problem.lower, self.problem.upper)
            turn = self.step(pull, end, damping)
            size, length = np.linalg.norm(scale * turn), np.linalg.norm(scale * move)
            if size < SHARPEST * length:
                ends.append(end + turn * min(1.0, length / max(size, 1e-30)))
                used.append(damping)
        return [*zip(self.problem.points(ends), used, strict=True)]


def _inside(problem: Problem, z: np.ndarray) -> bool:
    """True when no parameter is at an end of its range, where a step may have been cut."""
    return bool(np.all((z > problem.lower) & (z < problem.upper)))


def _broyden(columns: np.ndarray, move: np.ndarray, change: np.ndarray) -> np.ndarray:
    """Broyden's update of a Jacobian, which then reproduces the last step."""
    length = float(move @ move)
    if length < 1e-12:
        return columns
    miss = change - np.tensordot(move, columns, axes=1)
    return columns + (move / length)[:, None, None, None] * miss


def bounded_step(
    hessian: np.ndarray, slope: np.ndarray, lower: np.ndarray, upper: np.ndarray, damping: float
) -> np.ndarray:
    """Minimise x'Hx/2 - g'x within a box that holds zero; damped by a share of the diagonal.

    Variables that leave the box are held at its boundary; held variables whose gradient points
    inwards are released one at a time.
    """
    size = len(slope)
    scale = np.sqrt(np.maximum(np.diag(hessian), 1e-30))
    work = hessian / np.outer(scale, scale) + (damping + 1e-9) * np.eye(size)
    goal, low, high = slope / scale, lower * scale, upper * scale
    x = np.zeros(size)
    held = np.zeros(size, dtype=bool)
    for _ in range(3 * size):
        free = ~held
        right = goal[free] - work[np.ix_(free, held)] @ x[held]
        x[free] = np.linalg.solve(work[np.ix_(free, free)], right)
        out = free & ((x < low) | (x > high))
        if out.any():
            x[out] = np.clip(x[out], low[out], high[out])
            held |= out
            continue
        pull = np.where(held, goal - work @ x, 0.0)
        inwards = np.where(x <= low, pull, -pull)
        inwards[~held] = 0.0
        if inwards.max(initial=0.0) <= 1e-12 * np.abs(goal).max():
            break
        held[np.argmax(inwards)] = False
    return np.clip(x, low, high) / scale
