# SPDX-License-Identifier: Apache-2.0
"""Score columns of curves and shapes at every site, with the model's columns projected out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from flatplank_analysis.contact_patch.tire_runs import TireRuns
from flatplank_analysis.discovery.gram import solve
from flatplank_analysis.discovery.model import ParameterSet
from flatplank_analysis.discovery.state import State
from flatplank_analysis.effects.grammar.hooks import NONE
from flatplank_analysis.effects.grammar.sentence import Site, SiteCoordinate
from flatplank_analysis.effects.grammar.shapes import shapes
from flatplank_analysis.effects.grammar.shapes.base import ANGLE, LEVEL, PLACE, Shape, Span
from flatplank_analysis.identify.results import NORMAL_90
from flatplank_analysis.proposal.curves import basis_of, effect_of_curve, knots_of
from flatplank_analysis.proposal.sites import EVENT, event_coordinate

WAVE_NODES = 6
"""least number of nodes per period of a wave"""
HINTS = 4
"""settings of a wave that are tried at every hook: those at which a force over the place gains
most, half of them with the sign of the slip"""
AT_ONCE = 40
"""forces over all channels that are computed at once, which limits memory"""
POINTS = 240
"""points of a drawn curve"""

CURVE, WAVE, SETTING, FURTHER = "curve", "wave", "setting", "further column"


@dataclass(frozen=True)
class Scores:
    """Sums of products of some columns with the model's own columns projected out."""

    info: np.ndarray
    """(k, k)"""
    score: np.ndarray
    """(k,)"""

    def sizes(self) -> np.ndarray:
        return solve(self.info, self.score)[0]

    def gain(self) -> float:
        """Drop of the whitened chi2 at the best sizes."""
        return float(self.sizes() @ self.score)

    def parts(self, k: int) -> list[Scores]:
        """The sums of consecutive sets of k columns."""
        rows = [slice(i, i + k) for i in range(0, len(self.score), k)]
        return [Scores(self.info[r, r], self.score[r]) for r in rows]

    def of(self, mix: np.ndarray) -> Scores:
        """The sums of combinations (n, k) of the columns."""
        return Scores(mix @ self.info @ mix.T, mix @ self.score)


@dataclass(frozen=True)
class ScanResult:
    """A site with the gain of its free curve, or of a wave of free period."""

    site: Site
    gain: float
    count: int
    """number of coefficients of the curve"""
    looks: int
    """number of columns tested"""
    kind: str
    """kind of test: a CURVE along the run; a WAVE; a curve over a SETTING of the runs, or a
    constant; a curve over a FURTHER column of the user"""
    forms: Mapping[int, float] = field(default_factory=dict)
    """by number of parameters: gain of the best form, estimated from the curve"""

    def evidence(self, dispersion: float, price: float) -> float:
        """Gain in units of the scatter, minus the penalties for parameters and number of tests: of
        the curve, or of the best form."""
        looking = 2.0 * float(np.log(self.looks / self.count))
        made = [(self.count, self.gain), *self.forms.items()]
        return max(gain / dispersion - price * count for count, gain in made) - looking


@dataclass(frozen=True)
class FreeCurve:
    """A free curve over its coordinate, in the unit of the hook; all (points,)."""

    u: np.ndarray
    values: np.ndarray
    half: np.ndarray
    """half width of the band"""


@dataclass(frozen=True)
class FittedShape:
    """A shape at a site, with its best numbers."""

    site: Site
    shape: Shape
    numbers: dict[str, float]
    sizes: np.ndarray
    """sizes in the unit of the hook"""
    gain: float

    def evidence(self, dispersion: float, price: float) -> float:
        """Gain in units of the scatter, minus the penalty for its parameters."""
        return self.gain / dispersion - price * self.shape.price


