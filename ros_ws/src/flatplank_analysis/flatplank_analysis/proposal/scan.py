# SPDX-License-Identifier: Apache-2.0
"""Score columns of curves and shapes at every site, projected off what is in the model already."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.gram import solve
from flatplank_analysis.discovery.model import Lane
from flatplank_analysis.discovery.state import State
from flatplank_analysis.proposal.curves import acting, basis_at, basis_of, knots_of
from flatplank_analysis.proposal.shapes import shapes
from flatplank_analysis.proposal.shapes.base import ANGLE, PLACE, Shape, Span
from flatplank_analysis.proposal.sites import Site, factor
from flatplank_analysis.tirebase.data import TireRuns

WAVE_NODES = 6
"""nodes at least per period of a wave that is looked for"""
HINTS = 4
"""periods that a spectrum suggests at a site"""
POINTS, BAND = 240, 1.645
"""of a drawn curve; standard errors of a 90 % band"""


@dataclass(frozen=True)
class Scores:
    """Sums of some columns with the model's own projected out."""

    info: np.ndarray
    """(k, k)"""
    score: np.ndarray
    """(k,)"""

    def sizes(self) -> np.ndarray:
        """Best sizes."""
        return solve(self.info, self.score)[0]

    def gain(self) -> float:
        """Drop of the whitened chi2 at the best sizes."""
        return float(self.sizes() @ self.score)

    def of(self, mix: np.ndarray) -> Scores:
        """The same of combinations (n, k) of the columns."""
        return Scores(mix @ self.info @ mix.T, mix @ self.score)


@dataclass(frozen=True)
class Scanned:
    """A site with what a free curve, or a wave of a free period, takes there."""

    site: Site
    gain: float
    count: int
    """numbers of the curve"""
    looks: int
    """columns that were looked at"""
    waves: bool = False

    def evidence(self, dispersion: float, price: float) -> float:
        """Gain in units of the scatter, less the price of its numbers and of the looking."""
        return (
            self.gain / dispersion
            - price * self.count
            - 2.0 * float(np.log(self.looks / self.count))
        )


@dataclass(frozen=True)
class Drawn:
    """A free curve over its coordinate, in the unit of the hook; all (points,)."""

    u: np.ndarray
    values: np.ndarray
    half: np.ndarray
    """half width of the band"""


@dataclass(frozen=True)
class Formed:
    """A shape at a site, at the numbers where it fits best."""

    site: Site
    shape: Shape
    numbers: dict[str, float]
    sizes: np.ndarray
    """in the unit of the hook"""
    gain: float

    def evidence(self, dispersion: float, price: float) -> float:
        """Gain in units of the scatter, less the price of its numbers."""
        return self.gain / dispersion - price * self.shape.price


