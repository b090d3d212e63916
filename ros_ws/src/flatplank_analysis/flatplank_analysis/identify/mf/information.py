# SPDX-License-Identifier: Apache-2.0
"""Which coefficients the data determine, which they cannot separate, and which run would help.

The Jacobian is scaled twice: rows by the scatter of a measurement, columns by the relevant change
of a parameter. A direction whose error is then larger than UNDETERMINED is not determined.
Proposed runs give one axis at a time a new level that the bench can set.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from ..results import Confusion
from .points import SteadyPoints

UNDETERMINED = 0.5
"""Error of a direction, in relevant sizes, above which it is not determined."""
LOADING = 0.25
"""Share of a direction's largest entry above which a parameter belongs to it."""
STRONG = 0.98
"""Correlation above which two parameters are named as hard to separate."""
HELPS = 3.0
"""Least factor by which a proposed run must reduce the error of the direction."""


@dataclass(frozen=True)
class Candidate:
    """Possible runs: a line of text, the levels in the data, scaled rows (m, p)."""

    text: str
    have: str
    rows: np.ndarray


Candidates = Callable[[], Sequence[Candidate]]


def undetermined(jacobian: np.ndarray, sizes: np.ndarray) -> list[np.ndarray]:
    """Directions (p,) in scaled parameters that the rows (n, p) do not determine, worst first."""
    scaled = jacobian * sizes
    if not len(scaled):
        return list(np.eye(len(sizes)))
    p = scaled.shape[1]
    _, values, vectors = np.linalg.svd(np.vstack([scaled, np.zeros((p, p))]), full_matrices=False)
    open_ones = [v for s, v in zip(values, vectors, strict=True) if s * UNDETERMINED < 1.0]
    return open_ones[::-1]


def members(direction: np.ndarray) -> np.ndarray:
    """Indices of the parameters that belong to a direction."""
    size = np.abs(direction)
    return np.flatnonzero(size >= LOADING * size.max())


def confusions(
    names: Sequence[str],
    jacobian: np.ndarray,
    sizes: np.ndarray,
    correlation: np.ndarray,
    candidates: Candidates,
    errors: np.ndarray | None = None,
) -> tuple[list[Confusion], np.ndarray]:
    """Statements for every undetermined direction and every strongly correlated pair.

    `errors` (p,): standard errors; a parameter with a small part in an undetermined direction may
    still have an irrelevantly large error. Returns a mask (p,) of undetermined parameters, too.
    """
    found: list[Confusion] = []
    open_mask = np.zeros(len(names), bool)
    offers = cache(candidates)

    def stated(index: np.ndarray, correlation: float, direction: np.ndarray) -> Confusion:
        return _statement(names, index, correlation, direction, sizes, offers(), jacobian)

    for direction in _sparse(undetermined(jacobian, sizes)):
        index = members(direction)
        open_mask[index] = True
        found.append(stated(index, 1.0, direction))
    wide = np.zeros(len(names), bool) if errors is None else (errors > sizes) & ~open_mask
    for i in np.flatnonzero(wide):
        open_mask[i] = True
        found.append(stated(np.array([i]), 1.0, np.eye(len(names))[i]))
    found = _merged(found)
    for i, j in _pairs(correlation, open_mask):
        index = np.array([i, j])
        weak = _weakest(jacobian, sizes, index)
        found.append(stated(index, float(correlation[i, j]), weak))
    return found, open_mask


def _sparse(directions: list[np.ndarray]) -> list[np.ndarray]:
    """Directions with few parameters that span the same space (pivoted row echelon form)."""
    if len(directions) < 2:
        return directions
    rows = np.array(directions)
    for k in range(len(rows)):
        left = np.abs(rows[k:])
        left[:, [int(np.argmax(np.abs(rows[i]))) for i in range(k)]] = 0.0
        r, c = np.unravel_index(int(np.argmax(left)), left.shape)
        rows[[k, k + r]] = rows[[k + r, k]]
        rows[k] /= rows[k, c]
        for other in range(len(rows)):
            if other != k:
                rows[other] -= rows[other, c] * rows[k]
    return [row / np.linalg.norm(row) for row in rows]


