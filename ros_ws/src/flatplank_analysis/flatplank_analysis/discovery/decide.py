# SPDX-License-Identifier: Apache-2.0
"""Significance tests of one effect after its refit; see `heldout` for left-out conditions.

A whitened test alone names a false effect in a fifth to a third of all campaigns, because tires
and machines scatter from run to run. So the drop of chi2 is divided by the dispersion of the
effect's own scores among repeats and among conditions, and its size must be the same everywhere.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.stats import f as f_distribution
from scipy.stats import norm
from scipy.stats import t as student

from flatplank_analysis.discovery import heldout
from flatplank_analysis.discovery.decision import IMITATED, NEGLIGIBLE, UNEVEN, Decision
from flatplank_analysis.discovery.dispersion import (
    TypicalDispersion,
    among_conditions,
    among_repeats,
    scores_of,
)
from flatplank_analysis.discovery.fit import Fit, Term, Whitened, effect_contribution
from flatplank_analysis.discovery.gram import Gram, solve
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.discovery.size_errors import shifts_of, size_errors, visible_share
from flatplank_analysis.discovery.state import State, Uneven

FAMILY = 0.05
"""family-wise error rate of the tests of all effects together"""
FORM = 0.03
"""error of the form of the model's force law, as a share of a fully visible effect"""
FAINT = 0.05
"""visible share of an effect below which its visibility beside the bare model is computed, too"""
STRETCHES = 5
"""parts of a run, of equal information, whose sizes of the effect are compared"""
SAME = 0.015
"""permitted difference of the size along the run, as a share of the drop of chi2: true effects
have 0 to 0.005, false ones 0.3 and more"""
NEARLY = 0.15
"""`OTHER` when a residual remains: half of the smallest value of false effects"""
PER_FREEDOM = 6.0
"""permitted sum of squares of the size along the run or among conditions, per degree of freedom"""
PRIOR = 4.0
"""least weight, in degrees of freedom, of the dispersion among repeats in that among conditions"""
CONDITIONS = 0.001
"""p-value required among conditions: strict, because they are few and because errors of the law's
form and of accepted effects also differ between conditions"""
SURE, CONDITIONS_OF_SURE = 1e-5, 0.005
"""p-value among repeats of a first effect, or of one beside a free form of the law, from which on
the second value is required among conditions: chance is excluded, and only an error of the law's
form could look like the effect. Where the scatter among conditions is beyond `PER_FREEDOM`, and
beyond `NEARLY` of the drop, one does"""
SHARE = 0.003
"""least drop of chi2 of a further effect, as a share of the drop explained already in the signals
in which it shows"""


@dataclass(frozen=True)
class Scatter:
    """Dispersion of an effect's scores over that of the noise model, with degrees of freedom."""

    repeats: float
    freedom: float
    own_conditions: float
    """among conditions, by these scores alone"""
    conditions: float
    """among conditions, shrunk towards that among repeats"""
    freedom_conditions: float


def scatter_among(
    runs: RunSet, typical: TypicalDispersion, score: np.ndarray, info: np.ndarray
) -> Scatter:
    """Scatter of the scores (runs,) of an effect with information (runs,)."""
    kappa, freedom = typical.shrink(*among_repeats(runs.comparable, score, info))
    kappa_c, freedom_c = among_conditions(runs.groups, score, info)
    # an effect that shows in two conditions has one degree of freedom: too few for a
    # dispersion of its own, so it is shrunk towards that among repeats
    prior_freedom = max(PRIOR, typical.freedom)
    total = freedom_c + prior_freedom
    shrunk = (freedom_c * kappa_c + prior_freedom * kappa) / total
    return Scatter(kappa, freedom, kappa_c, shrunk, total)


