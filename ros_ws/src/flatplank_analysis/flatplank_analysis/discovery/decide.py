# SPDX-License-Identifier: Apache-2.0
"""Is an effect real? Tests at the refit; see `heldout` for left-out conditions.

A whitened test alone names something false in a fifth to a third of all campaigns, because tires
and machines scatter from run to run. So the drop is divided by the dispersion of the effect's
own scores among repeats, and among conditions, and the effect must have one size everywhere.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.stats import f as f_distribution
from scipy.stats import t as student

from flatplank_analysis.discovery import heldout
from flatplank_analysis.discovery.dispersion import (
    Usual,
    among_conditions,
    among_repeats,
    scores_of,
)
from flatplank_analysis.discovery.fit import Fit, Term, Whitened, amplitude
from flatplank_analysis.discovery.gram import Gram, solve
from flatplank_analysis.discovery.state import State

FAMILY = 0.05
FORM = 0.03
"""what the form of the model's law may be wrong by, relative to the whole of an effect"""
FAINT = 0.05
"""visible share of an effect below which it is asked whether the law could imitate it by itself"""
LAW = 0.005
"""standard deviation of the model's law in a condition, relative to the force: no repeat shows it,
and an effect that is a share of the force is known no better"""
STRETCHES = 5
SAME = 0.015
"""share of the drop by which the size may differ along the run: true effects 0-0.005, false ones
0.3 and more"""
OTHER = 0.4
"""share of the drop by which it may differ where a fault has another form than the effect, and
nothing that counts is left beside it"""
NEARLY = 0.15
"""the same where something is left: half of what impostors have at least"""
PRIOR = 4.0
"""degrees of freedom at least that the dispersion among repeats lends to that among conditions"""
CONDITIONS = 0.0005
"""p-value needed among conditions, of which there are few: what the form of the law, or that of an
effect that was accepted, leaves over differs between conditions, too"""
SHARE = 0.003
"""a further effect must bring this share of the chi2 that is explained already"""


UNEVEN = ("not the same size along the run", "not the same size in every condition")
"""what is said of an impostor, and of a fault that has another form than the effect"""


@dataclass(frozen=True)
class Decision:
    """Outcome of all tests of one effect in one refit."""

    term: Term
    drop: float
    """drop of the whitened chi2 by the effect"""
    parameters: int
    dispersion: float
    """kappa among repeats"""
    dispersion_conditions: float
    p_repeats: float
    p_conditions: float
    level: float
    """p-value needed: family-wise 5 % over all columns that were looked at"""
    matters: float
    """size that matters"""
    stretch_q: float
    stretch_limit: float
    condition_q: float
    condition_limit: float
    interval: tuple[float, float]
    """90 % interval of the size"""
    held_out_gain: float
    """share of the squared error in left-out conditions that the effect removes"""
    reasons: tuple[str, ...]
    """why it was refused; empty when accepted"""

    @property
    def accepted(self) -> bool:
        return not self.reasons

    @property
    def unevenness(self) -> float:
        """Share of the drop by which the size differs along the run or between conditions."""
        return max(self.stretch_q, self.condition_q) / max(self.drop, 1e-30)

    @property
    def misshapen(self) -> bool:
        """True when only its form is wrong, and that by no more than it may be."""
        uneven = bool(self.reasons) and set(self.reasons) <= set(UNEVEN)
        return uneven and not self.term.effect.generic and self.unevenness < OTHER

    @property
    def residue(self) -> float:
        """Of its drop, what a fault of another form leaves for others to imitate."""
        return self.unevenness * self.drop if self.misshapen else 0.0

    @property
    def p_value(self) -> float:
        return max(self.p_repeats, self.p_conditions)


