# SPDX-License-Identifier: Apache-2.0
"""State of the search: a fitted model with floor, noise, whitened sums, and the columns of all
effects that may be added."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import chain

import numpy as np

from flatplank_analysis.discovery import floor as floors
from flatplank_analysis.discovery import gram as grams
from flatplank_analysis.discovery import noise as noises
from flatplank_analysis.discovery.effect import Effect, variants_of
from flatplank_analysis.discovery.fit import Fit, Fitter, Term, Whitened, fit_whitened
from flatplank_analysis.discovery.model import Model, ParameterSet, form_error_of, usual_scatter
from flatplank_analysis.discovery.patterns import Patterns
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.discovery.scatter import likeliest_scatter, scatter_of
from flatplank_analysis.discovery.sources import can_show, scatter_lower_bound, source_of
from flatplank_data.errors import FlatplankError


@dataclass(frozen=True)
class Candidate:
    """One effect in one setting, with the columns of its screened parameters."""

    effect: type[Effect]
    setting: dict[str, float]
    columns: np.ndarray
    """(k, channels, runs, samples), change of the prediction by one screening step of each"""


@dataclass
class State:
    """A fitted model with everything that decisions need."""

    model: Model
    fitter: Fitter
    fit: Fit
    residual: np.ndarray
    offered: Callable[[], list[Candidate]]
    """makes `candidates`, which are large"""
    floors: list[floors.Floor]
    """per channel"""
    noise: noises.ChannelNoise
    """of the first channel, without the form error of the model"""
    metric: grams.Metric
    """metric of the decisions: the form error of the model is no evidence of an effect"""
    whitened: Whitened
    """fit of the same model with the smallest whitened chi2"""
    left: np.ndarray
    """(channels, runs, samples), residual of this fit; where nothing is repeated without what a
    usual scatter of the tire explains"""

    @property
    def runs(self) -> RunSet:
        return self.model.runs

    @cached_property
    def candidates(self) -> list[Candidate]:
        """Columns of all effects that may be added."""
        return self.offered()

    @cached_property
    def independent(self) -> float:
        """Independent numbers of all runs in the first channel, by the noise model."""
        return self.runs.runs * noises.freedom_of(self.runs, self.metric.whitener.noises[0])

    @cached_property
    def expected_errors(self) -> np.ndarray:
        """Standard error (conditions, samples) of the mean residual of the first channel, by the
        noise model and the scatter of the tire. Zero without repeats: the noise model then is the
        residual itself.
        """
        runs, noise, groups = self.runs, self.noise, self.runs.groups
        if not runs.repeated:
            return np.zeros((len(groups), runs.samples))
        directions = scatter_columns(self.model, self.whitened.fit)[:, 0]
        sideways = directions * self.metric.scatter[:, None, None]
        variance = noise.weights.sum() * noise.scale[:, None] ** 2 + np.sum(sideways**2, axis=0)
        return np.sqrt([np.sum(variance[g], axis=0) / len(g) ** 2 for g in groups])

    def gram(self, residual: np.ndarray, *columns: np.ndarray) -> grams.Gram:
        """Whitened sums of products of any columns and residual."""
        return self.metric.gram(residual, *columns)

    def sums(self, fit: Fit, rows: Sequence[int], *columns: np.ndarray) -> grams.Gram:
        """Whitened sums of a fit: of its residual, of `rows` of its Jacobian with their priors,
        and of further columns (n, channels, runs, samples)."""
        residual = fit.residual(self.runs.measured)
        gram = self.gram(residual, fit.jacobian[list(rows)], *columns)
        return gram.with_priors(*self.fitter.prior_terms(fit, rows))

    @cached_property
    def patterns(self) -> Patterns:
        """Bumps and waves in the residual of the first channel."""
        fit = self.whitened.fit
        left = fit.residual(self.runs.measured)
        return Patterns(self.runs, self.metric, fit.jacobian[fit.loose()], left, self.residual[0])

    def fit_whitened(self, fit: Fit, most: int = 12) -> Whitened:
        """Minimise the whitened chi2 from a fit."""
        return fit_whitened(self.metric, self.fitter, fit, most)

    def with_term(self, term: Term, most: int) -> Whitened:
        """The whitened fit with one more effect, using `most` Jacobians."""
        return self.fit_whitened(self.fitter.with_term(self.whitened.fit, term), most)


def make_candidates(
    model: Model, fit: Fit, effects: Sequence[type[Effect]], residual: np.ndarray
) -> list[Candidate]:
    """Columns of all effects that are not (or not often enough) in the model yet."""
    return list(_candidates(model, fit, effects, residual))


def _candidates(
    model: Model, fit: Fit, effects: Sequence[type[Effect]], residual: np.ndarray
) -> Iterator[Candidate]:
    """The same, one after the other: the columns of one effect are in memory at a time."""
    own = fit.parameter_set()
    for effect in effects:
        present = sum(t.effect is effect for t in fit.terms)
        if present >= effect.instances or not effect.separable(model.runs):
            continue
        settings, linear = list(variants_of(effect, model.runs, residual)), effect.linear()
        vectors = [
            effect.vector(s | {p.name: p.null + p.screen}) for s in settings for p in linear
        ]
        if not vectors:
            continue
        sets = [ParameterSet(own.base, (*own.effects, (effect, values))) for values in vectors]
        changes = model.predict(sets)
        changes -= fit.predicted
        if not np.isfinite(changes.sum()):
            where = f"effect {effect.identifier}"
            raise FlatplankError("predicts NaN or infinity", where, "check its range")
        for setting, columns in zip(settings, np.split(changes, len(settings)), strict=True):
            if can_show(model.runs, columns):
                yield Candidate(effect, setting, columns)


def scatter_columns(model: Model, fit: Fit) -> np.ndarray:
    """Prediction changes along `Model.scatter_directions` (d, channels, runs, samples)."""
    scale = {p.name: abs(p.screen) for p in model.parameters if p.screen}
    rows = {name: i for i, (term, name) in enumerate(fit.free) if term < 0}
    out = []
    for direction in model.scatter_directions(fit.base):
        known = [(n, amount / scale[n]) for n, amount in direction.items() if n in rows]
        out.append(np.sum([fit.jacobian[rows[n]] * share for n, share in known], axis=0))
    return np.array(out) if out else np.zeros((0, *fit.predicted.shape))


def make_state(
    model: Model,
    fitter: Fitter,
    fit: Fit,
    effects: Sequence[type[Effect]],
    near: Fit | None = None,
) -> State:
    """Screen columns, floor, noise and whitening of a fitted model.

    near: a whitened fit with the same terms, when one is known.
    """
    runs = model.runs
    residual = fit.residual(runs.measured)
    known = None if near is None else make_candidates(model, near, effects, residual)
    beside = _candidates(model, fit, effects, residual) if known is None else known
    cleaned, levels = _cleaned(runs, fit, beside, residual), []
    contrasts = np.stack([one.contrasts for one in cleaned])
    directions = scatter_columns(model, near or fit)
    bound = source_of(runs).lower_bound
    model_noise = noises.fit_noise(runs, residual if bound else contrasts, residual, directions)
    form = [form_error_of(model).share(c) for c in range(len(residual))]
    seen = form * np.abs(runs.mean(fit.predicted)).max(axis=(1, 2))
    with_form = list(map(noises.no_quieter, model_noise, seen))
    # repeats scatter by the noise alone
    alone = noises.make_whitener(runs, model_noise)
    scatter = scatter_of(runs, alone, contrasts, directions, usual_scatter(model))
    metric = grams.Metric(noises.make_whitener(runs, with_form), directions, scatter)
    found = fit_whitened(metric, fitter, near or fit)
    found = replace(found, fit=fitter.derivative(found.fit))
    # a gap of the machine turns the directions of the scatter where the force crosses it
    metric = metric.along(scatter_columns(model, found.fit))
    least, left = np.zeros((len(residual), len(runs.groups))), found.fit.residual(runs.measured)
    if bound:
        left -= likeliest_scatter(alone, left, directions, scatter)
        least = _least(runs, residual - left)
    # in the first channel the verdict says what is left beyond the noise alone
    for c, noise in enumerate([model_noise[0], *with_form[1:]]):
        # a lower bound holds at every node; the residual's own correlation is no measure of it
        per_run = runs.samples if bound else noises.freedom_of(runs, noise)
        levels.append(floors.floor_of(runs, residual[c], cleaned[c], c, per_run, least[c]))
    # the whitened fit may be far from the plain one, where the columns differ
    offered = partial(make_candidates, model, found.fit, effects, residual)
    if known is not None:
        offered = partial(list, known)
    return State(
        model, fitter, fit, residual, offered, levels, model_noise[0], metric, found, left
    )


def _least(runs: RunSet, scattered: np.ndarray) -> np.ndarray:
    """Lower bound (channels, conditions) of the floor where nothing is repeated: what is known of
    the noise, and the part (channels, runs, samples) of the residual that a usual scatter of the
    tire explains."""
    least = np.zeros((len(scattered), len(runs.groups)))
    for c, part in enumerate(scattered):
        square = [np.mean(part[g] ** 2) for g in runs.groups]
        least[c] = np.hypot(scatter_lower_bound(runs, c), np.sqrt(square))
    return least


def _cleaned(
    runs: RunSet, fit: Fit, candidates: Iterable[Candidate], residual: np.ndarray
) -> list[floors.Cleaned]:
    """Contrasts of each channel without what the effects of the model and the candidates show."""
    owners = np.array([term for term, _ in fit.free])
    present = (fit.jacobian[owners == i] for i in range(len(fit.terms)))
    pools: list[list[np.ndarray]] = [[] for _ in runs.channels]
    for block in chain((c.columns for c in candidates), present):
        for c, pool in enumerate(pools):
            alive = block[np.abs(block[:, c]).max(axis=(1, 2)) > 0.0, c]
            pool += floors.contrast_blocks(runs, [alive] if len(alive) else [])
    return [
        floors.clean_contrasts(runs, one, pool) for one, pool in zip(residual, pools, strict=True)
    ]


def channel_weights(model: Model, levels: Sequence[float]) -> np.ndarray:
    """Weights (channels, 1, 1) of the plain least squares: one over the expected error of a
    channel, from its floor [unit] and the form error as a share of its largest mean signal.

    By the floor alone a quiet channel would demand a fit that no model of this form can give, at
    the expense of the others.
    """
    form = np.array([form_error_of(model).share(c) for c in range(len(levels))])
    off = np.hypot(np.array(levels, dtype=float), form * model.runs.largest)
    return 1.0 / np.maximum(off, 1e-12)[:, None, None]


def rough_levels(model: Model) -> list[float]:
    """Levels for the first weights: the smaller of node-to-node and repeat-to-repeat scatter."""
    runs = model.runs
    near = np.sqrt(np.mean(np.diff(runs.measured, 2, axis=-1) ** 2, axis=(1, 2)) / 6.0)
    if not runs.repeated:
        return [float(max(n, 1e-9)) for n in near]
    contrast = runs.contrast(runs.measured)
    spare = sum(len(g) - 1 for g in runs.groups) * runs.samples
    between = np.sqrt(np.sum(contrast**2, axis=(1, 2)) / max(spare, 1))
    return [float(max(min(b, 4.0 * n), 1e-9)) for b, n in zip(between, near, strict=True)]


def start_base(model: Model, given: Mapping[str, float] | None = None) -> np.ndarray:
    """Start values of the base parameters, with the given ones replaced."""
    given = given or {}
    return np.array([float(given.get(p.name, p.null)) for p in model.parameters])


def term_with(term: Term, named: Mapping[str, float]) -> Term:
    """The term with other values [SI] by name, within its bounds."""
    values = {
        p.name: float(np.clip(named.get(p.name, value), p.lower, p.upper))
        for p, value in zip(term.effect.parameters(), term.values, strict=True)
    }
    return Term(term.effect, term.effect.vector(values), term.fixed)


def term_of(candidate: Candidate, sizes: np.ndarray) -> Term:
    """A term at the screened sizes (in screening steps), within its bounds."""
    effect, values = candidate.effect, dict(candidate.setting)
    for p, size in zip(effect.linear(), sizes, strict=True):
        values[p.name] = float(np.clip(p.null + p.screen * size, p.lower, p.upper))
    return Term(effect, effect.vector(values), effect.held())