def _weakest(jacobian: np.ndarray, sizes: np.ndarray, index: np.ndarray) -> np.ndarray:
    """Direction of least information within a few parameters, as (p,)."""
    scaled = jacobian[:, index] * sizes[index]
    vector = np.linalg.eigh(scaled.T @ scaled)[1][:, 0]
    direction = np.zeros(len(sizes))
    direction[index] = vector
    return direction


def _pairs(correlation: np.ndarray, open_mask: np.ndarray) -> list[tuple[int, int]]:
    pairs = np.argwhere(np.triu(np.abs(correlation), 1) > STRONG)
    return [(int(i), int(j)) for i, j in pairs if not (open_mask[i] or open_mask[j])]


def _merged(found: list[Confusion]) -> list[Confusion]:
    """Single parameters with the same missing data, in one statement."""
    groups: dict[str, list[Confusion]] = {}
    for one in found:
        lack = one.statement.partition(" by ")[2] if len(one.names) == 1 else one.statement
        groups.setdefault(lack, []).append(one)
    out = []
    for lack, same in groups.items():
        if len(same) == 1:
            out.append(same[0])
            continue
        names = tuple(n for one in same for n in one.names)
        text = f"{listed(names)} are not determined by {lack}"
        remedy = max((one.remedy for one in same), key=[one.remedy for one in same].count)
        out.append(Confusion(names, 1.0, text, remedy))
    return out


def _statement(
    names: Sequence[str],
    index: np.ndarray,
    correlation: float,
    direction: np.ndarray,
    sizes: np.ndarray,
    offers: Sequence[Candidate],
    jacobian: np.ndarray,
) -> Confusion:
    chosen = tuple(names[i] for i in index)
    best = _best_run(direction, sizes, offers, jacobian)
    have = best.have if best else "these data"
    if len(chosen) == 1:
        text = f"{chosen[0]} is not determined by {have}"
    elif correlation == 1.0:
        text = f"{listed(chosen)} cannot be told apart with {have}"
    else:
        text = f"{listed(chosen)} are hard to tell apart with {have}"
    remedy = f"measure {best.text}" if best else "no single setting would; fix one in the fit file"
    return Confusion(chosen, correlation, text, remedy)


def _best_run(
    direction: np.ndarray, sizes: np.ndarray, offers: Sequence[Candidate], jacobian: np.ndarray
) -> Candidate | None:
    """The proposal that improves the direction most; None when none improves it enough."""
    now = float(np.sum((jacobian @ (direction * sizes)) ** 2))
    gains = [float(np.sum((c.rows @ (direction * sizes)) ** 2)) for c in offers]
    if not gains or max(gains) < (HELPS**2 - 1.0) * now or max(gains) < 0.5:
        return None
    return offers[int(np.argmax(gains))]


def listed(names: Sequence[str]) -> str:
    return ", ".join(names[:-1]) + f" and {names[-1]}" if len(names) > 1 else names[0]


GRAIN = {
    "fz": 0.05,
    "kappa": 0.005,
    "alpha": np.radians(0.5),
    "gamma": np.radians(0.5),
    "pressure": 0.02,
}
"""Values closer than this are one level: slip [-] and angles [rad], load and pressure as a share
of the largest."""
SHARES = ("fz", "pressure")
Reach = Mapping[str, Sequence[float]]
"""axis -> settings that a bench can make [SI]"""
REACH: Reach = {
    "fz": (1000.0, 2000.0, 3000.0, 4000.0, 5000.0, 6000.0, 7000.0, 8000.0),
    "kappa": (-0.15, -0.1, -0.05, -0.02, -0.01, 0.0, 0.01, 0.02, 0.05, 0.1, 0.15),
    "alpha": tuple(np.radians((-10.0, -5.0, -2.0, -1.0, 0.0, 1.0, 2.0, 5.0, 10.0, 15.0))),
    "gamma": tuple(np.radians((-5.0, -2.5, 0.0, 2.5, 5.0))),
    "pressure": (150e3, 180e3, 200e3, 220e3, 250e3, 280e3, 300e3, 330e3),
}
"""Settings that the flat plank bench can make."""
SHOW: dict[str, Callable[[float], str]] = {
    "fz": lambda v: f"a load of {v:.0f} N",
    "kappa": lambda v: f"a slip of {100 * v:+.0f} %",
    "alpha": lambda v: f"a slip angle of {np.degrees(v):+.0f} deg",
    "gamma": lambda v: f"a camber of {np.degrees(v):+.1f} deg",
    "pressure": lambda v: f"a pressure of {v / 1e5:.1f} bar",
}
LEVEL: dict[str, tuple[str, Callable[[float], str]]] = {
    "fz": ("load", lambda v: f"{round(v, -1):.0f} N"),
    "kappa": ("slip", lambda v: f"{100 * v:+.0f} %"),
    "alpha": ("slip angle", lambda v: f"{np.degrees(v):+.0f} deg"),
    "gamma": ("camber", lambda v: f"{np.degrees(v):+.0f} deg"),
    "pressure": ("pressure", lambda v: f"{v / 1e5:.1f} bar"),
}
"""Name of a level, and its value in words."""


