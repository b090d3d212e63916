# SPDX-License-Identifier: Apache-2.0
"""Residuals of one output of the Magic Formula over its free coefficients, for many sets."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from flatplank_tire.magic_formula import Coefficients, operating_point

from ...models.base import SPEED
from ..least_squares import Solution, solve
from .information import REACH, Reach
from .points import SteadyPoints
from .stages import COEFFICIENTS, PREDICTIONS, SCALE, Coefficient

WEAK = 10.0
"""Width of the weak prior of every coefficient, in its `size`: undetermined ones do not drift."""
PENALTY = 1e3
"""Weight of E - 1 where a curvature factor exceeds 1."""
SHAPES = {
    "fx": ({"PCX1": 1.3, "PEX1": -1.5}, {"PCX1": 1.6, "PEX1": 0.0}),
    "fy": ({"PCY1": 1.1, "PEY1": -2.0}, {"PCY1": 1.5, "PEY1": -0.5}),
    "mz": ({"QCZ1": 1.1, "QEZ1": -2.0}, {"QCZ1": 1.4, "QEZ1": -0.5}),
}
"""Further starts for the shape of a curve."""


@dataclass(frozen=True)
class Prior:
    """Prior knowledge: a value with its standard deviation."""

    value: float
    std: float


@dataclass(frozen=True)
class OutputProblem:
    """One output, its points, its free coefficients; `base` has all the others."""

    output: str
    points: SteadyPoints
    free: tuple[str, ...]
    base: Coefficients
    limits: dict[str, Coefficient] = field(default_factory=dict)
    priors: dict[str, Prior] = field(default_factory=dict)
    weight: float = 1.0
    scatter: float = 1.0
    """Scatter of the points, relative to the first guess `SCALE` [-]."""
    reach: Reach = field(default_factory=lambda: REACH)
    """Settings that the bench can make."""

    def limit(self, name: str) -> Coefficient:
        """Bounds and size of one coefficient."""
        return self.limits.get(name) or COEFFICIENTS[name]

    @property
    def sizes(self) -> np.ndarray:
        """Size of a relevant change per free coefficient (p,)."""
        return np.array([self.limit(n).size for n in self.free])

    @property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper bound per free coefficient, each (p,)."""
        limits = [self.limit(n) for n in self.free]
        return np.array([c.lower for c in limits]), np.array([c.upper for c in limits])

    def at(self, x: np.ndarray) -> Coefficients:
        """All coefficients with these values of the free ones."""
        return self.base.replaced(dict(zip(self.free, x, strict=True)))

    def start(self) -> np.ndarray:
        """Start values: those of the base within the bounds, otherwise the table's."""
        values = []
        for name in self.free:
            limit, given = self.limit(name), float(getattr(self.base, name))
            usable = np.isfinite(given) and given != 0.0
            values.append(np.clip(given if usable else limit.start, limit.lower, limit.upper))
        return np.array(values)

    def predict(self, sets: np.ndarray, points: SteadyPoints | None = None) -> np.ndarray:
        """Output (sets, n) for free coefficients (sets, p)."""
        points = self.points if points is None else points
        c = self.base.replaced({n: sets[:, i : i + 1] for i, n in enumerate(self.free)})
        o = operating_point(
            c, points.fz, points.kappa, points.alpha, points.gamma, points.pressure, SPEED
        )
        value = PREDICTIONS[self.output](c, o)
        return np.broadcast_to(value, (len(sets), len(points)))

    def error_scale(self, points: SteadyPoints | None = None) -> np.ndarray:
        """Assumed standard deviation of each point (n,)."""
        points = self.points if points is None else points
        return SCALE[self.output](points) * (self.scatter / self.weight)

    def residuals(self, sets: np.ndarray) -> np.ndarray:
        """Measurements, penalties, priors: (sets, n + penalties + p)."""
        error = (self.predict(sets) - self.points.measured[self.output]) / self.error_scale()
        rows = [error, self._penalties(sets), self._prior_rows(sets)]
        return np.hstack([np.broadcast_to(r, (len(sets), r.shape[1])) for r in rows])

    def solve(self, broadly: bool = False) -> Solution:
        """Search from the start values; `broadly`: from several shapes, and keep the best.

        The cost has several local minima over shape C and curvature E: a curve with high C and
        high E is much like one with low C and low E.
        """
        low, high = self.bounds
        starts = [self.start()]
        for changes in SHAPES.get(self.output, ()) if broadly else ():
            own = self.start()
            for name, value in changes.items():
                if name in self.free:
                    own[self.free.index(name)] = value
            starts.append(np.clip(own, low, high))
        starts = list({tuple(s): s for s in starts}.values())
        begin = starts[0]
        if len(starts) > 1:
            rough = [solve(self.residuals, s, low, high, self.sizes, 1e-3, 40) for s in starts]
            begin = min(rough, key=lambda s: s.cost).x
        return solve(self.residuals, begin, low, high, self.sizes, 1e-8, 120)

    def prior_information(self, fixed: np.ndarray) -> np.ndarray:
        """Information of the given priors on the coefficients that are not `fixed` (q, q)."""
        names = [n for n, f in zip(self.free, fixed, strict=True) if not f]
        given = [1.0 / self.priors[n].std ** 2 if n in self.priors else 0.0 for n in names]
        return np.diag(given)

    def _prior_rows(self, sets: np.ndarray) -> np.ndarray:
        middle, width = self.start(), WEAK * self.sizes
        for i, name in enumerate(self.free):
            if name in self.priors:
                middle[i], width[i] = self.priors[name].value, self.priors[name].std
        return (sets - middle) / width

    def _penalties(self, sets: np.ndarray) -> np.ndarray:
        c = self.base.replaced({n: sets[:, i : i + 1] for i, n in enumerate(self.free)})
        if self.output not in _CURVATURES or not len(self.points):
            return np.zeros((len(sets), 0))
        dfz = np.array([self.points.fz.min(), self.points.fz.max()])
        dfz = (dfz - c.LFZO * c.FNOMIN) / (c.LFZO * c.FNOMIN)
        gamma = np.array([self.points.gamma.min(), self.points.gamma.max()])
        values = _CURVATURES[self.output](c, dfz, gamma)
        flat = [np.broadcast_to(v, (len(sets), 2)) for v in values]
        return PENALTY * np.maximum(np.hstack(flat) - 1.0, 0.0)


def _curvature_x(c: Coefficients, dfz: np.ndarray, gamma: np.ndarray) -> list[np.ndarray]:
    e = (c.PEX1 + (c.PEX2 + c.PEX3 * dfz) * dfz) * c.LEX
    return [e * (1.0 - c.PEX4), e * (1.0 + c.PEX4), c.REX1 + c.REX2 * dfz]


def _curvature_y(c: Coefficients, dfz: np.ndarray, gamma: np.ndarray) -> list[np.ndarray]:
    e = (c.PEY1 + c.PEY2 * dfz) * c.LEY
    tilt, skew = 1.0 + c.PEY5 * gamma**2, c.PEY3 + c.PEY4 * gamma
    return [e * (tilt - skew), e * (tilt + skew), c.REY1 + c.REY2 * dfz]


def _curvature_trail(c: Coefficients, dfz: np.ndarray, gamma: np.ndarray) -> list[np.ndarray]:
    e = c.QEZ1 + (c.QEZ2 + c.QEZ3 * dfz) * dfz
    skew = c.QEZ4 + c.QEZ5 * gamma
    return [e * (1.0 - skew), e * (1.0 + skew)]


_CURVATURES = {"fx": _curvature_x, "fy": _curvature_y, "mz": _curvature_trail}
