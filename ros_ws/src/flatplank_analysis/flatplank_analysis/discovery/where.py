# SPDX-License-Identifier: Apache-2.0
"""Where the residual is: energy over coordinates, local events, periods."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flatplank_analysis.discovery.runs import Coordinate, RunSet
from flatplank_data.wording import quantity, span

SURE = 3.8
"""standard errors of its condition's mean that a stretch must exceed: a p-value of 0.001 with
twenty degrees of freedom"""
REMAINS = 0.5
"""share of a stretch that must remain without any one repeat of its condition"""


DRAWS = 60
"""random arrangements of the runs for the p-value of a map"""
P_FROM = f"p-values are from {DRAWS} random arrangements of the runs"


def p_words(p_value: float) -> str:
    """The p-value of a map; where no arrangement was as good it is only a bound."""
    least = 1.0 / (DRAWS + 1.0)
    return f"p = {p_value:.2g}" if p_value > 1.5 * least else f"p at most {least:.2g}"


@dataclass(frozen=True)
class Map:
    """The mean residual of every condition over one coordinate, in bins."""

    coordinate: str
    unit: str
    edges: np.ndarray
    """(bins + 1,)"""
    mean: np.ndarray
    """(conditions, bins), NaN where a condition has no sample"""
    share: np.ndarray
    """(bins,) share of the systematic energy"""
    ordered: float
    """share of the energy that a function of this coordinate alone explains"""
    p_value: float
    """p-value of "the coordinate does not matter", by shifted runs with flipped signs"""
    place: tuple[float, float]
    """narrowest range that holds half of the energy"""
    place_share: float

    def words(self) -> str:
        """The place of the residual in one line."""
        if self.place_share <= 0.0:
            return "nothing beyond the floor"
        ends = (float(self.edges[0]), float(self.edges[-1]))
        share = quantity(self.place_share, "1", 2)
        place = span(*self.place, self.unit, axis=ends)
        # what has no unit is told by its name
        named = f"{self.coordinate} " if self.unit == "-" else ""
        return f"{share} of the residual within {named}{place}"


@dataclass(frozen=True)
class Event:
    """A stretch in which the mean residual exceeds the size of consequence."""

    coordinate: str
    start: float
    end: float
    level: float
    """largest root mean square of the mean residual in 5 cm of it, unit of the channel"""
    conditions: tuple[str, ...]
    """conditions that show it"""

    def meets(self, other: Event) -> bool:
        """True where two stretches of one coordinate share a place and a condition."""
        return (
            self.coordinate == other.coordinate
            and self.start < other.end
            and other.start < self.end
            and not set(self.conditions).isdisjoint(other.conditions)
        )


def make_maps(
    runs: RunSet, residual: np.ndarray, floor: float | np.ndarray, seed: int = 0
) -> list[Map]:
    """Maps over all coordinates, sorted by the share that each explains, largest first.

    floor: of all conditions, or of each one (conditions,).
    """
    mean = runs.mean(residual)
    floors = np.broadcast_to(floor, len(runs.groups))
    maps = [
        _map(runs, name, c, residual, mean, floors, seed) for name, c in runs.coordinates.items()
    ]
    return sorted(maps, key=lambda m: -m.ordered)


def with_given_ranges(maps: Sequence[Map], ranges: Mapping[str, tuple[float, float]]) -> list[Map]:
    """The maps; those with a given range have it as their place and come first."""
    first = []
    for m in (m for m in maps if m.coordinate in ranges):
        low, high = ranges[m.coordinate]
        inside = (m.edges[1:] > low) & (m.edges[:-1] < high)
        share = float(m.share[inside].sum())
        first.append(replace(m, place=(low, high), place_share=share))
    return first + [m for m in maps if m.coordinate not in ranges]


def _edges(c: Coordinate) -> np.ndarray:
    low, high = float(c.values.min()), float(c.values.max())
    if c.period:
        low, high = 0.0, c.period
    levels = np.unique(np.round(c.values[:, 0], 9))
    if len(levels) <= 60 and np.allclose(c.values, c.values[:, :1]):
        middle = 0.5 * (levels[1:] + levels[:-1])
        return np.concatenate([[levels[0] - 1e-6], middle, [levels[-1] + 1e-6]])
    return np.linspace(low, high + 1e-9, c.bins + 1)


def _map(runs, name, c: Coordinate, residual, mean, floors, seed) -> Map:
    edges = _edges(c)
    bins = len(edges) - 1
    place = np.clip(np.digitize(c.values, edges) - 1, 0, bins - 1)
    table = np.full((len(runs.groups), bins), np.nan)
    energy = np.zeros(bins)
    for i, rows in enumerate(runs.groups):
        where = place[rows].ravel()
        count = np.bincount(where, minlength=bins)
        total = np.bincount(where, residual[rows].ravel(), minlength=bins)
        table[i, count > 0] = total[count > 0] / count[count > 0]
        noise = floors[i] ** 2 / len(rows)
        if (place[rows] == place[rows[0]]).all():
            energy += np.bincount(place[rows[0]], mean[i] ** 2 - noise, minlength=bins)
        else:  # repeats are at other places at the same time: they are alike by the bin
            energy += count / len(rows) * (np.nan_to_num(table[i]) ** 2 - noise)
    energy = np.maximum(energy, 0.0)
    share = energy / max(float(energy.sum()), 1e-30)
    ordered, p = _ordered(place, residual, bins, seed)
    low, high, held = _half(edges, share)
    return Map(name, c.unit, edges, table, share, ordered, p, (low, high), held)


def _ordered(place, residual, bins, seed) -> tuple[float, float]:
    """Share explained by a function of the bins, and its p-value by randomised runs."""

    def explained(values: np.ndarray) -> float:
        count = np.maximum(np.bincount(place.ravel(), minlength=bins), 1)
        mean = np.bincount(place.ravel(), values.ravel(), minlength=bins) / count
        return float(np.sum(count * mean**2) / max(float(np.sum(values**2)), 1e-30))

    real = explained(residual)
    rng = np.random.default_rng(seed)
    hits = 0
    for _ in range(DRAWS):
        # whole runs are shifted and their signs flipped, which keeps the spectrum of the noise
        shift = rng.integers(0, residual.shape[1], len(residual))
        sign = rng.choice([-1.0, 1.0], len(residual))
        moved = np.stack([np.roll(r, s) for r, s in zip(residual, shift, strict=True)])
        hits += explained(moved * sign[:, None]) >= real
    return real, (hits + 1.0) / (DRAWS + 1.0)


def _half(edges: np.ndarray, share: np.ndarray) -> tuple[float, float, float]:
    """Narrowest range of bins with at least half of the energy."""
    total = np.concatenate([[0.0], np.cumsum(share)])
    best = (len(share), 0, len(share))
    for i in range(len(share)):
        j = int(np.searchsorted(total, total[i] + 0.5))
        if j <= len(share) and j - i < best[0]:
            best = (j - i, i, j)
    _, i, j = best
    return float(edges[i]), float(edges[j]), float(total[j] - total[i])


def events(
    runs: RunSet, residual: np.ndarray, limit: float, error: np.ndarray, width: float = 0.05
) -> list[Event]:
    """Stretches of a place coordinate where the mean residual of a condition exceeds a limit and
    `SURE` standard errors, and of which `REMAINS` is left without any one of its repeats: a
    channel may stand still in one run. The worst first.

    error (conditions, samples): expected standard error of the mean. Three repeats may be alike by
    chance, so what they show counts only where it is more.
    """
    mean = runs.mean(residual)
    variance = np.maximum(standard_errors(runs, residual)[:, None], error) ** 2
    out: list[Event] = []
    for name, c in runs.coordinates.items():
        if not c.local:
            continue
        found: dict[int, list[tuple[int, float]]] = {}
        low = float(c.values.min())
        for i, rows in enumerate(runs.groups):
            x = c.values[rows[0]]
            cell = ((x - low) / width).astype(int)
            level, sure = _rms(cell, mean[i] ** 2), SURE * _rms(cell, variance[i])
            without = mean[i] + (mean[i] - residual[rows]) / max(len(rows) - 1, 1)
            kept = np.min([_rms(cell, one**2) for one in without], axis=0)
            clear = (level > np.maximum(limit, sure)) & (kept > REMAINS * level)
            for k in np.flatnonzero(clear & (np.bincount(cell) > 2)):
                found.setdefault(int(k), []).append((i, float(level[k])))
        out += _joined(name, found, low, width, runs.condition_names)
    return sorted(out, key=lambda e: -e.level)


def _rms(cell: np.ndarray, square: np.ndarray) -> np.ndarray:
    """Root mean square in each cell, from the squares (samples,) of its nodes."""
    return np.sqrt(np.bincount(cell, square) / np.maximum(np.bincount(cell), 1))


def standard_errors(runs: RunSet, residual: np.ndarray) -> np.ndarray:
    """Standard error of the mean residual (conditions,), from the repeats of each condition,
    because the scatter of a tire grows with its force. Zero without repeats."""
    square = np.mean(runs.contrast(residual) ** 2, axis=1)
    counts = np.array([len(g) for g in runs.groups])
    within = np.array([float(np.sum(square[g])) for g in runs.groups])
    return np.sqrt(within / np.maximum(counts - 1, 1) / counts)


def _joined(name, found, low, width, labels) -> list[Event]:
    out, cells = [], sorted(found)
    while cells:
        chain = [cells.pop(0)]
        while cells and cells[0] <= chain[-1] + 1:
            chain.append(cells.pop(0))
        who = sorted({i for k in chain for i, _ in found[k]})
        level = max(v for k in chain for _, v in found[k])
        start, end = low + chain[0] * width, low + (chain[-1] + 1) * width
        out.append(Event(name, start, end, level, tuple(labels[i] for i in who)))
    return out


def period_of(
    runs: RunSet, residual: np.ndarray, coordinate: str, shortest: float
) -> tuple[float, float]:
    """Period of the largest coherent amplitude over a coordinate, and its share of the energy."""
    x = runs.coordinates[coordinate].values
    mean = runs.mean(residual)
    rows = np.array([g[0] for g in runs.groups])
    length = float(np.ptp(x[0]))
    frequencies = np.arange(2.0 / length, 1.0 / shortest, 0.3 / length)
    total = np.zeros(len(frequencies), dtype=complex)
    for xi, ei in zip(x[rows], mean, strict=True):
        w = np.gradient(xi) * np.hanning(len(xi))
        total += np.exp(-2j * np.pi * np.outer(frequencies, xi)) @ ((ei - ei.mean()) * w) / w.sum()
    amplitude = 2.0 * np.abs(total) / len(rows)
    best = int(np.argmax(amplitude))
    energy = float(np.mean(mean**2))
    return float(1.0 / frequencies[best]), float(amplitude[best] ** 2 / 2.0 / max(energy, 1e-30))


def coherence(runs: RunSet, residual: np.ndarray) -> float:
    """Share of the residual's energy that is the same in all repeats."""
    counts = np.array([len(g) for g in runs.groups])
    if not np.any(counts > 1):
        return float("nan")
    spare = max(float(np.sum(counts - 1)) * runs.samples, 1.0)
    within = float(np.sum(runs.contrast(residual) ** 2)) / spare
    total = float(np.mean(residual**2))
    return float(np.clip(1.0 - within / max(total, 1e-30), 0.0, 1.0))