class Scanner:
    """The whitened residual of a state, with the state's own columns projected out."""

    def __init__(self, state: State, data: TireRuns) -> None:
        self.state, self.data = state, data
        self.fit = state.whitened.fit
        own = self._flat(self.fit.jacobian[self.fit.loose()])
        norm = np.maximum(np.linalg.norm(own, axis=1), 1e-12)
        self.own = np.linalg.qr((own / norm[:, None]).T)[0].T
        self.residual = self._off(self._flat(self.fit.residual(state.runs.measured)[None]))[0]
        self.event = event_coordinate(data) if EVENT in state.runs.coordinates else None
        self._hints: dict[tuple[str, str, str], list[dict[str, float]]] = {}

    def _flat(self, columns: np.ndarray) -> np.ndarray:
        return self.state.metric(columns).reshape(len(columns), -1)

    def _off(self, flat: np.ndarray) -> np.ndarray:
        return flat - (flat @ self.own.T) @ self.own

    def columns(self, site: Site, basis: np.ndarray) -> np.ndarray:
        """Response of the model to each basis function, per unit of the hook."""
        effect, own = effect_of_curve(site, basis), self.fit.parameter_set()
        step = site.hook.screen
        rows = step * np.eye(len(basis))
        sets = [ParameterSet(own.base, (*own.effects, (effect, row))) for row in rows]
        return (self.state.model.predict(sets) - self.fit.predicted) / step

    def scores(self, site: Site, basis: np.ndarray) -> Scores:
        """Projected sums of products of a site's columns."""
        flat = self._off(self._flat(self.columns(site, basis)))
        return Scores(flat @ flat.T, flat @ self.residual)

    def free_curve(self, site: Site, dispersion: float) -> FreeCurve:
        """The coarse curve of a site with its 90 % band, over the range of its coordinate."""
        scores = self.scores(site, basis_of(site, fine=False))
        sizes, inverse = solve(scores.info, scores.score)
        span = site.coordinate.span
        u = np.linspace(span.low, span.high, POINTS)
        basis = basis_of(site, fine=False, u=u)
        variance = np.einsum("kn,kl,ln->n", basis, inverse, basis)
        half = NORMAL_90 * np.sqrt(np.maximum(dispersion * variance, 0.0))
        return FreeCurve(u, sizes @ basis, half)

    def curve(self, site: Site) -> ScanResult:
        """The coarse curve of a site."""
        scores = self.scores(site, basis_of(site, fine=False))
        count = len(scores.score)
        forms = {}
        if site.coordinate.span.kind == ANGLE:
            forms = {2: max(p.gain() for p in scores.parts(2))}
        for f in self._of_curve(site, scores, fine=False):
            forms[f.shape.price] = max(f.gain, forms.get(f.shape.price, 0.0))
        return ScanResult(site, scores.gain(), count, count, self._kind(site.coordinate), forms)

    def _kind(self, coordinate: SiteCoordinate) -> str:
        if coordinate.name in self.data.further:
            return FURTHER
        return SETTING if coordinate.span.kind in (NONE, LEVEL) else CURVE

    def wave(self, site: Site) -> ScanResult | None:
        """The best wave over a place, constant or decaying after the step."""
        if site.coordinate.span.kind != PLACE:
            return None
        made = [f for f in (self._hinted(s, at) for s, at in _wave_shapes(site, self.event)) if f]
        if not made:
            return None
        best = max(made, key=lambda f: f.gain)
        looks = sum(2 * len(settings_of(f.shape, f.site.coordinate.span)) for f in made)
        return ScanResult(site, best.gain, 2, looks, WAVE)

    def _hinted(self, shape: Shape, site: Site) -> FittedShape | None:
        """A wave with the settings at which a force over that place has the largest gain."""
        key = (shape.name, site.coordinate.name, site.modulator.name)
        if key not in self._hints:
            self._hints[key] = self._hints_of(shape, site)
        return self._waves(site, self._hints[key], shape)

    def _hints_of(self, shape: Shape, site: Site) -> list[dict[str, float]]:
        """Settings at which a force has the largest gain, also with the sign of the slip."""
        coordinate, weight = site.coordinate, site.modulator.values(self.data)
        pairs = shape.name == "beat"
        single = shapes()["wave"] if pairs else shape
        shortest = WAVE_NODES * float(np.median(np.abs(np.diff(coordinate.values, axis=1))))
        settings = [s for s in settings_of(single, coordinate.span) if s["period"] > shortest]
        if len(settings) < 2:
            return []
        basis = np.concatenate(
            [single.values(coordinate.span, coordinate.values, s) for s in settings]
        )
        out: list[dict[str, float]] = []
        turned = [] if site.modulator.name else [np.sign(self.data.kappa)]
        for sign in (np.ones(len(weight)), *turned):
            flat = self._force(basis * (weight * sign[:, None]))
            score, along = flat @ self.residual, flat @ self.own.T
            if pairs:
                one, other = _best_pair(flat @ flat.T - along @ along.T, score)
                found = [{"period": settings[one]["period"], "second": settings[other]["period"]}]
            else:
                two, beside = (m.reshape(len(settings), 2, -1) for m in (flat, along))
                info = two @ two.swapaxes(1, 2) - beside @ beside.swapaxes(1, 2)
                order = np.argsort(-_gains(info, score.reshape(-1, 2)))
                found = [settings[i] for i in order[: HINTS // 2]]
            out += [s for s in found if s not in out]
        return out

    def _force(self, basis: np.ndarray) -> np.ndarray:
        """Forces in the first channel (k, runs, samples) in units of the noise (k, m)."""
        out = []
        for part in np.array_split(basis, -(-len(basis) // AT_ONCE)):
            columns = np.zeros((len(part), *self.state.runs.measured.shape))
            columns[:, 0] = part
            out.append(self._flat(columns))
        return np.concatenate(out)

    def forms(self, scanned: ScanResult) -> Iterator[FittedShape]:
        """Every shape that suits a site, with its best numbers."""
        site, span = scanned.site, scanned.site.coordinate.span
        if scanned.kind == WAVE:
            found = [*_wave_shapes(site, self.event), (shapes()["beat"], site)]
            yield from (f for f in (self._hinted(s, at) for s, at in found) if f)
            return
        direct = [s for s in shapes().values() if s.suits(span) and not has_period(s)]
        if span.kind not in (ANGLE, NONE):
            scores = self.scores(site, basis_of(site, fine=True))
            yield from self._of_curve(site, scores, fine=True)
            direct = [s for s in direct if s.memory]
        for shape in direct:
            made = self._waves(site, settings_of(shape, span), shape)
            if made:
                yield made

    def _of_curve(self, site: Site, scores: Scores, fine: bool) -> Iterator[FittedShape]:
        """Shapes that are functions of the coordinate alone, with their best numbers."""
        coordinate = site.coordinate
        if coordinate.span.kind in (ANGLE, NONE):
            return
        knots = knots_of(coordinate.values, coordinate.span, fine)
        for shape in shapes().values():
            if not shape.memory and not has_period(shape) and shape.suits(coordinate.span):
                yield _best(site, shape, knots, scores)
        if self.event and coordinate.name != EVENT and EVENT in coordinate.alias:
            later = float(np.mean(coordinate.values - self.event.values))
            at = replace(site, coordinate=self.event)
            for shape in shapes().values():
                if shape.after_event:
                    yield _best(at, shape, knots - later, scores)

    def _waves(
        self, site: Site, settings: Sequence[dict[str, float]], shape: Shape
    ) -> FittedShape | None:
        """Best setting of a shape that is no sum of hats: every setting has its own columns."""
        coordinate, span = site.coordinate, site.coordinate.span
        if not settings:
            return None
        time = self.state.runs.time
        basis = np.concatenate([shape.values(span, coordinate.values, s, time) for s in settings])
        scores = self.scores(site, basis)
        k = len(shape.sizes)
        parts = scores.parts(k)
        best = int(np.argmax([p.gain() for p in parts]))
        return FittedShape(site, shape, settings[best], parts[best].sizes(), parts[best].gain())


def _best(site: Site, shape: Shape, knots: np.ndarray, scores: Scores) -> FittedShape:
    best: FittedShape | None = None
    for numbers in settings_of(shape, site.coordinate.span):
        own = scores.of(shape.values(site.coordinate.span, knots, numbers))
        gain = own.gain()
        if best is None or gain > best.gain:
            best = FittedShape(site, shape, numbers, own.sizes(), gain)
    assert best is not None
    return best


def _wave_shapes(site: Site, event: SiteCoordinate | None) -> Iterator[tuple[Shape, Site]]:
    """Single waves over a place and their sites; decaying ones begin at the step."""
    yield shapes()["wave"], site
    if event and EVENT in (site.coordinate.name, *site.coordinate.alias):
        yield shapes()["ringing"], replace(site, coordinate=event)


def _gains(info: np.ndarray, score: np.ndarray) -> np.ndarray:
    """Gain of each of n sets of k columns alone; sums (n, k, k) and (n, k)."""
    inverse = np.linalg.pinv(info, rcond=1e-6, hermitian=True)
    return np.einsum("ni,nij,nj->n", score, inverse, score)


def _best_pair(info: np.ndarray, score: np.ndarray) -> tuple[int, int]:
    """The two pairs of columns with the largest joint gain; sums of all (2n, 2n), (2n,)."""
    one, other = np.triu_indices(len(score) // 2, 1)
    rows = np.stack([2 * one, 2 * one + 1, 2 * other, 2 * other + 1], axis=1)
    best = int(np.argmax(_gains(info[rows[:, :, None], rows[:, None, :]], score[rows])))
    return int(one[best]), int(other[best])


def has_period(shape: Shape) -> bool:
    """True for a shape with a period."""
    return any(n.name == "period" for n in shape.numbers)


def settings_of(shape: Shape, span: Span) -> list[dict[str, float]]:
    """All settings of the numbers of a shape that are tested."""
    out: list[dict[str, float]] = [{}]
    for number in shape.numbers:
        out = [s | {number.name: float(v)} for s in out for v in number.grid(span)]
    return out