class Scanner:
    """The whitened residual of a state, and what its own columns cannot make of it."""

    def __init__(self, state: State, data: TireRuns) -> None:
        self.state, self.data = state, data
        self.fit = state.whitened.fit
        own = self._flat(self.fit.jacobian[self.fit.loose()])
        norm = np.maximum(np.linalg.norm(own, axis=1), 1e-12)
        self.own = np.linalg.qr((own / norm[:, None]).T)[0].T
        self.residual = self._off(self._flat(self.fit.residual(state.runs.measured)[None]))[0]
        self._hints: dict[tuple[str, str], tuple[float, ...]] = {}

    def _flat(self, columns: np.ndarray) -> np.ndarray:
        return self.state.metric(columns).reshape(len(columns), -1)

    def _off(self, flat: np.ndarray) -> np.ndarray:
        return flat - (flat @ self.own.T) @ self.own

    def columns(self, site: Site, basis: np.ndarray) -> np.ndarray:
        """Response of the model to each basis function, per unit of the hook."""
        effect, own = acting(site, basis), self.fit.lane()
        step = site.hook.screen
        lanes = [
            Lane(own.base, (*own.effects, (effect, row))) for row in step * np.eye(len(basis))
        ]
        return (self.state.model.predict(lanes) - self.fit.predicted) / step

    def scores(self, site: Site, basis: np.ndarray) -> Scores:
        """Projected sums of a site's columns."""
        flat = self._off(self._flat(self.columns(site, basis)))
        return Scores(flat @ flat.T, flat @ self.residual)

    def drawn(self, site: Site, dispersion: float) -> Drawn:
        """The coarse curve of a site with its 90 % band, over the range of its coordinate."""
        scores = self.scores(site, basis_of(site, fine=False))
        sizes, inverse = solve(scores.info, scores.score)
        span = site.place.span
        u = np.linspace(span.low, span.high, POINTS)
        basis = basis_at(site, u)
        variance = np.einsum("kn,kl,ln->n", basis, inverse, basis)
        half = BAND * np.sqrt(np.maximum(dispersion * variance, 0.0))
        return Drawn(u, sizes @ basis, half)

    def curve(self, site: Site) -> Scanned:
        """The coarse curve of a site."""
        scores = self.scores(site, basis_of(site, fine=False))
        count = len(scores.score)
        return Scanned(site, scores.gain(), count, count)

    def wave(self, site: Site) -> Scanned | None:
        """The best wave over a place, of those that the residual's spectrum suggests."""
        if site.place.span.kind != PLACE:
            return None
        key = (site.place.name, site.modulator.name)
        if key not in self._hints:
            self._hints[key] = self._spectrum(site)
        made = self._waves(site, [{"period": p} for p in self._hints[key]], shapes()["wave"])
        looks = 2 * len(settings_of(shapes()["wave"], site.place.span))
        return Scanned(site, made.gain, 2, looks, waves=True) if made else None

    def _spectrum(self, site: Site) -> tuple[float, ...]:
        """Periods at which the first channel waves most, runs alike or turned by the slip."""
        x, residual = site.place.values, self.fit.residual(self.state.runs.measured)[0]
        even = np.linspace(float(x[:, 0].max()), float(x[:, -1].min()), 1024)
        weight = factor(site.modulator, self.data)
        rows = np.stack(
            [np.interp(even, a, e * w) for a, e, w in zip(x, residual, weight, strict=True)]
        )
        length = float(even[-1] - even[0])
        frequency = np.arange(1.5, length / _resolved(x), 0.5) / length
        window = np.hanning(len(even))
        kernel = np.exp(-2j * np.pi * np.outer(frequency, even)) * window
        out: list[float] = []
        for sign in (np.ones(len(rows)), np.sign(self.data.kappa)):
            mean = sign @ rows / len(rows)
            level = np.abs(kernel @ (mean - mean.mean()))
            around = np.convolve(np.pad(level, 8, mode="reflect"), np.ones(17) / 17.0, "valid")
            order = np.argsort(-level / np.maximum(around, 1e-12))
            out += [float(1.0 / frequency[i]) for i in order[: HINTS // 2]]
        return tuple(out)

    def forms(self, scanned: Scanned) -> Iterator[Formed]:
        """Every shape that suits a site, at its best numbers."""
        site, span = scanned.site, scanned.site.place.span
        suited = [s for s in shapes().values() if s.suits(span) and _waves(s) == scanned.waves]
        direct = [s for s in suited if s.memory or _waves(s) or span.kind in (ANGLE, "none")]
        plain = [s for s in suited if s not in direct]
        if plain:
            scores = self.scores(site, basis_of(site, fine=True))
            knots = knots_of(site.place.values, span, fine=True)
            yield from (_best(site, s, knots, scores) for s in plain)
        for shape in direct:
            if shape.name == "beat":
                made = self._pairs(site, shape)
            else:
                made = self._waves(site, settings_of(shape, span), shape)
            if made:
                yield made

    def _pairs(self, site: Site, shape: Shape) -> Formed | None:
        """Two waves: all pairs of periods, from the sums of single waves."""
        place, wave = site.place, shapes()["wave"]
        single = settings_of(wave, place.span)
        periods = [s["period"] for s in single if s["period"] > _resolved(place.values)]
        if len(periods) < 2:
            return None
        blocks = [wave.values(place.span, place.values, {"period": p}) for p in periods]
        scores = self.scores(site, np.concatenate(blocks))
        best: Formed | None = None
        for i, one in enumerate(periods):
            for j in range(i):
                rows = np.array([2 * i, 2 * i + 1, 2 * j, 2 * j + 1])
                pair = Scores(scores.info[np.ix_(rows, rows)], scores.score[rows])
                gain = pair.gain()
                if best is None or gain > best.gain:
                    numbers = {"period": one, "second": periods[j]}
                    best = Formed(site, shape, numbers, pair.sizes(), gain)
        return best

    def _waves(
        self, site: Site, settings: Sequence[dict[str, float]], shape: Shape
    ) -> Formed | None:
        """A shape that no sum of hats can make: every setting has columns of its own."""
        place, span = site.place, site.place.span
        if _waves(shape):
            settings = [s for s in settings if s["period"] > _resolved(place.values)]
        if not settings:
            return None
        time = self.state.runs.time
        basis = np.concatenate([shape.values(span, place.values, s, time) for s in settings])
        scores = self.scores(site, basis)
        k = len(shape.terms)
        parts = [
            Scores(scores.info[i : i + k, i : i + k], scores.score[i : i + k])
            for i in range(0, len(basis), k)
        ]
        best = int(np.argmax([p.gain() for p in parts]))
        return Formed(site, shape, settings[best], parts[best].sizes(), parts[best].gain())


def _best(site: Site, shape: Shape, knots: np.ndarray, scores: Scores) -> Formed:
    best: Formed | None = None
    for numbers in settings_of(shape, site.place.span):
        own = scores.of(shape.values(site.place.span, knots, numbers))
        gain = own.gain()
        if best is None or gain > best.gain:
            best = Formed(site, shape, numbers, own.sizes(), gain)
    assert best is not None
    return best


def _waves(shape: Shape) -> bool:
    return any(n.name == "period" for n in shape.numbers)


def _resolved(values: np.ndarray) -> float:
    """Shortest period that the nodes of a run show."""
    return WAVE_NODES * float(np.median(np.abs(np.diff(values, axis=1))))


def settings_of(shape: Shape, span: Span) -> list[dict[str, float]]:
    """All settings of the numbers of a shape that are looked at."""
    out: list[dict[str, float]] = [{}]
    for number in shape.numbers:
        out = [s | {number.name: float(v)} for s in out for v in number.grid(span)]
    return out
