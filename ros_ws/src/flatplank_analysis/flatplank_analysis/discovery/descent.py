# SPDX-License-Identifier: Apache-2.0
"""Bounded least squares in bent valleys: Levenberg-Marquardt with geodesic acceleration.

Where the numbers of a model can stand in for each other, the sum of squares lies in a long, narrow
valley that bends. A straight step leaves it at once, and damped until it stays inside it moves by
hundredths of what is needed. The second derivative along a step tells how the valley bends (M. K.
Transtrum, J. P. Sethna, arXiv:1201.5885); it costs one prediction, a Jacobian costs one for every
number. So several dampings are tried at once, straight and bent, as lanes of two calls.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

SPREAD = (0.1, 1.0, 10.0)
"""dampings that are tried, relative to the last one that was good"""
LEAST, FIRST, MOST = 1e-7, 1e-3, 10.0
"""damping: next to none; where the fan of dampings begins; beyond it there is no way down"""
PROBE = 0.05
"""share of a step at which its bend is measured"""
KEPT = 0.75
"""share of the promised gain with which the undamped step is good"""
SHARPEST = 3.0
"""bend of a step, relative to its length, beyond which it is not to be trusted"""
FAR = 0.3
"""share of the sum of squares: a step that gains more is far from the end, and Broyden's update is
good enough for the next one"""


@dataclass(frozen=True)
class Problem:
    """What is minimised: the sum of squares of a residual in some metric, and of the distance of
    the numbers from what is known of them beforehand. A point is a vector of numbers."""

    measured: np.ndarray
    """(channels, runs, samples)"""
    predict: Callable[[list[np.ndarray]], np.ndarray]
    """points -> predictions (points, channels, runs, samples), all in one call"""
    jacobian: Callable[[np.ndarray, np.ndarray], np.ndarray]
    """point and its prediction -> derivatives (numbers, channels, runs, samples)"""
    metric: Callable[[np.ndarray], np.ndarray]
    """(n, channels, runs, samples) -> anything of n rows whose squares are summed; linear"""
    enough: Callable[[float], float]
    """sum of squares -> gain that is not worth another step"""
    lower: np.ndarray
    upper: np.ndarray
    centre: np.ndarray
    strength: np.ndarray
    """weight of the squared distance from the centre"""

    def measure(self, values: np.ndarray) -> np.ndarray:
        """In the metric, (n, m)."""
        return self.metric(values).reshape(len(values), -1)

    def points(self, places: Sequence[np.ndarray], near: Sequence[np.ndarray] = ()) -> list[Point]:
        """What is predicted at some places, in one call; at those that are only `near` the energy
        is not asked for."""
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
    """Numbers, what they predict, and the energy."""

    z: np.ndarray
    predicted: np.ndarray
    energy: float


@dataclass(frozen=True)
class Descent:
    """Where it ended."""

    point: Point
    columns: np.ndarray
    """the last Jacobian"""
    fresh: bool
    """True when that was made at this very point"""
    steps: int


def descend(
    problem: Problem,
    z: np.ndarray,
    columns: np.ndarray | None = None,
    steps: int = 25,
    jacobians: int = 25,
) -> Descent:
    """Go down from a point; every step lowers the energy or is the last.

    Args:
        problem: what is minimised.
        z: where it begins.
        columns: a Jacobian that is good there; else one is made.
        steps: at most.
        jacobians: that may be made on the way, the first one not counted.
    """
    at = problem.points([z])[0]
    fresh, damping, count = columns is None, FIRST, 0
    if columns is None:
        columns = problem.jacobian(at.z, at.predicted)
    here = True  # the Jacobian is good at this point, or is said to be
    fan = None
    while count < steps:
        count += 1
        fan = fan or _Fan(problem, at, columns)
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


class _Fan:
    """Steps from a point that differ in their damping, straight and bent."""

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
        """The lowest end and the damping that led there; when none is lower, the point itself and
        the damping with which to try again."""
        undamped = self.problem.points([self.at.z + self.full])[0]
        if self.at.energy - undamped.energy > KEPT * self.promised:
            return undamped, max(SPREAD[0] * damping, LEAST)
        dampings = [float(np.clip(damping * s, LEAST, MOST)) for s in SPREAD]
        moves = [self.step(self.slope, self.at.z, d) for d in dampings]
        near = [self.at.z + PROBE * m for m in moves]
        points = self.problem.points([self.at.z + m for m in moves], near)
        straight, probed = points[: len(moves)], points[len(moves) :]
        tried = [(undamped, LEAST), *zip(straight, dampings, strict=True)]
        tried += self.bent(moves, dampings, probed)
        lower = [t for t in tried if t[0].energy < self.at.energy]
        again = self.at, min(damping / SPREAD[0], MOST)
        return min(lower, key=lambda t: t[0].energy, default=again)

    def bent(
        self, moves: list[np.ndarray], dampings: list[float], probed: list[Point]
    ) -> list[tuple[Point, float]]:
        """The same steps with half of their second derivative taken out."""
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
    """True when no number stands at an end of its range, where a step may have been cut."""
    return bool(np.all((z > problem.lower) & (z < problem.upper)))


def _broyden(columns: np.ndarray, move: np.ndarray, change: np.ndarray) -> np.ndarray:
    """Correct a Jacobian so that it explains the last step."""
    length = float(move @ move)
    if length < 1e-12:
        return columns
    miss = change - np.tensordot(move, columns, axes=1)
    return columns + (move / length)[:, None, None, None] * miss


def bounded_step(hessian, slope, lower, upper, damping: float) -> np.ndarray:
    """Minimise x'Hx/2 - g'x within a box that holds zero; damped by a share of the diagonal.

    What leaves the box is held at its wall, and what then pulls away from a wall is let go, one
    after the other.
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