@dataclass(frozen=True)
class Judge:
    """Tests of the effects that may be added to a state, with the values they share."""

    state: State
    without: float
    """smallest whitened chi2 without the effect"""
    typical: TypicalDispersion
    others: tuple[Decision, ...] = ()
    """effects that were accepted before"""
    uneven: tuple[tuple[int, float], ...] = ()
    """accepted effects of a wrong form: index of the term, and `Decision.unevenness`"""
    bare: Fit | None = None
    """whitened fit without the effect, where it is not that of the state"""
    alike: Mapping[str, float] = field(default_factory=dict)
    """identifier of an effect like an accepted one -> drop that does not distinguish the two"""

    def decide(
        self, found: Whitened, index: int, looked_at: float, plain: Fit | None = None
    ) -> Decision:
        """Test effect `index` of a whitened fit.

        looked_at: divisor of the test level, the number of columns that were tested to find it;
        plain: the plain fit with the effect, for the held-out gain.
        """
        fit, state = found.fit, self.state
        term, runs = fit.terms[index], state.runs
        drop = self.without - found.chi2
        direction = effect_contribution(fit, index)
        linear = {(index, p.name) for p in term.effect.linear()}
        own = [i for i in fit.loose() if fit.free[i] not in linear]
        uneven = self._uneven_beside(fit, index)
        columns = direction[None], _stretches(state, direction), shifts_of(state, fit.predicted)
        gram = state.sums(fit, own, *columns, uneven=uneven)
        base = len(own) + (0 if uneven is None else len(uneven.strength))
        k = len([1 for owner, _ in fit.free if owner == index])
        local, info = scores_of(gram, base)
        scatter = scatter_among(runs, self.typical, local, info)
        beside = [row for row, i in enumerate(own) if fit.free[i][0] != index]
        others = fit.jacobian[[own[row] for row in beside]]
        errors = size_errors(state, gram, base, beside, others, direction)
        shrunk = scatter.conditions + errors.law * errors.information
        stretch_q, stretch_n = _stretch_test(gram, base)
        condition_q, condition_n = _condition_test(state, local, info)
        # the model's law has not the form of the tire's; repeats do not show this error, and the
        # smaller the visible share of an effect, the more of its size the law can imitate
        visible = visible_share(gram, beside, base)
        if visible < FAINT:
            visible = max(visible, self._visible_beside_the_bare(direction))
        form = FORM**2 / max(visible, 1e-9)
        variance = max(scatter.repeats, shrunk) / errors.information + form
        allowed = (
            PER_FREEDOM * stretch_n + SAME * drop,
            PER_FREEDOM * condition_n + SAME * drop,
        )
        if stretch_q > allowed[0] or condition_q > allowed[1]:
            # a fault of another form has a different size in every stretch and condition
            variance += max(stretch_q, condition_q) / max(drop, 1e-30) / (STRETCHES - 1)
        # the repeats estimate the variance; the model's shift has a known one
        quantile = student.ppf(0.95, scatter.freedom)
        relative = np.hypot(quantile * np.sqrt(variance), norm.ppf(0.95) * errors.late)
        spread = abs(term.size) * float(relative)
        firm = drop if uneven is None else min(drop, _drop_beside(gram, base))
        p_repeats = _p_value(firm, k, scatter.repeats, scatter.freedom)
        # without repeats only conditions remain, which must then meet the family-wise level
        p_conditions = _p_value(firm, k, shrunk, scatter.freedom_conditions)
        decision = Decision(
            term=term,
            drop=drop,
            parameters=k,
            dispersion=scatter.repeats,
            dispersion_conditions=scatter.own_conditions,
            p_repeats=p_repeats if runs.repeated else max(p_repeats, p_conditions),
            p_conditions=p_conditions,
            level=FAMILY / max(looked_at, 1),
            matters=term.effect.main_parameter().matters,
            stretch_q=stretch_q,
            stretch_limit=allowed[0],
            condition_q=condition_q,
            condition_limit=allowed[1],
            interval=(term.size - spread, term.size + spread),
            held_out_gain=float("nan") if plain is None else heldout.gain(state, plain, index),
            reasons=(),
            law_error=abs(term.size) * float(np.sqrt(errors.law)),
            signals=tuple(map(float, errors.energies / max(float(errors.energies.sum()), 1e-30))),
        )
        return replace(decision, reasons=tuple(self._reasons(decision)))

    def _uneven_beside(self, fit: Fit, index: int) -> Uneven | None:
        """What the other effects of a fit may leave by their wrong form; None when nothing."""
        columns, strength = [], []
        for other, share in self.uneven:
            if other == index:
                continue
            direction = effect_contribution(fit, other)
            single = [direction * in_condition for in_condition in _conditions(self.state)]
            columns += [_stretches(self.state, direction), np.stack(single)]
            strength.append(np.full(STRETCHES + len(single), 1.0 / share))
        if not columns:
            return None
        return Uneven(np.concatenate(columns), np.concatenate(strength))

    def _visible_beside_the_bare(self, direction: np.ndarray) -> float:
        """Share of an effect that the model without it cannot imitate. Where only the effect makes
        a force (Fy by camber), the tire's parameters act on that force only in its presence."""
        fit = self.bare or self.state.whitened.fit
        own = fit.loose()
        return visible_share(self.state.sums(fit, own, direction[None]), range(len(own)), len(own))

    def _reasons(self, d: Decision) -> Iterator[str]:
        agree = d.dispersion_conditions < max(PER_FREEDOM, NEARLY * d.drop)
        first = all(o.term.effect.generic for o in self.others)
        sure = d.p_repeats < SURE and agree and first
        yield from _reasons(d, CONDITIONS_OF_SURE if sure else CONDITIONS)
        if d.drop < SHARE * d.explained_by(self.others):
            yield f"its drop is below {100 * SHARE:g} % of what is explained already"
        if d.drop < self.alike.get(d.term.effect.identifier, 0.0):
            yield "its drop does not distinguish it from a found effect"
        if not d.term.effect.separable(self.state.runs, d.term.named()):
            yield IMITATED


