# SPDX-License-Identifier: Apache-2.0
"""Rules that every answer of the search obeys, whatever the data.

The verdict, the search and the verbs call this module; the tests check the rules on every answer.

1. One more effect never raises the fitted error.
2. `found` and `found group`: the error is at the floor and no residual of consequence remains.
3. Where the base is far off in every condition, the verdict is at most `partly`.
4. A residual remains only when it is significant and of consequence.
5. Signs of columns that physics contradicts prevent any fit (`RunSet.contradicted`).
6. A parameter at an end of its range is reported.
7. Nothing is named without a fall of the error.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from flatplank_analysis.discovery import where
from flatplank_analysis.discovery.fit import Fit, Fitter, Task, Term, effect_contribution
from flatplank_analysis.discovery.model import form_error_of
from flatplank_analysis.discovery.state import State
from flatplank_data.wording import quantity, span

AT_FLOOR = 1.1
"""largest error, relative to floor and form band together, at which an effect counts as found"""
WORTH = 0.3
"""mean residual, as a share of the floor, below which it is of no consequence"""
STRETCH = 2.0
"""permitted mean residual within 5 cm [floors]"""
BUMP = 1.0
"""permitted height of a bump in the mean residual [floors]; for waves WORTH applies"""
VARYING = 0.6
"""permitted ordered difference between repeats [floors] where no effect is found"""
LEFT = 1e-3
"""p-value below which a mean residual, or an ordered difference between repeats, is significant;
strict, because it is tested often"""
FAR_FLOORS, FAR_FORCE, LOADED = 5.0, 0.1, 0.05
"""limits of a base that is far off in a condition: error in floors, error as a share of the signal
there; and the share of the largest signal below which a condition is not tested"""
TILTS = (1.0, 0.3, 0.1, 0.01)
"""weights of the other channels in fits that must not raise the error of the first one"""
EQUAL = 1e-4
"""relative difference of two errors of the first channel that is none: where fits end, and less
than is printed"""
NEAR_END = 1e-3
"""share of its range within which a parameter counts as at its end"""


@dataclass(frozen=True)
class Limits:
    """Sizes of consequence in a channel, in its unit: from a share of the floor and from the known
    form error of the model."""

    rest: float
    """mean residual"""
    stretch: float
    """mean residual within 5 cm of a place"""
    error: float
    """total error at which an effect counts as found"""
    bump: float
    """height of a bump longer than 5 cm"""
    wave: float
    """amplitude of a wave"""


def limits(state: State, channel: int = 0) -> Limits:
    """Sizes of consequence in a channel of a state."""
    runs, floor = state.runs, state.floors[channel].floor
    form = form_error_of(state.model)
    largest = runs.largest[channel]
    mean = form.share(channel) * largest
    steps = runs.input_noise[channel] if runs.input_noise else 0.0
    return Limits(
        rest=max(WORTH * floor, mean),
        stretch=float(np.hypot(STRETCH * floor, form.stretch * largest)),
        error=AT_FLOOR * float(np.sqrt(floor**2 + mean**2 + steps**2)),
        bump=float(np.hypot(BUMP * floor, form.bump * largest)),
        wave=float(np.hypot(2.0**0.5 * WORTH * floor, form.wave * largest)),
    )


def stretches(state: State) -> list[where.Event]:
    """Stretches of the first channel that neither fit of the model explains, the worst first.

    Where a tire scatters by 1 % from run to run, least squares give way in one place for forces
    that differ by chance. The whitened fit knows this scatter; what it explains is no error of the
    model.
    """
    runs, limit = state.runs, limits(state).stretch
    found = where.events(runs, state.residual[0], limit, state.expected_errors)
    if not found:
        return []
    left = where.events(runs, state.left[0], limit, state.expected_errors)
    return [event for event in found if any(event.meets(other) for other in left)]


def residual_of_consequence(state: State, found: bool) -> str:
    """The residual of consequence in words; empty when there is none.

    found: effects were found that should explain the error.
    """
    runs, main = state.runs, state.floors[0]
    names = runs.channels
    for c, (name, level) in enumerate(zip(names, state.floors, strict=True)):
        if level.unexplained > limits(state, c).rest and level.p_value < LEFT:
            left, floor = (runs.amount(v, channel=c) for v in (level.unexplained, level.floor))
            return f"{left} is left in {name} (floor {floor})"
    allowed = limits(state)
    events = stretches(state)
    if events:
        level = events[0].level
        return f"a stretch of 5 cm in {names[0]} is {level / main.floor:.1f} floors off"
    pattern = state.patterns.strongest(allowed.bump, allowed.wave)
    if pattern:
        return f"{runs.amount(abs(pattern.size))} is left in {names[0]}: {pattern.words()}"
    ordered = main.varying >= VARYING * main.floor and main.varying_p < LEFT
    if ordered and not found:
        varying = runs.amount(main.varying)
        return f"{varying} in {names[0]} differs between repeats in an ordered way"
    error = runs.rmse(state.residual[0])
    if found and error > allowed.error:
        off = runs.amount(error)
        return f"the error of {off} in {names[0]} is more than {AT_FLOOR:g} floors"
    return ""


def far_off(state: State) -> str:
    """The worst condition of a base that fits in no condition, in words; empty when it fits."""
    runs = state.runs
    level = np.sqrt([np.sum(np.mean(runs.measured[:, g] ** 2, axis=(1, 2))) for g in runs.groups])
    error = np.sqrt([np.sum(np.mean(state.residual[:, g] ** 2, axis=(1, 2))) for g in runs.groups])
    floor = float(np.sqrt(sum(f.floor**2 for f in state.floors)))
    asked = level > LOADED * level.max()
    far = (error > FAR_FLOORS * floor) & (error > FAR_FORCE * level)
    if not far[asked].all():
        return ""
    worst = int(np.argmax(np.where(asked, error / np.maximum(level, 1e-30), -1.0)))
    off, of = (runs.amount(v[worst], 0) for v in (error, level))
    return f"{off} of {of} in {runs.condition_names[worst]}"


def not_raising_error(fitter: Fitter, old: Fit, fits: Sequence[Fit]) -> Fit:
    """The best of some fits with one more term than `old` that does not raise the first channel.

    When all raise it, fits with decreasing weights of the other channels follow, from the old one
    with the term at its null and from the best one (a gap does nothing near its null); then a fit
    of only those parameters that do not affect the first channel; and last the old fit itself with
    the term at its null.
    """
    best = min(fits, key=lambda f: f.chi2)
    limit = error_of(fitter, old)
    if not is_raised(error_of(fitter, best), limit):
        return best
    terms = [*old.terms, at_null(best.terms[-1])]
    for tilt in TILTS:
        weight = fitter.weight * tilt
        weight[0] = fitter.weight[0]
        tilted = Fitter(fitter.model, weight)
        for base, start in ((old.base, terms), (best.base, best.terms)):
            fit = tilted.fit(base, start)
            if is_active(fit.terms[-1]) and not is_raised(error_of(fitter, fit), limit):
                return fit
    for start in (terms, [*old.terms, best.terms[-1]]):
        fit = _fit_only_last(fitter, old, start)
        if is_active(fit.terms[-1]) and not is_raised(error_of(fitter, fit), limit):
            return fit
    return fitter.fit(old.base, terms, iterations=0)


def _fit_only_last(fitter: Fitter, old: Fit, terms: Sequence[Term]) -> Fit:
    """The fit of only the last term and the base parameters that do not affect the first channel:
    lateral parameters leave Fx unchanged."""
    columns = zip(old.free, old.jacobian[:, 0], strict=True)
    used = {name for (term, name), column in columns if term < 0 and np.any(column)}
    model = copy(fitter.model)
    model.parameters = tuple(
        replace(p, screen=0.0) if p.name in used else p for p in model.parameters
    )
    held = [replace(t, fixed=tuple(t.named())) for t in terms[:-1]]
    fit = Fitter(model, fitter.weight).fit(old.base, [*held, terms[-1]])
    return fitter.fit(fit.base, [*terms[:-1], fit.terms[-1]], iterations=0)


def is_raised(error: float, before: float) -> bool:
    """True when an error of the first channel is larger than the one before (`EQUAL`)."""
    return error > before * (1.0 + EQUAL)


def is_no_fall(without: Sequence[np.ndarray], fit: Fit, index: int, measured: np.ndarray) -> bool:
    """True when the plain error of no channel on which effect `index` of a fit acts falls by it:
    whitened residuals may show what the error does not, and a fit may take error from one channel
    and give it to another. without: plain residuals (channels, runs, samples) of fits without the
    effect, of which each channel has its best."""
    acts = np.any(effect_contribution(fit, index), axis=(1, 2))
    before = np.min([np.mean(left[acts] ** 2, axis=(1, 2)) for left in without], axis=0)
    after = np.mean(fit.residual(measured)[acts] ** 2, axis=(1, 2))
    return not any(is_raised(b, a) for b, a in zip(np.sqrt(before), np.sqrt(after), strict=True))


def error_of(fitter: Fitter, fit: Fit) -> float:
    """Fitted error of the first channel."""
    runs = fitter.model.runs
    return runs.rmse(fit.residual(runs.measured)[0])


def at_null(term: Term) -> Term:
    """The same term at its null values."""
    nulls = {p.name: p.null for p in term.effect.linear()}
    return replace(term, values=term.effect.vector(term.named() | nulls))


def is_active(term: Term) -> bool:
    """False when all parameters of a term are at their null values."""
    return any(term.named()[p.name] != p.null for p in term.effect.linear())


def parameters_without_column(fit: Fit) -> list[str]:
    """Names of the parameters of the base that change no sample of the runs."""
    rows = zip(fit.free, fit.jacobian, strict=True)
    return [name for (term, name), column in rows if term < 0 and not np.any(column)]


def parameters_at_ends(fitter: Fitter, fit: Fit) -> dict[str, str]:
    """Parameters of a fit at an end of their range: name, and value with the range in words."""
    task = Task(fitter, fit.base, fit.terms)
    out = {}
    packed = task.pack(fit.base, fit.terms)
    for entry, z, column in zip(task.entries, packed, fit.jacobian, strict=True):
        p, value = entry.parameter, float(z) * entry.scale
        width = p.upper - p.lower
        near = NEAR_END * (width if np.isfinite(width) else entry.scale)
        if not p.at_end(value, near):
            continue
        owner = "" if entry.term < 0 else f"{fit.terms[entry.term].effect.identifier}."
        name = f"{owner}{p.name}"
        seen = float(np.sqrt(np.mean((column * fitter.weight) ** 2, axis=(1, 2)).max()))
        hardly = "" if seen > WORTH else "; these runs hardly show it"
        ends = (p.lower, p.upper)
        number = quantity(value, p.unit, 5, axis=ends)
        out[name] = f"{name} = {number} (range {span(*ends, p.unit, 5)}{hardly})"
    return out
