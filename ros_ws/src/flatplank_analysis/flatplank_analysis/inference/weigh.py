# SPDX-License-Identifier: Apache-2.0
"""Weighs one set of effects: joint fit, and the evidence of the set around it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from scipy.special import logsumexp, softmax
from scipy.stats import norm

from flatplank_analysis.discovery.dispersion import among_repeats, scores_of
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.fit import (
    Fit,
    Fitter,
    Term,
    Whitened,
    doubling_step,
    fit_whitened,
    whitened_priors,
)
from flatplank_analysis.discovery.gram import Gram
from flatplank_analysis.discovery.screen import Screen, screen
from flatplank_analysis.discovery.state import (
    State,
    make_candidates,
    scatter_columns,
    term_with,
)
from flatplank_analysis.inference import priors
from flatplank_analysis.inference.errors import (
    FORMS,
    SHARED,
    STRETCHES,
    WORSE,
    WithLawErrors,
    effect_errors,
    shared_errors,
    with_law_errors,
)
from flatplank_analysis.inference.evidence import Evidence, Fixed, Random, evidence

UNKNOWN = 1.0
"""standard deviation of an unknown fault's amount in a condition or stretch, relative to the size
that an effect of the library has in its place"""
JACOBIANS = 6
"""most Jacobians of a joint fit"""


def key_of(terms: Iterable[Term]) -> tuple[str, ...]:
    """Names of the effects of a set in alphabetical order, each as often as it is in the set."""
    return tuple(sorted(t.effect.identifier for t in terms))


@dataclass(frozen=True)
class Weighed:
    """A set of effects after its joint fit, with the parts of its evidence."""

    fit: Fit
    parts: tuple[tuple[float, float], ...]
    """for each size of the model errors (`WORSE`): smallest sum of squares in units of the noise;
    and logarithm of posterior over prior volume of all parameters, with that of the priors of the
    set and of this size"""
    sizes: tuple[tuple[float, float], ...]
    """per effect: most probable size and its standard deviation there, in the unit of the size"""
    rank: int = 0
    """number of the likeliest size of the model errors"""
    unknown: tuple[tuple[tuple[float, float], ...], ...] = ()
    """per effect: the same two parts at that size for what may look like it: scatter about zero
    with the effect's own form errors; and an unknown fault, which acts as the effect does, but by
    another amount in each condition and each stretch"""

    @property
    def names(self) -> list[str]:
        """Name of each effect, in the order of the fit."""
        return [t.effect.identifier for t in self.fit.terms]

    def stated(self, index: int) -> Term:
        """An effect at its most probable size; the fit weighs less of what may be wrong."""
        term = self.fit.terms[index]
        size, named = term.size, term.named()
        share = self.sizes[index][0] / size if size else 1.0
        scaled = {p.name: p.null + share * (named[p.name] - p.null) for p in term.effect.linear()}
        return term_with(term, scaled)

    @cached_property
    def key(self) -> tuple[str, ...]:
        return key_of(self.fit.terms)

    @property
    def log(self) -> float:
        """Logarithm of the evidence, but for a constant of the data."""
        return float(logsumexp([volume - 0.5 * chi2 for chi2, volume in self.parts]))


@dataclass(frozen=True)
class Scales:
    """Noise and model errors by which sets are weighed; all sets that are compared share them."""

    state: State
    """fitted model whose noise and scatter are used"""
    metric: WithLawErrors
    effects: Sequence[type[Effect]]
    """effects that are searched"""
    ranking: Screen
    """candidates beside the model of the state"""
    library: float
    """number of effects among which one is looked for"""

    @classmethod
    def of(cls, state: State, effects: Sequence[type[Effect]]) -> Scales:
        """Noise of a state, and the errors of its model, of the size that is likeliest for it."""
        scales = cls(state, with_law_errors(state), effects, screen(state), len(effects))
        factor = WORSE[scales.fitted(state.whitened.fit).rank]
        return replace(scales, metric=scales.metric.larger(factor))

    @property
    def fitter(self) -> Fitter:
        return self.state.fitter

    @property
    def dispersion(self) -> float:
        """Typical scatter of sizes among repeats, relative to the noise model."""
        return self.ranking.typical.dispersion

    @cached_property
    def freedom(self) -> float:
        """Degrees of freedom of the noise level: those of the repeats and of the residual."""
        return self.state.floors[0].freedom + self.state.independent

    def metric_at(self, fit: Fit) -> WithLawErrors:
        """The metric with the scatter along the directions that the tire has at a fit."""
        return self.metric.along(scatter_columns(self.state.model, fit))

    def fitted(self, start: Fit, most: int = JACOBIANS) -> Weighed:
        """Joint fit of the base and of all effects from a start, and its evidence."""
        metric = self.metric_at(start)
        if metric.factor > WORSE[0]:
            # as large as the base needs them; a set that lacks less needs smaller ones
            metric = metric.larger(WORSE[self.weighed(start, metric).rank])
        found = fit_whitened(metric, self.fitter, start, most)
        return self.weighed(self.fitter.derivative(found.fit))

    def with_term(self, parent: Fit, term: Term, most: int = JACOBIANS) -> Weighed:
        """Joint fit with one more effect."""
        return self.fitted(self.fitter.with_term(parent, term), most)

    def weighed(self, fit: Fit, metric: WithLawErrors | None = None) -> Weighed:
        """Evidence of the set of effects of a fit, whose Jacobian is that of its parameters.

        metric: that of `metric_at` the fit, where it is known.
        """
        rows, effects = fit.loose(), range(len(fit.terms))
        metric = metric or self.metric_at(fit)
        errors = [effect_errors(self.state.model, fit, i) for i in effects]
        residual = fit.residual(self.state.runs.measured)
        whole = [fit.predicted - self.fitter.without_term(fit, i).predicted for i in effects]
        late = shared_errors(self.state.model, fit.predicted)
        columns = [fit.jacobian[rows], late, *errors, *(w[None] for w in whole), residual[None]]
        white = metric.plain(np.concatenate(columns))
        fixed = self._fixed(fit, rows)
        parts, best, mixed = [], [], []
        for factor in WORSE:
            gram = gram_of(metric.down_weighted(white, factor))
            spreads = [self._dispersion(fit, len(rows), i, gram) for i in effects]
            forms = self._by_form(gram, fixed, len(rows), spreads, factor)
            form = max(forms, key=lambda f: forms[f].log)
            result = forms[form]
            # the average over the forms: where they fit alike, none has a price
            volume = result.volume
            volume += float(logsumexp([r.log - result.log for r in forms.values()]))
            size = metric.volume_with(factor) - math.log(len(forms)) - 2.0 * math.log(factor)
            parts.append((result.chi2, volume + size))
            mixed += [(r.log + size, f, r) for (f, _), r in forms.items()]
            best.append((volume + size - 0.5 * result.chi2, gram, spreads, form, result))
        rank = max(range(len(WORSE)), key=lambda r: best[r][0])
        _, gram, spreads, form, result = best[rank]
        sizes = tuple(self._size(fit, rows, i, mixed) for i in effects)
        price = priors.of_set(len(fit.terms), self.library)
        price += sum(priors.of_term(t, t.effect.scanned(self.state.runs)) for t in fit.terms)
        price += sum(_inside(t.effect, s) for t, s in zip(fit.terms, sizes, strict=True))
        unknown = [
            self._unknown(gram, fixed, fit, rows, i, spreads, form, result) for i in effects
        ]
        size = price + parts[rank][1] - result.volume
        return Weighed(
            fit, tuple((chi2, volume + price) for chi2, volume in parts), sizes, rank,
            tuple(tuple((chi2, volume + size) for chi2, volume in one) for one in unknown),
        )  # fmt: skip

    def _unknown(
        self, gram: Gram, fixed: Fixed, fit: Fit, rows: Sequence[int], index: int,
        spreads: Sequence[float], forms: tuple[float, float], result: Evidence,
    ) -> list[tuple[float, float]]:  # fmt: skip
        """`Weighed.unknown` of an effect, but for the price of the set.

        spreads: of each effect, see `_dispersion`; forms: likeliest sizes of the form errors and
        of the shared transient error; result: evidence of the set with them.
        """
        own = [k for k, row in enumerate(rows) if fit.free[row][0] == index]
        keep = [k for k in range(gram.scores.shape[1]) if k not in own]
        place = gram.scores.shape[1] - len(fit.terms) + index
        # the residual with the effect at its null
        scores = gram.scores + gram.products[:, :, place]
        energy = gram.energy + 2.0 * gram.scores[:, place] + gram.products[:, place, place]
        less = Gram(gram.products[:, keep][:, :, keep], scores[:, keep], energy)
        rest, count = fixed.without(own), len(rows) - len(own)
        along = np.abs(doubling_step(fit, index)[rows])[own]
        wide = np.sqrt(2.0 * np.pi * np.diag(result.covariance)[own])
        # the amount has the prior of the size, within a factor
        width = float(np.sum(np.log(np.maximum(along, wide))))
        out, (form, late) = [], forms
        for amount in (form, UNKNOWN):
            errors = (
                self._form_errors(less, count, i, amount if i == index else form, spread)
                for i, spread in enumerate(spreads)
            )
            shared = self._shared(less, count, late)
            found = evidence(less, rest, [shared, *(r for one in errors for r in one)])
            out.append((found.chi2, found.volume + width))
        return out

    def _by_form(
        self, gram: Gram, fixed: Fixed, own: int, spreads: Sequence[float], factor: float
    ) -> dict[tuple[float, float], Evidence]:
        """Evidence with form errors of the effects of each of the sizes `FORMS`, and a transient
        error that all runs share of each of the sizes `SHARED`."""
        out = {}
        for form in FORMS if spreads else FORMS[:1]:
            each = (self._form_errors(gram, own, i, form, s) for i, s in enumerate(spreads))
            errors = [r for one in each for r in one]
            for late in SHARED:
                shared = self._shared(gram, own, factor * late)
                out[form, factor * late] = evidence(gram, fixed, [shared, *errors])
        return out

    def _shared(self, gram: Gram, own: int, size: float) -> Random:
        """The transient error that all runs share; own: number of columns of the fit."""
        mix = np.eye(gram.scores.shape[1])[own : own + 1 + STRETCHES]
        everywhere = np.zeros(self.state.runs.runs, dtype=int)
        return Random(mix, everywhere, np.full(len(mix), size))

    def ranked(self, fit: Fit) -> tuple[State, Screen]:
        """Candidates beside a fit, with the columns that they would have there."""
        residual = fit.residual(self.state.runs.measured)
        offered = partial(make_candidates, self.state.model, fit, self.effects, residual)
        whitened = Whitened(fit, math.nan)
        state = replace(
            self.state, fit=fit, residual=residual, offered=offered, metric=self.metric_at(fit),
            whitened=whitened,
        )  # fmt: skip
        return state, screen(state)

    def _fixed(self, fit: Fit, rows: Sequence[int]) -> Fixed:
        task = self.fitter.task(fit)
        z = task.pack(fit.base, fit.terms)
        centre, strength = whitened_priors(task.entries)
        pull = strength * (centre - z)
        distance = float(np.sum(strength[rows] * (centre - z)[rows] ** 2))
        # a range is a weak prior: it keeps what these runs do not show from counting
        width = np.where(np.isfinite(task.upper - task.lower), task.upper - task.lower, np.inf)
        strength = strength + 12.0 / width**2
        for i, entry in enumerate(task.entries):
            if entry.term >= 0 and entry.parameter.screen:
                p, effect = entry.parameter, fit.terms[entry.term].effect
                scale = priors.scale_of_size(effect, p) / entry.scale
                strength[i] = priors.curvature(z[i] - p.null / entry.scale, scale)
        low, high = task.lower - z, task.upper - z
        return Fixed(strength[rows], pull[rows], low[rows], high[rows], distance)

    def _form_errors(
        self, gram: Gram, own: int, index: int, form: float, spread: float
    ) -> Iterator[Random]:
        """An effect's size differs between conditions, along the run, and from run to run.

        own: number of columns of the fit; form: standard deviation of the first two differences;
        spread: that of the last one.
        """
        runs = self.state.runs
        parts = _parts(gram, own, index)
        whole = _whole(gram, own, index)
        yield Random(whole, runs.condition, np.array([form]))
        yield Random(parts, np.zeros(runs.runs, dtype=int), np.full(len(parts), form))
        if runs.repeated and spread > 0.0:
            yield Random(whole, np.arange(runs.runs), np.array([spread]))

    def _dispersion(self, fit: Fit, own: int, index: int, gram: Gram) -> float:
        """Standard deviation of the relative size from run to run beyond the typical scatter."""
        beside = [k for k, i in enumerate(fit.loose()) if fit.free[i][0] != index]
        whole = _whole(gram, own, index)[0]
        mix = np.concatenate([np.eye(len(whole))[beside], whole[None]])
        reduced = Gram(mix @ gram.products @ mix.T, gram.scores @ mix.T, gram.energy)
        score, info = scores_of(reduced, len(beside))
        typical = self.ranking.typical
        kappa, _ = typical.shrink(*among_repeats(self.state.runs.comparable, score, info))
        excess = kappa / max(typical.dispersion, 1.0) - 1.0
        # a scatter of the relative size moves a score by its information
        known = float(np.sum(info**2) / max(float(np.sum(info)), 1e-30))
        return math.sqrt(max(excess, 0.0) / known) if known > 0.0 else 0.0

    def _size(
        self, fit: Fit, rows: Sequence[int], index: int,
        mixed: Sequence[tuple[float, float, Evidence]],
    ) -> tuple[float, float]:  # fmt: skip
        """Mean size of an effect and its standard deviation, by the relative change of all its
        linear parameters together, over all sizes of the model errors and of the form errors.

        A fault of another form may differ from that of the library in all conditions alike, by as
        much as they differ from each other; of that the runs show nothing.

        mixed: logarithm of the weight of each, size of its form errors, and its evidence.
        """
        along = doubling_step(fit, index)[rows]
        size, length = fit.terms[index].size, float(along @ along)
        if length == 0.0:
            return size, max(abs(size), 1e-30)
        count = len(rows)
        logs, forms, each = zip(*mixed, strict=True)
        weights = softmax(logs)
        steps = np.array([float(along @ e.step[:count]) for e in each]) / length
        variances = np.array([along @ e.covariance[:count, :count] @ along for e in each])
        step = float(weights @ steps)
        variances = variances / length**2 * self.dispersion + np.square(forms)
        variance = float(weights @ (variances + (steps - step) ** 2))
        return size * (1.0 + step), max(abs(size) * math.sqrt(max(variance, 0.0)), 1e-30)


def gram_of(white: np.ndarray) -> Gram:
    """Sums of columns and, the last row, a residual (n, runs, m) in the metric."""
    return Gram.of(np.moveaxis(white[:-1], 0, 1), white[-1])


def _parts(gram: Gram, own: int, index: int) -> np.ndarray:
    """(2 * STRETCHES, columns): places of the form errors of an effect in the sums."""
    first = own + 1 + STRETCHES + 2 * STRETCHES * index
    return np.eye(gram.scores.shape[1])[first : first + 2 * STRETCHES]


def _whole(gram: Gram, own: int, index: int) -> np.ndarray:
    """(1, columns): the whole contribution of an effect as a combination of the sums."""
    return _parts(gram, own, index)[:STRETCHES].sum(axis=0, keepdims=True)


def _inside(effect: type[Effect], size: tuple[float, float]) -> float:
    """Logarithm of the share of the Gaussian of a one-sided size on its side."""
    if not priors.is_one_sided(effect.main_parameter()):
        return 0.0
    return float(norm.logcdf(abs(size[0]) / size[1]))