@dataclass(frozen=True)
class Judge:
    """What the tests of all effects that may be added to a state have in common."""

    state: State
    without: float
    """smallest whitened chi2 without the effect"""
    usual: Usual
    explained: float = 0.0
    """drop of the effects that were accepted before"""
    residue: float = 0.0
    """what the form of these leaves"""
    bare: Fit | None = None
    """whitened fit without the effect, where it is not that of the state"""
    alike: Mapping[str, float] = field(default_factory=dict)
    """drop that is no evidence between an effect that was found and one that looks like it"""

    def decide(
        self, found: Whitened, index: int, looked_at: int, plain: Fit | None = None
    ) -> Decision:
        """Test effect `index` of a whitened fit.

        looked_at: columns that were looked at to find it; plain: the plain fit with the effect,
        for the held-out gain.
        """
        fit, state = found.fit, self.state
        term, runs = fit.terms[index], state.runs
        drop = self.without - found.chi2
        direction = amplitude(fit, index)
        linear = {(index, p.name) for p in term.effect.linear()}
        own = [i for i in fit.loose() if fit.free[i] not in linear]
        pieces = _stretches(state, direction)
        columns = np.concatenate([fit.jacobian[own], direction[None], pieces, fit.predicted[None]])
        gram = state.gram(fit.residual(state.runs.measured), columns)
        base = len(own)
        k = len([1 for owner, _ in fit.free if owner == index])
        local, info = scores_of(gram, base)
        kappa, freedom = self.usual.draw(*among_repeats(runs.comparable, local, info))
        kappa_c, freedom_c = among_conditions(runs.groups, local, info)
        # an effect that shows in two conditions leaves one degree of freedom: too few to be
        # judged by themselves, so the dispersion is drawn towards that among repeats
        lent = max(PRIOR, self.usual.freedom)
        drawn = (freedom_c * kappa_c + lent * kappa) / (freedom_c + lent)
        drawn += _of_the_law(state, gram, base) / max(float(info.sum()), 1e-30)
        stretch_q, stretch_n = _stretch_test(gram, base)
        condition_q, condition_n = _condition_test(state, local, info)
        worth = 12.0 if term.effect.kind == "tire" else 6.0
        wide = 5.0 if term.effect.local else 1.0
        # the form of the law is not that of the tire: that is no noise, no repeat shows it, and
        # the less of an effect is visible beside the law, the more of its size it can imitate
        beside = [row for row, i in enumerate(own) if fit.free[i][0] != index]
        visible = _visible(gram, beside, base)
        if visible < FAINT:
            visible = max(visible, self._visible_beside_the_bare(direction))
        form = FORM**2 / max(visible, 1e-9)
        variance = max(kappa, drawn) / max(float(info.sum()), 1e-30) + form
        allowed = worth * stretch_n + wide * SAME * drop, worth * condition_n + SAME * drop
        if stretch_q > allowed[0] or condition_q > allowed[1]:
            # a fault of another form has no size but that of some stretch or condition
            variance += max(stretch_q, condition_q) / max(drop, 1e-30) / (STRETCHES - 1)
        spread = abs(term.size) * float(student.ppf(0.95, freedom)) * np.sqrt(variance)
        p_repeats = _p_value(drop, k, kappa, freedom)
        # without repeats the conditions are all there is, and pay for the looking, too
        p_conditions = _p_value(drop, k, drawn, freedom_c + lent)
        decision = Decision(
            term=term,
            drop=drop,
            parameters=k,
            dispersion=kappa,
            dispersion_conditions=kappa_c,
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
        )
        return replace(decision, reasons=tuple(self._reasons(decision)))

    def _visible_beside_the_bare(self, direction: np.ndarray) -> float:
        """Share of an effect that the model without it does not make: where a force is there by
        the effect alone (Fy by camber), numbers of the tire change that force and nothing else."""
        fit = self.bare or self.state.whitened.fit
        columns = np.concatenate([fit.jacobian[fit.loose()], direction[None]])
        gram = self.state.gram(fit.residual(self.state.runs.measured), columns)
        return _visible(gram, range(len(columns) - 1), len(columns) - 1)

    def _reasons(self, d: Decision) -> Iterator[str]:
        yield from _reasons(d)
        if d.drop < SHARE * self.explained:
            yield "brings less than 0.3 % of what is explained already"
        if d.drop < self.residue:
            yield "brings less than the form of another effect leaves"
        if d.drop < self.alike.get(d.term.effect.identifier, 0.0):
            yield "brings less than what tells it from an effect that was found"


