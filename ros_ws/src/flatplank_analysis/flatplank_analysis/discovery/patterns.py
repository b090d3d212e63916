# SPDX-License-Identifier: Apache-2.0
"""Bumps and waves over a place in the residual of the first channel.

The mean over all conditions hides a force that acts over half a metre under one sign of a setting,
and stretches of 5 cm hide a long and low one. So bumps of several widths and waves of many
periods, in all runs and in those of one sign of a setting, are tested like effects: whitened, with
the model's columns projected out, relative to the dispersion among repeats, and with the p-value
multiplied by the number of patterns tested.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import f as f_distribution

from flatplank_analysis.discovery.dispersion import (
    TypicalDispersion,
    among_repeats,
    scores_of,
    typical_dispersion,
)
from flatplank_analysis.discovery.gram import Gram, Metric, solve
from flatplank_analysis.discovery.runs import RunSet
from flatplank_data.wording import quantity, span

WIDTHS = (20, 10, 5)
"""length of the place coordinate in widths of a bump"""
WAVES, SHORTEST, PHASES = (4, 120), 6, 4
"""fewest and most periods over the place; least nodes per period; phases of each wave"""
SAME = 0.02
"""coordinates whose difference varies by less [unit of the coordinate] are the same, shifted"""
SEEN = 0.3
"""least share of a pattern that the model cannot imitate"""
LEVEL = 1e-3
"""required p-value of a pattern, corrected for the number of patterns tested"""
ASKED, TYPICAL = 24, 20
"""most patterns whose p-value is computed; number of patterns for the typical dispersion"""


@dataclass(frozen=True)
class Pattern:
    """A bump or a wave in the residual."""

    coordinate: str
    unit: str
    start: float
    end: float
    size: float
    """amplitude in the mean residual, unit of the channel"""
    period: float
    """period of a wave, unit of the coordinate; NaN of a bump"""
    under: str
    """the runs that have it, in words; empty: all"""
    p_value: float

    def words(self) -> str:
        if np.isfinite(self.period):
            return (
                f"a wave of {quantity(self.period, self.unit)} over {self.coordinate}{self.under}"
            )
        where = span(self.start, self.end, self.unit)
        return f"a bump over {self.coordinate} within {where}{self.under}"


@dataclass(frozen=True)
class _Place:
    name: str
    unit: str
    values: np.ndarray

    def ends(self) -> tuple[float, float]:
        return float(self.values[:, 0].max()), float(self.values[:, -1].min())


class Patterns:
    """Patterns in the residual of a fitted model, cached."""

    def __init__(
        self,
        runs: RunSet,
        metric: Metric,
        columns: np.ndarray,
        left: np.ndarray,
        residual: np.ndarray,
    ) -> None:
        """columns (k, channels, runs, samples) and left (channels, runs, samples): Jacobian and
        residual of the whitened fit; residual (runs, samples): that of the plain fit in the first
        channel.
        """
        self.runs, self.residual = runs, residual
        self._parts = metric, columns, left
        self._known: dict[tuple[float, float], Pattern | None] = {}

    def strongest(self, bump: float, wave: float) -> Pattern | None:
        """The most significant pattern larger than these sizes; None when there is none."""
        if (bump, wave) not in self._known:
            self._known[bump, wave] = self._strongest((bump, wave))
        return self._known[bump, wave]

    def ranges(self, pattern: Pattern) -> dict[str, tuple[float, float]]:
        """Its range in its own coordinate and in those that differ only by their origin."""
        coordinates = self.runs.coordinates
        own = coordinates[pattern.coordinate].values
        return {
            name: (pattern.start + shift, pattern.end + shift)
            for name, c in reversed(list(coordinates.items()))
            if c.local and np.ptp(c.values - own) < SAME
            for shift in [float(np.mean(c.values - own))]
        }

    def _strongest(self, limits: tuple[float, float]) -> Pattern | None:
        mean = self.runs.mean(self.residual)
        tried = [t for place in _places(self.runs) for t in _tested(self.runs, place, mean)]
        large = [(t, np.flatnonzero(np.abs(t.sizes) > limits[t.kind.waves])) for t in tried]
        counted = [(t, int(i)) for t, rows in large for i in rows]
        if not counted:
            return None
        own = _ModelColumns(self.runs, *self._parts)
        scored = [(own.gain(t.column(i)), t, i) for t, i in counted]
        bumps = [(t, i) for t in tried if not t.kind.waves for i in range(len(t.sizes))]
        known = own.typical([t.column(i) for t, i in bumps[:: max(len(bumps) // TYPICAL, 1)]])
        looks = sum(len(t.sizes) for t in tried)
        for gain, t, i in sorted(scored, key=lambda s: -s[0])[:ASKED]:
            p = looks * own.p_value(gain, t.column(i), known)
            if p < LEVEL:
                return t.pattern(i, p)
        return None


def _places(runs: RunSet) -> Iterator[_Place]:
    """Place coordinates; of those that differ only by their origin, one."""
    known: list[np.ndarray] = []
    for name, c in reversed(list(runs.coordinates.items())):
        if not c.local or any(np.ptp(c.values - k) < SAME for k in known):
            continue
        known.append(c.values)
        yield _Place(name, c.unit, c.values)


def _groups(runs: RunSet) -> Iterator[tuple[str, np.ndarray]]:
    """Words and masks: all runs, and the runs of one sign of each setting."""
    yield "", np.ones(runs.runs)
    for name, c in runs.coordinates.items():
        level = c.values[:, 0]
        small = 1e-3 * float(np.abs(level).max())
        if c.local or c.period or not np.allclose(c.values, level[:, None]):
            continue
        for sign, word in ((level > small, "above"), (level < -small, "below")):
            if level.min() < -small and level.max() > small:
                yield f", {name} {word} zero", sign.astype(float)


@dataclass(frozen=True)
class _Kind:
    """Bumps of one width, or waves of one period."""

    waves: bool
    numbers: np.ndarray
    """(n, 2): middle and width of a bump, crest and period of a wave"""

    def shapes(self, values: np.ndarray, numbers: np.ndarray) -> np.ndarray:
        """Shapes (n, runs, samples) for numbers (n, 2) over a place (runs, samples)."""
        at, width = numbers[:, 0, None, None], numbers[:, 1, None, None]
        u = (values - at) / width
        if self.waves:
            return np.cos(2.0 * np.pi * u)
        return np.where(np.abs(u) < 0.5, np.cos(np.pi * u) ** 2, 0.0)


def _bumps(place: _Place) -> Iterator[_Kind]:
    low, high = place.ends()
    for count in WIDTHS:
        width = (high - low) / count
        middles = np.arange(low + 0.5 * width, high, 0.5 * width)
        yield _Kind(False, np.stack([middles, np.full(len(middles), width)], axis=1))


def _waves(place: _Place) -> Iterator[_Kind]:
    low, high = place.ends()
    nodes = float(np.median(np.abs(np.diff(place.values, axis=1))))
    most = min(WAVES[1], (high - low) / (SHORTEST * max(nodes, 1e-12)))
    for count in np.arange(WAVES[0], most, 0.5):
        period = (high - low) / count
        crests = low + 0.5 * period * np.arange(PHASES) / PHASES
        yield _Kind(True, np.stack([crests, np.full(PHASES, period)], axis=1))


@dataclass(frozen=True)
class _TestedPatterns:
    """Patterns of one kind in one group of runs."""

    place: _Place
    kind: _Kind
    group: np.ndarray
    """(runs,) mask of 0 and 1"""
    under: str
    sizes: np.ndarray
    """(n,) amplitudes in the mean residual"""

    def column(self, i: int) -> np.ndarray:
        (shape,) = self.kind.shapes(self.place.values, self.kind.numbers[i : i + 1])
        return shape * self.group[:, None]

    def pattern(self, i: int, p: float) -> Pattern:
        place, (at, width) = self.place, self.kind.numbers[i]
        low, high = place.ends()
        if not self.kind.waves:
            low, high = at - 0.5 * width, at + 0.5 * width
        period = float(width) if self.kind.waves else float("nan")
        size = float(self.sizes[i])
        return Pattern(
            place.name, place.unit, float(low), float(high), size, period, self.under, p
        )


def _tested(runs: RunSet, place: _Place, mean: np.ndarray) -> Iterator[_TestedPatterns]:
    """All patterns over a place in all groups of runs; mean (conditions, samples): residual."""
    heads = [g[0] for g in runs.groups]
    for kind in (*_bumps(place), *_waves(place)):
        own = kind.shapes(place.values[heads], kind.numbers)
        for under, group in _groups(runs):
            weight = group[heads]
            score = np.einsum("ncs,cs,c->n", own, mean, weight)
            size = np.einsum("ncs,ncs,c->n", own, own, weight)
            yield _TestedPatterns(place, kind, group, under, score / np.maximum(size, 1e-30))


class _ModelColumns:
    """The model's own columns, which are projected out of every pattern."""

    def __init__(
        self, runs: RunSet, metric: Metric, columns: np.ndarray, left: np.ndarray
    ) -> None:
        self.runs, self.metric = runs, metric
        self.base = np.moveaxis(metric(columns), 0, 1)
        self.left = metric(left[None])[0]

    def gram(self, column: np.ndarray) -> Gram:
        """Sums of the model's own columns and of one (runs, samples) in the first channel."""
        full = np.zeros((1, *self.runs.measured.shape))
        full[0, 0] = column
        rows = np.concatenate([self.base, np.moveaxis(self.metric(full), 0, 1)], axis=1)
        return Gram.of(rows, self.left)

    def gain(self, column: np.ndarray) -> float:
        """Drop of the whitened chi2 by a pattern; zero where the model imitates it."""
        products, scores, _ = self.gram(column).total()
        step, inverse = solve(products[:-1, :-1], scores[:-1])
        info = float(products[-1, -1] - products[-1, :-1] @ inverse @ products[:-1, -1])
        score = float(scores[-1] - products[-1, :-1] @ step)
        return score**2 / info if info > SEEN * products[-1, -1] else 0.0

    def dispersion(self, column: np.ndarray) -> tuple[float, float]:
        """Dispersion of the scores of a pattern among repeats, and its degrees of freedom."""
        gram = self.gram(column)
        return among_repeats(self.runs.groups, *scores_of(gram, self.base.shape[1]))

    def typical(self, columns: Sequence[np.ndarray]) -> TypicalDispersion:
        pairs = [self.dispersion(c) for c in columns]
        return typical_dispersion([k for k, _ in pairs], [f for _, f in pairs])

    def p_value(self, gain: float, column: np.ndarray, known: TypicalDispersion) -> float:
        """p-value of one pattern, not corrected for the number of patterns tested."""
        kappa, freedom = known.shrink(*self.dispersion(column))
        return float(f_distribution.sf(gain / kappa, 1, freedom))