SWEPT = 3.0
"""span of values without a gap, in grains, above which they were swept"""


def levels_of(points: SteadyPoints, axis: str) -> np.ndarray:
    """Distinct settings of one axis in the data, increasing; where the axis was swept without a
    gap, one for each grain."""
    values, least = np.sort(getattr(points, axis)), grain(points, axis)
    if not len(values):
        return values
    groups = np.split(values, np.flatnonzero(np.diff(values) > least) + 1)
    parts = [g for group in groups for g in np.array_split(group, _swept_levels(group, least))]
    return np.array([part.mean() for part in parts])


def _swept_levels(group: np.ndarray, least: float) -> int:
    """Number of levels in values without a gap: the scatter of a setting is one level."""
    span = float(np.ptp(group))
    return min(int(span / least), len(group)) if span > SWEPT * least else 1


def grain(points: SteadyPoints, axis: str) -> float:
    """Distance below which two values of an axis are one level [SI]."""
    values = getattr(points, axis)
    return GRAIN[axis] * (float(np.abs(values).max(initial=0.0)) if axis in SHARES else 1.0)


def reach_of(points: SteadyPoints) -> Reach:
    """Settings for the next sweeps on a bench of another kind: loads and pressures in quarters of
    the largest measured ones, up to half more."""
    most = {axis: float(np.max(getattr(points, axis), initial=0.0)) for axis in SHARES}
    quarters = {
        axis: tuple(float(f"{0.25 * k * top:.2g}") for k in range(1, 7))
        for axis, top in most.items()
    }
    return {**REACH, **quarters}


def describe_levels(points: SteadyPoints, axis: str) -> str:
    """The levels of one axis in words: "2 pressures (2.0 bar, 2.5 bar)"."""
    levels = levels_of(points, axis)
    name, in_words = LEVEL[axis]
    shown = f" ({', '.join(in_words(v) for v in levels)})" if len(levels) <= 5 else ""
    return f"{len(levels)} {name}{'s' * (len(levels) != 1)}{shown}"


def proposals(
    points: SteadyPoints, rows: Callable[[SteadyPoints], np.ndarray], settings: Reach = REACH
) -> list[Candidate]:
    """Possible runs: every new level of one axis, combined with the other levels of the data.

    `rows` gives the scaled Jacobian (m, p) of points that were not measured.
    """
    base = _representative(points)
    found = []
    for axis, reach in settings.items():
        have, described = levels_of(points, axis), describe_levels(points, axis)
        for value in reach:
            if np.any(np.abs(have - value) < 2.0 * grain(points, axis)):
                continue
            moved = {name: getattr(base, name) for name in GRAIN}
            moved[axis] = np.full(len(base), value)
            new = SteadyPoints(**moved, run=base.run, measured={})
            found.append(Candidate(SHOW[axis](value), described, rows(new)))
    return found


def _representative(points: SteadyPoints, most: int = 400) -> SteadyPoints:
    """One point per distinct setting (repeats add nothing to a proposal), at most `most`."""
    keys = np.column_stack([np.round(getattr(points, a) / grain(points, a)) for a in GRAIN])
    first = np.sort(np.unique(keys, axis=0, return_index=True)[1])
    return points.rows(first[:: max(1, len(first) // most)])