def _reasons(d: Decision, conditions: float) -> Iterator[str]:
    if d.drop <= 0.0 or d.p_repeats > d.level:
        yield "not beyond the scatter among repeats"
    if d.drop <= 0.0 or d.p_conditions > conditions:
        yield "not beyond the scatter among conditions"
    if abs(d.term.size) < d.matters:
        yield NEGLIGIBLE
    if d.stretch_q > d.stretch_limit:
        yield UNEVEN[0]
    if d.condition_q > d.condition_limit:
        yield UNEVEN[1]
    if d.covers_zero:
        yield "its 99 % interval covers zero"
    if at_edge(d.term):
        yield "at the end of its physical range"
    elif beyond_range(d):
        yield "its interval reaches beyond its physical range"


def at_edge(term: Term) -> bool:
    """True when the size is at an end of its physical range."""
    p = term.effect.main_parameter()
    value, width = term.named()[p.name], p.upper - p.lower
    low, high = value <= p.lower + 1e-6 * width, value >= p.upper - 1e-6 * width
    if not np.isfinite(width) or p.null == p.upper:
        return False
    return bool(high or (low and p.null != p.lower))


def beyond_range(d: Decision) -> bool:
    """True when the interval of a size contains an end of its physical range other than its null;
    a free form has no such size."""
    p, (low, high) = d.term.effect.main_parameter(), d.interval
    return not d.term.effect.generic and (high > p.upper != p.null or low < p.lower != p.null)


def _stretches(state: State, direction: np.ndarray) -> np.ndarray:
    """The effect's column split into stretches of equal information along the run."""
    runs = state.runs
    energy = np.sum(direction**2, axis=(0, 1))
    total = np.cumsum(energy) / max(float(energy.sum()), 1e-30)
    even = np.linspace(0.0, 1.0, runs.samples)
    place = np.minimum((0.5 * (total + even) * STRETCHES).astype(int), STRETCHES - 1)
    return np.stack([direction * (place == i) for i in range(STRETCHES)])


def _conditions(state: State) -> list[np.ndarray]:
    """Per condition a mask (runs, 1) of its runs."""
    runs = np.arange(state.runs.runs)
    return [np.isin(runs, rows)[:, None] for rows in state.runs.groups]


def _p_value(drop: float, k: int, kappa: float, freedom: float) -> float:
    if drop <= 0.0:
        return 1.0
    # a dispersion below one is chance: the noise is not smaller than the noise model says
    value = drop / k / max(kappa, 1.0)
    return float(f_distribution.sf(value, k, max(freedom, 1.0)))


def _drop_beside(gram: Gram, base: int) -> float:
    """Rise of chi2 without the effect, when all that stands before it in the sums adapts."""
    products, scores, _ = gram.total()
    step, inverse = solve(products[:base, :base], scores[:base])
    cross = products[:base, base]
    info = float(products[base, base] - cross @ inverse @ cross)
    score = float(scores[base] - cross @ step)
    return info * (1.0 + score / max(info, 1e-30)) ** 2


def _stretch_test(gram: Gram, base: int) -> tuple[float, int]:
    """Gain of chi2 with one size per stretch instead of one for the run, and its freedom."""
    products, scores, _ = gram.total()
    gains = []
    for rows in ([*range(base + 1)], [*range(base), *range(base + 1, base + 1 + STRETCHES)]):
        step, _ = solve(products[np.ix_(rows, rows)], scores[rows])
        gains.append(float(step @ scores[rows]))
    alive = np.diag(products)[base + 1 : base + 1 + STRETCHES] > 1e-6 * products[base, base]
    return gains[1] - gains[0], max(int(alive.sum()) - 1, 1)


def _condition_test(state: State, score, info) -> tuple[float, int]:
    """Weighted sum of squares of the size over the conditions, and its degrees of freedom."""
    h = np.array([info[g].sum() for g in state.runs.groups])
    s = np.array([score[g].sum() for g in state.runs.groups])
    alive = h > 1e-4 * h.sum()
    return float(np.sum(s[alive] ** 2 / h[alive])), max(int(alive.sum()) - 1, 1)
