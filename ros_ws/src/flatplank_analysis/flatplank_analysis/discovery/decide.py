# SPDX-License-Identifier: Apache-2.0
"""Is an effect real? Tests at the refit (DISCOVERY 6-8).

A whitened test alone names something false in a fifth to a third of all campaigns, because tires
and machines scatter from run to run. So the drop is divided by the dispersion of the effect's
own scores among repeats, and among conditions, and the effect must have one size everywhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import f as f_distribution

from flatplank_analysis.discovery.fit import Fit, Term
from flatplank_analysis.discovery.gram import Gram, solve
from flatplank_analysis.discovery.interval import channel_scale, relative_spread
from flatplank_analysis.discovery.state import State

FAMILY = 0.05
STRETCHES = 5
SAME = 0.015
"""share of the drop by which the size may differ along the run: true effects 0-0.005, false ones
0.3 and more"""
PRIOR = 4.0
"""degrees of freedom that the dispersion among repeats lends to that among conditions"""
SHARE = 0.003
"""a further effect must bring this share of the chi2 that is explained already"""


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
        """True when no test refused it."""
        return not self.reasons

    @property
    def p_value(self) -> float:
        """The larger of the two p-values."""
        return max(self.p_repeats, self.p_conditions)


def amplitude(fit: Fit, index: int) -> np.ndarray:
    """Response to growing the whole effect by its own size (channels, runs, samples)."""
    assert fit.jacobian is not None
    term = fit.terms[index]
    named = term.named()
    out = np.zeros_like(fit.predicted)
    scale = {p.name: _scale(p) for p in term.effect.parameters()}
    linear = {p.name: p for p in term.effect.linear()}
    for row, (owner, name) in enumerate(fit.free):
        if owner == index and name in linear:
            out += fit.jacobian[row] * ((named[name] - linear[name].null) / scale[name])
    return out


def _scale(p) -> float:
    if p.screen:
        return abs(p.screen)
    width = p.upper - p.lower
    return 0.02 * width if np.isfinite(width) else max(abs(p.null), 1.0)


def best_chi2(state: State, fit: Fit) -> float:
    """Whitened chi2 after one linear step from a plain fit."""
    gram = state.gram(fit.residual(state.runs.measured), fit.jacobian[fit.loose()])
    products, scores, energy = gram.total()
    step, _ = solve(products, scores)
    return energy - float(step @ scores)


def decide(
    state: State,
    without: float,
    fit: Fit,
    index: int,
    looked_at: int,
    explained: float = 0.0,
) -> Decision:
    """Test effect `index` of a fit against the whitened chi2 `without` it."""
    runs = state.runs
    term = fit.terms[index]
    direction = amplitude(fit, index)
    own = [i for i in fit.loose() if not _linear(fit, index, *fit.free[i])]
    columns = np.concatenate([fit.jacobian[own], direction[None], _stretches(state, direction)])
    gram = state.gram(fit.residual(runs.measured), columns)
    base = len(own)
    full = state.gram(fit.residual(runs.measured), fit.jacobian[fit.loose()])
    products, scores, energy = full.total()
    drop = without - (energy - float(solve(products, scores)[0] @ scores))
    k = len([1 for owner, _ in fit.free if owner == index])
    local, info = _scores(gram, base)
    kappa, freedom = _among_repeats(state, local, info)
    kappa_c, freedom_c = _among_conditions(state, local, info)
    p_r = _p_value(drop, k, kappa, freedom)
    # an effect that shows in two conditions leaves one degree of freedom: too few to be judged by
    # themselves, so the dispersion is drawn towards that among repeats
    drawn = (freedom_c * kappa_c + PRIOR * max(kappa, 1.0)) / (freedom_c + PRIOR)
    p_c = _p_value(drop, k, drawn, freedom_c + PRIOR)
    level = FAMILY / max(looked_at, 1)
    stretch_q, stretch_n = _stretch_test(gram, base)
    condition_q, condition_n = _condition_test(state, local, info)
    worth = 12.0 if term.effect.kind == "tire" else 6.0
    stretch_limit = worth * stretch_n + (5.0 if term.effect.local else 1.0) * SAME * drop
    condition_limit = worth * condition_n + SAME * drop
    size, spread = term.size, relative_spread(state, fit, own, direction)
    matters = term.effect.main_parameter().matters
    decision = Decision(
        term, drop, k, kappa, kappa_c, p_r, p_c, level, matters,
        stretch_q, stretch_limit, condition_q, condition_limit,
        (size - abs(size) * spread, size + abs(size) * spread),
        held_out(state, fit, [index]), (),
    )  # fmt: skip
    return _with_reasons(decision, explained)


def _with_reasons(d: Decision, explained: float) -> Decision:
    from dataclasses import replace

    reasons = []
    if d.drop <= 0.0 or d.p_repeats > d.level:
        reasons.append("not beyond the scatter among repeats")
    if d.drop <= 0.0 or d.p_conditions > max(d.level, 0.002):
        reasons.append("not beyond the scatter among conditions")
    if abs(d.term.size) < d.matters:
        reasons.append("present, negligible")
    if d.drop < SHARE * explained:
        reasons.append("brings less than 0.3 % of what is explained already")
    if d.stretch_q > d.stretch_limit:
        reasons.append("not the same size along the run")
    if d.condition_q > d.condition_limit:
        reasons.append("not the same size in every condition")
    if d.interval[0] * d.interval[1] <= 0.0 and not d.term.effect.generic:
        reasons.append("its interval covers zero")
    if _at_edge(d.term):
        reasons.append("at the end of its physical range")
    return replace(d, reasons=tuple(reasons))


def _at_edge(term: Term) -> bool:
    p = term.effect.main_parameter()
    value = term.named()[p.name]
    width = p.upper - p.lower
    return bool(
        np.isfinite(width)
        and p.null not in (p.lower, p.upper)
        and (value <= p.lower + 1e-6 * width or value >= p.upper - 1e-6 * width)
    ) or bool(np.isfinite(width) and p.null == p.lower and value >= p.upper - 1e-6 * width)


def _linear(fit: Fit, index: int, owner: int, name: str) -> bool:
    return owner == index and name in {p.name for p in fit.terms[index].effect.linear()}


def _stretches(state: State, direction: np.ndarray) -> np.ndarray:
    """The effect cut into stretches of equal information along the run."""
    runs = state.runs
    energy = np.sum(direction**2, axis=(0, 1))
    total = np.cumsum(energy) / max(float(energy.sum()), 1e-30)
    even = np.linspace(0.0, 1.0, runs.samples)
    place = np.minimum((0.5 * (total + even) * STRETCHES).astype(int), STRETCHES - 1)
    return np.stack([direction * (place == i) for i in range(STRETCHES)])


def _scores(gram: Gram, base: int) -> tuple[np.ndarray, np.ndarray]:
    """Per run: score and information of the amplitude with the base projected out."""
    products, scores, _ = gram.total()
    inverse = solve(products[:base, :base], scores[:base])[1]
    mix = inverse @ products[:base, base]
    shift = inverse @ scores[:base]
    c = gram.products
    score = gram.scores[:, base] - gram.scores[:, :base] @ mix
    score = score - (c[:, base, :base] - np.einsum("i,rij->rj", mix, c[:, :base, :base])) @ shift
    info = (
        c[:, base, base]
        - 2.0 * c[:, base, :base] @ mix
        + np.einsum("i,rij,j->r", mix, c[:, :base, :base], mix)
    )
    total = max(float(info.sum()), 1e-30)
    return score - info * float(score.sum()) / total, np.maximum(info, 0.0)


def _among_repeats(state: State, score, info) -> tuple[float, float]:
    """Dispersion of the scores among repeats over what is expected, and its freedom."""
    top = bottom = squares = 0.0
    for rows in state.runs.groups:
        k = len(rows)
        if k < 2:
            continue
        expected = float(info[rows].sum()) * (k - 1) / k
        share = info[rows] / max(float(info[rows].sum()), 1e-30)
        spread = score[rows] - share * float(score[rows].sum())
        top += float(np.sum(spread**2))
        bottom += expected
        squares += expected**2 / (k - 1)
    if bottom <= 1e-30:
        return 1.0, 1.0
    return top / bottom, max(bottom**2 / max(squares, 1e-30), 1.0)


def _among_conditions(state: State, score, info) -> tuple[float, float]:
    s = np.array([score[g].sum() for g in state.runs.groups])
    h = np.array([info[g].sum() for g in state.runs.groups])
    total = float(h.sum())
    if total <= 1e-30 or len(h) < 2:
        return 1.0, 1.0
    share = h / total
    expected = float(np.sum(h * (1.0 - share)))
    freedom = max(1.0 / float(np.sum(share**2)) - 1.0, 0.5)
    return float(np.sum(s**2)) / max(expected, 1e-30), freedom


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
    one = [*range(base), base]
    many = [*range(base), *range(base + 1, base + 1 + STRETCHES)]
    gains = []
    for rows in (one, many):
        step, _ = solve(products[np.ix_(rows, rows)], scores[rows])
        gains.append(float(step @ scores[rows]))
    alive = np.diag(products)[base + 1 :] > 1e-6 * products[base, base]
    return gains[1] - gains[0], max(int(alive.sum()) - 1, 1)


def _condition_test(state: State, score, info) -> tuple[float, int]:
    """Spread of the size over the conditions."""
    h = np.array([info[g].sum() for g in state.runs.groups])
    s = np.array([score[g].sum() for g in state.runs.groups])
    alive = h > 1e-4 * h.sum()
    return float(np.sum(s[alive] ** 2 / h[alive])), max(int(alive.sum()) - 1, 1)


def held_out(state: State, fit: Fit, indices: Sequence[int]) -> float:
    """Share of the squared error that effects remove where they were not fitted.

    The sizes come from the other conditions, the base is fitted to all (leaving out the largest
    slip would otherwise test the extrapolation of the law).
    """
    errors = held_out_errors(state, fit, indices)
    return float(1.0 - errors[1] / max(errors[0], 1e-30))


def held_out_errors(
    state: State, fit: Fit, indices: Sequence[int], channel: int | None = None
) -> tuple[float, float]:
    """Squared error in floors in the left-out conditions: without and with the effects.

    All channels count for the sizes; `channel` says which are judged.
    """
    runs = state.runs
    weight = channel_scale(state)
    rest = [i for i in fit.loose() if fit.free[i][0] not in indices]
    parts = np.stack([amplitude(fit, i) for i in indices])
    columns = np.concatenate([fit.jacobian[rest], parts]) * weight
    e = fit.residual(runs.measured) * weight
    grams = [_plain(columns[:, :, g], e[:, g]) for g in runs.groups]
    pick = slice(None) if channel is None else slice(channel, channel + 1)
    judged = [_plain(columns[:, pick][:, :, g], e[pick][:, g]) for g in runs.groups]
    total = [sum(g[i] for g in grams) for i in range(3)]
    n = len(rest)
    without = with_ = 0.0
    for (products, scores, _), seen in zip(grams, judged, strict=True):
        # sizes without this condition
        p, s = total[0].copy(), total[1].copy()
        p[n:, n:] -= products[n:, n:]
        p[n:, :n] -= products[n:, :n]
        p[:n, n:] -= products[:n, n:]
        s[n:] -= scores[n:]
        sizes = solve(p, s)[0][n:]
        for delta, bucket in ((-np.ones(len(indices)), 0), (sizes, 1)):
            right = total[1][:n] - total[0][:n, n:] @ delta
            base = solve(total[0][:n, :n], right)[0]
            x = np.concatenate([base, delta])
            value = seen[2] - 2.0 * x @ seen[1] + x @ seen[0] @ x
            if bucket:
                with_ += float(value)
            else:
                without += float(value)
    return without, with_


def _plain(columns: np.ndarray, e: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    flat = columns.reshape(len(columns), -1)
    return flat @ flat.T, flat @ e.reshape(-1), float(np.sum(e**2))
