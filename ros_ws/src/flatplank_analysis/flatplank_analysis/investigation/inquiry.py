# SPDX-License-Identifier: Apache-2.0
"""Open questions of a diagnosis, each with the expected answer of a run.

Rivals are refitted in the place of the effect, and the tire's parameters are free in both models,
so that only differences count that neither can imitate.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from flatplank_analysis.contact_patch.plans import planned
from flatplank_analysis.discovery import verdict
from flatplank_analysis.discovery.decision import Decision
from flatplank_analysis.discovery.fit import Term
from flatplank_analysis.discovery.model import Model, ParameterSet
from flatplank_analysis.discovery.screen import VISIBLE, best_per_effect
from flatplank_analysis.discovery.verdict import Diagnosis
from flatplank_analysis.inference.contrast import Contrast, Part
from flatplank_analysis.inference.nextrun import EXCLUDED, Pair
from flatplank_analysis.inference.searched import Searched
from flatplank_analysis.investigation.evidence import (
    ALPHA,
    Evidence,
    likeliest_refused,
    tire_is_determined_at,
)
from flatplank_analysis.investigation.planner import Question
from flatplank_analysis.investigation.settings import SLIPS, Setting

TOLD_APART = 6.0
"""log likelihood ratio at which an effect is real, or a place is distinguished from another"""
SEEN = TOLD_APART
"""log likelihood ratio at which an effect of the size that matters would have been detected"""
FEW_CONDITIONS = 4
"""number of conditions below which no effect is said to be absent"""
OTHER_SIDE = 0.25
"""weight of a slip on the side without a residual, relative to the other side"""
SHOWN = 0.5
"""weight of a slip from which its side has the residual, too"""
ANOTHER_STEP = 0.3
"""[m] least distance between two different step positions"""
Side = Callable[[float], float]
"""weight of a slip by its side"""
Gain = Callable[[tuple[Setting, ...]], float]
"""expected increase of a log likelihood ratio by runs"""


@dataclass
class Predictor:
    """Model of a possible run by its setting, cached."""

    model: Model
    _known: dict[Setting, Model] = field(default_factory=dict)

    def __call__(self, setting: Setting) -> Model:
        if setting not in self._known:
            self._known[setting] = planned(self.model, "", setting.planned()).model
        return self._known[setting]


def questions(result: Diagnosis, evidence: Evidence, made: Sequence[Setting]) -> list[Question]:
    """Questions that a diagnosis leaves open."""
    search = result.search
    if not isinstance(search, Searched):
        return []
    predictor = Predictor(search.model)
    if result.found:
        out = list(_between(search, predictor))
        out += _evidence_questions(search, predictor, evidence, made)
    else:
        out = list(_suspect_question(search, predictor))
    if result.verdict in (verdict.NONE, verdict.PARTLY):
        side = _side(made, _residual_excess(search))
        out.append(_of_place(made, side))
        out += _of_levels(made, side)
    if result.verdict in (verdict.AT_FLOOR, verdict.LAW) and not out:
        out.append(_absence_question(search, predictor, len({s.shared_by_repeats for s in made})))
    return out


def _between(search: Searched, predictor: Predictor) -> Iterator[Question]:
    """One question per effect and rival: answered when the odds exclude the rival."""
    posterior = search.posterior
    for i, found in enumerate(search.last.found):
        name = found.decision.term.effect.identifier
        for rival in found.reported:
            pair = Pair(search, search.rival_set(i, rival.name), posterior.best)
            have = min(max(-math.log(rival.odds), 0.0), -EXCLUDED)
            apart = _gain(pair.contrast, predictor, 1.0 / max(posterior.dispersion, 1.0))
            yield Question(f"to separate {name} from {rival.name}", have, -EXCLUDED, apart)


def _evidence_questions(
    search: Searched, predictor: Predictor, evidence: Evidence, made: Sequence[Setting]
) -> list[Question]:
    """Runs to which no hypothesis was fitted, to refute the tire alone."""
    if evidence.enough:
        return []
    found = max(search.last.found, key=lambda f: f.decision.drop)
    name = found.decision.term.effect.identifier
    text = f"to test {name} on runs that had no part in finding it"
    whole = _gain_against_absence(search, found.decision, predictor)

    def gain(settings: tuple[Setting, ...]) -> float:
        return whole(tuple(s for s in settings if tire_is_determined_at(made, s)))

    return [Question(text, evidence.log, -math.log(ALPHA), gain)]


def _suspect_question(search: Searched, predictor: Predictor) -> Iterator[Question]:
    """An effect that is likely but not accepted yet."""
    d = likeliest_refused(search)
    if d is None:
        return
    text = f"to see whether {d.term.effect.identifier} is real ({', '.join(d.reasons)})"
    yield Question(text, 0.0, TOLD_APART, _gain_against_absence(search, d, predictor))


def _gain_against_absence(search: Searched, d: Decision, predictor: Predictor) -> Gain:
    """Of the likeliest set against the same one without an effect of it."""
    true = search.posterior.best.fit.parameter_set()
    pair = Contrast(search.scales, search.without(d), [true])
    return _gain(pair, predictor, 1.0 / max(d.dispersion, 1.0))


def _gain(pair: Contrast, predictor: Predictor, share: float = 1.0) -> Gain:
    known = _Cached(pair, predictor)

    def gain(settings: tuple[Setting, ...]) -> float:
        return share * 0.5 * float(pair.gain(*known.all_of(settings))[0])

    return gain


@dataclass
class _Cached:
    """Products of a contrast by setting."""

    contrast: Contrast
    predictor: Predictor
    known: dict[Setting, list[Part]] = field(default_factory=dict)

    def all_of(self, settings: Sequence[Setting]) -> list[Part]:
        """The products of several runs."""
        return [part for setting in settings for part in self(setting)]

    def __call__(self, setting: Setting) -> list[Part]:
        if setting not in self.known:
            self.known[setting] = self.contrast.products(self.predictor(setting))
        return self.known[setting]


def _of_place(made: Sequence[Setting], side: Side) -> Question:
    """A residual over the plank or since the step: a second step position decides, at a slip on a
    side that has the residual."""
    steps = {s.step_position for s in made if side(s.kappa) >= SHOWN}

    def another(settings: Sequence[Setting]) -> bool:
        return all(
            min(abs(s.step_position - old) for old in steps) >= ANOTHER_STEP for s in settings
        )

    have = TOLD_APART if max(steps) - min(steps) >= ANOTHER_STEP else 0.0
    largest = max(abs(s.kappa) for s in made) or 1.0

    def gain(settings: tuple[Setting, ...]) -> float:
        kappa = settings[0].kappa
        if side(kappa) < SHOWN or not another(settings):
            return 0.0
        return TOLD_APART * (0.5 + 0.5 * abs(kappa) / largest)

    return Question(
        "to separate plank position from distance since the step", have, 0.5 * TOLD_APART, gain
    )


def _residual_excess(search: Searched) -> np.ndarray:
    """Residual above the floor in the condition of each run [N]."""
    runs, floor = search.model.runs, search.last.state.floors[0]
    out = np.zeros(runs.runs)
    for rows, beyond in zip(runs.groups, floor.per_condition, strict=True):
        out[rows] = beyond
    return out


def _side(made: Sequence[Setting], left: Sequence[float]) -> Side:
    """Weight of a slip: 1 on the side (driving or braking) with the largest residual, and where
    no side has one; less on the other; left (runs,): the residual of each run [N]."""
    sides = {}
    for sign in (1.0, -1.0):
        own = [v * v for s, v in zip(made, left, strict=True) if s.kappa * sign > 0.0]
        if own:
            sides[sign] = float(np.mean(own))
    largest = max(sides.values(), default=0.0)

    def side(kappa: float) -> float:
        own = [v / largest for sign, v in sides.items() if largest and kappa * sign >= 0.0]
        return OTHER_SIDE + (1.0 - OTHER_SIDE) * min(own, default=1.0)

    return side


def _of_levels(made: Sequence[Setting], side: Side) -> Iterator[Question]:
    """The residual at slips that were not measured; the value of a slip is its distance from the
    others, small slips counting like large ones, and larger on the side with the residual."""
    there = {s.kappa for s in made}
    if there.issuperset(SLIPS):
        return

    def away(kappa: float) -> float:
        place = math.asinh(kappa / SLIPS[1])
        return side(kappa) * min(abs(place - math.asinh(k / SLIPS[1])) for k in there)

    most = max(away(k) for k in SLIPS)

    def gain(settings: tuple[Setting, ...]) -> float:
        return TOLD_APART * away(settings[0].kappa) / most

    yield Question(
        "to see at another slip what no effect explains", 0.5 * TOLD_APART, TOLD_APART, gain
    )


def _absence_question(search: Searched, predictor: Predictor, conditions: int) -> Question:
    """Whether any effect of consequence would have been detected: the least detectable effect of
    those that the bench shows at all."""
    fit, terms = search.scales.state.whitened.fit, _effects_that_matter(search)
    own = fit.parameter_set()
    tried = [ParameterSet(own.base, (*own.effects, (t.effect, t.values))) for t in terms]
    contrast = Contrast(search.scales, fit, tried)
    known = _Cached(contrast, predictor)
    had = np.minimum(0.5 * contrast.had, SEEN)

    def gain(settings: tuple[Setting, ...]) -> float:
        each = contrast.separations(*known.all_of(settings))
        return float(np.mean(np.minimum(0.5 * each, SEEN) - had))

    have = float(np.mean(had)) if terms else SEEN
    needed = 0.9 * SEEN if conditions >= FEW_CONDITIONS else SEEN
    return Question("to see what could still be hidden", have, needed, gain)


def _effects_that_matter(search: Searched) -> list[Term]:
    """Effects that the runs show at all, at the size that matters."""
    out = []
    for item in best_per_effect(search.last.screen):
        effect = item.candidate.effect
        main = effect.main_parameter()
        linear = {p.name for p in effect.linear()}
        if item.visible < VISIBLE or effect.generic or effect.law or main.name not in linear:
            continue
        sign = -1.0 if main.null + main.matters > main.upper else 1.0
        size = main.null + sign * main.matters
        named = {**item.candidate.setting, main.name: size}
        out.append(Term(effect, effect.vector(named), effect.held()))
    return out