def _reasons(d: Decision) -> Iterator[str]:
    if d.drop <= 0.0 or d.p_repeats > d.level:
        yield "not beyond the scatter among repeats"
    if d.drop <= 0.0 or d.p_conditions > CONDITIONS:
        yield "not beyond the scatter among conditions"
    if abs(d.term.size) < d.matters:
        yield "present, negligible"
    if d.stretch_q > d.stretch_limit:
        yield UNEVEN[0]
    if d.condition_q > d.condition_limit:
        yield UNEVEN[1]
    if d.interval[0] * d.interval[1] <= 0.0 and not d.term.effect.generic:
        yield "its interval covers zero"
    if at_edge(d.term):
        yield "at the end of its physical range"


def at_edge(term: Term) -> bool:
    """True when the size stands at an end of its physical range."""
    p = term.effect.main_parameter()
    value, width = term.named()[p.name], p.upper - p.lower
    low, high = value <= p.lower + 1e-6 * width, value >= p.upper - 1e-6 * width
    if not np.isfinite(width) or p.null == p.upper:
        return False
    return bool(high or (low and p.null != p.lower))


def _visible(gram: Gram, others: Sequence[int], column: int) -> float:
    """Share of a column that the others do not make."""
    rows = [*others, column]
    part = Gram(gram.products[:, rows][:, :, rows], gram.scores[:, rows], gram.energy)
    _, info = scores_of(part, len(others))
    return float(info.sum()) / max(float(part.products[:, -1, -1].sum()), 1e-30)


def _stretches(state: State, direction: np.ndarray) -> np.ndarray:
    """The effect cut into stretches of equal information along the run."""
    runs = state.runs
    energy = np.sum(direction**2, axis=(0, 1))
    total = np.cumsum(energy) / max(float(energy.sum()), 1e-30)
    even = np.linspace(0.0, 1.0, runs.samples)
    place = np.minimum((0.5 * (total + even) * STRETCHES).astype(int), STRETCHES - 1)
    return np.stack([direction * (place == i) for i in range(STRETCHES)])


def _of_the_law(state: State, gram: Gram, base: int) -> float:
    """Variance that an unknown error of the law, of its own in every condition, gives the score.

    The last column of the sums is the force itself.
    """
    products, scores, _ = gram.total()
    mix = solve(products[:base, :base], scores[:base])[1] @ products[:base, base]
    c = gram.products
    along = c[:, -1, base] - c[:, -1, :base] @ mix
    return LAW**2 * sum(float(along[g].sum()) ** 2 for g in state.runs.groups)


def _p_value(drop: float, k: int, kappa: float, freedom: float) -> float:
    if drop <= 0.0:
        return 1.0
    # a dispersion below one is luck, not a finer noise; with many degrees of freedom the
    # noise model itself is the limit
    value = drop / k / max(kappa, 1.0)
    return float(f_distribution.sf(value, k, max(freedom, 1.0)))


def _stretch_test(gram: Gram, base: int) -> tuple[float, int]:
    """How much better five sizes along the run fit than one."""
    products, scores, _ = gram.total()
    gains = []
    for rows in ([*range(base + 1)], [*range(base), *range(base + 1, base + 1 + STRETCHES)]):
        step, _ = solve(products[np.ix_(rows, rows)], scores[rows])
        gains.append(float(step @ scores[rows]))
    alive = np.diag(products)[base + 1 : base + 1 + STRETCHES] > 1e-6 * products[base, base]
    return gains[1] - gains[0], max(int(alive.sum()) - 1, 1)


def _condition_test(state: State, score, info) -> tuple[float, int]:
    """Spread of the size over the conditions."""
    h = np.array([info[g].sum() for g in state.runs.groups])
    s = np.array([score[g].sum() for g in state.runs.groups])
    alive = h > 1e-4 * h.sum()
    return float(np.sum(s[alive] ** 2 / h[alive])), max(int(alive.sum()) - 1, 1)
