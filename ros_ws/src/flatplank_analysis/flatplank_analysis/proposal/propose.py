# SPDX-License-Identifier: Apache-2.0
"""A proposal for a campaign: diagnosis, search, effect file, and refit with the file."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery import heldout, invariants, verdict
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.fit import effect_contribution
from flatplank_analysis.discovery.modelfile import ModelFile
from flatplank_analysis.discovery.screen import screen
from flatplank_analysis.discovery.state import State, make_candidates, make_state
from flatplank_analysis.discovery.steps import Step
from flatplank_analysis.discovery.verdict import Diagnosis
from flatplank_analysis.effects.grammar.file import text_of
from flatplank_analysis.effects.grammar.modulators import BY_NAME
from flatplank_analysis.effects.grammar.sentence import Sentence, Site, effect_of
from flatplank_analysis.effects.grammar.shapes.base import LEVEL
from flatplank_analysis.inference.beside import Beside
from flatplank_analysis.inference.nextrun import EXCLUDED
from flatplank_analysis.inference.posterior import NAMED
from flatplank_analysis.proposal.curves import effect_of_curve
from flatplank_analysis.proposal.exchange import POWERS, exchange_test
from flatplank_analysis.proposal.search import Outcome, Proposer, RefittedSentence
from flatplank_analysis.proposal.sites import varying_coordinates
from flatplank_data.progress import Progress
from flatplank_data.wording import probability_words

PROPOSED, NOTHING = "proposed", "nothing to propose"
ORDERED = 0.005
"""p-value of the permutation test below which a setting orders the repeats"""
LEAST_RUNS = 2.0
"""number of runs in which a sentence must act: what only one run shows may be its scatter"""
HELD_OUT = 0.003
"""least share of the squared error in left-out conditions that a sentence must remove: a
false sentence, with nothing hidden, removed 0.0013, the smallest right one of three seeds 0.008"""


@dataclass(frozen=True)
class Proposal:
    """Result of `propose`; `to_dict` is the interface for programs."""

    verdict: str
    reason: str
    diagnosis: Diagnosis
    outcome: Outcome | None = None
    sentence: Sentence | None = None
    text: str = ""
    numbers: dict[str, Any] | None = None
    """result of the refit, as from `add`, and the error held out by level"""
    seconds: float = 0.0

    @property
    def name(self) -> str:
        return self.sentence.identifier if self.sentence else ""

    def to_dict(self) -> dict[str, Any]:
        """The JSON of `flatplank propose --json`."""
        out: dict[str, Any] = {
            "verdict": self.verdict, "reason": self.reason, "diagnosis": self.diagnosis.verdict,
            "seconds": round(self.seconds, 2),
        }  # fmt: skip
        if self.sentence is None or self.outcome is None:
            return out
        s = self.sentence
        return out | {
            "name": self.name,
            "sentence": s.words(),
            **_parts(s),
            "numbers": {k: verdict.six_digits(v) for k, v in s.numbers.items()},
            "refit": self.numbers,
            "confused_with": [
                {"sentence": t.sentence.words(), **_parts(t.sentence)}
                for t in self.outcome.confused
            ],
            "looked_at": self.outcome.looked,
            "text": self.text,
        }


def _parts(s: Sentence) -> dict[str, str]:
    site = s.site
    return {
        "hook": site.hook.name, "family": site.hook.family, "coordinate": site.coordinate.name,
        "modulator": site.modulator.name, "shape": s.shape.name,
    }  # fmt: skip


def propose(
    session: Session, model: ModelFile | None = None, progress: Progress | None = None
) -> Proposal:
    """Search for an effect outside the library."""
    began = time.perf_counter()
    result = session.diagnose(model, progress)
    made = propose_from_diagnosis(session, result, model, progress)
    return replace(made, seconds=time.perf_counter() - began)


def propose_from_diagnosis(
    session: Session,
    result: Diagnosis,
    model: ModelFile | None = None,
    progress: Progress | None = None,
) -> Proposal:
    """The proposal for a known diagnosis."""
    began = time.perf_counter()
    if result.search is None or result.verdict == verdict.UNDECIDED:
        return Proposal(NOTHING, f"not decidable: {result.reason}", result)
    if session.unfit_for_proposals:
        return Proposal(NOTHING, session.unfit_for_proposals, result)
    only = _columns(session) if result.verdict in _NAMED else None
    made = Proposal(NOTHING, f"{result.verdict}: {result.reason}", result)
    if only != []:
        made = _residual_proposal(session, result, model, only, progress)
    if made.sentence is None and result.verdict in _NAMED and session.may_imitate:
        made = _replacing_proposal(session, result, model, progress) or made
    return replace(made, seconds=time.perf_counter() - began)


def _residual_proposal(
    session: Session, result: Diagnosis, model: ModelFile | None, only: list[str] | None,
    progress: Progress | None,
) -> Proposal:  # fmt: skip
    """A proposal for the residual beside the effects that were found."""
    assert result.search is not None
    step = _cleaned(session, result.search.last)
    beside = Beside.of(step.state, list(session.effects.values()))
    proposer = Proposer(beside, session.data, only, session.hooks, progress)
    outcome = proposer.run()
    why = _refused(outcome, proposer, result)
    if why:
        return Proposal(NOTHING, why, result, outcome)
    assert outcome.best is not None
    made = _refitted_proposal(session, result, step, outcome, outcome.best, model)
    assert made.numbers is not None and made.sentence is not None
    against = reason_against(made.numbers, result.verdict in _AT_FLOOR)
    if against:
        why = f"{result.verdict}, and the best sentence fails when refitted with the tire"
        return Proposal(NOTHING, f"{why}: {made.sentence.words()} ({against})", result, outcome)
    return made


def _replacing_proposal(
    session: Session, result: Diagnosis, model: ModelFile | None, progress: Progress | None
) -> Proposal | None:
    """A proposal that fits better than all found effects together; None when there is none.

    An effect of the library may imitate one that is not in it.
    """
    search = result.search
    assert search is not None
    first = search.steps[0]
    beside = Beside.of(first.state, list(session.effects.values()))
    together = beside.fitted(search.last.state.whitened.fit)
    outcome = Proposer(beside, session.data, hooks=session.hooks, progress=progress).run()
    if outcome.best is None or outcome.best.log < together.log - EXCLUDED:
        return None
    made = _refitted_proposal(session, result, first, outcome, outcome.best, model)
    assert made.numbers is not None
    if reason_against(made.numbers):
        return None
    names = " and ".join(f.decision.term.effect.identifier for f in result.found)
    return replace(made, reason=f"{made.reason}, in place of {names}")


_NAMED = (verdict.FOUND, verdict.GROUP)
_AT_FLOOR = (verdict.AT_FLOOR, verdict.LAW, *_NAMED)
"""verdicts without a residual of consequence"""


def _columns(session: Session) -> list[str]:
    """Further columns that vary: possible causes that no effect of the library uses."""
    return [p.name for p in varying_coordinates(session.data) if p.name in session.data.further]


def _cleaned(session: Session, step: Step) -> Step:
    """The step with the influence of run order and further columns removed from its noise, where
    they order the repeats: otherwise they would hide behind the scatter that they cause."""
    data, old = session.data, step.state
    if not data.runs.repeated:
        return step
    nowhere, *known = varying_coordinates(data)
    coordinates = [p for p in known if p.span.kind == LEVEL or p.name in data.further]
    sites = [Site(h, nowhere, BY_NAME[""]) for h in session.hooks if h.steady]
    ones = np.ones((1, *data.position.shape))
    steady = [effect_of_curve(s, ones) for s in sites]
    fit = old.whitened.fit
    made = make_candidates(old.model, fit, steady, old.residual)
    responses = np.array([c.columns[0, 0] for c in made])

    def orders(u: np.ndarray) -> bool:
        p = exchange_test(data.runs, old.residual[0], responses, u.mean(axis=1))
        return p < ORDERED

    ordering = [u for u in (_centred(p.values) for p in coordinates) if orders(u)]
    if not ordering:
        return step
    courses = [effect_of_curve(s, (u**k)[None]) for s in sites for u in ordering for k in POWERS]
    state = make_state(old.model, old.fitter, old.fit, [*session.effects.values(), *courses])
    return Step(state, screen(state), step.found)


def _centred(values: np.ndarray) -> np.ndarray:
    """A coordinate scaled to -1 .. 1."""
    middle = 0.5 * (values.min() + values.max())
    return (values - middle) / max(float(np.abs(values - middle).max()), 1e-12)


def _refused(outcome: Outcome, proposer: Proposer, result: Diagnosis) -> str:
    """Reason why the search leads to no proposal; otherwise empty."""
    if outcome.best is None:
        near = next((t for t in outcome.tried), None)
        beside = (
            f"; nearest: {near.sentence.words()} ({'; '.join(near.decision.reasons)})"
            if near and near.decision.reasons else ""
        )  # fmt: skip
        return f"{result.verdict}, and no sentence of the grammar passes the tests{beside}"
    with_law_effects = result.search.with_law_effects if result.search else None
    if result.verdict != verdict.LAW or with_law_effects is None:
        return ""
    law = proposer.beside.fitted(with_law_effects.fit)
    return f"{result.verdict}: {result.reason}" if outcome.best.log <= law.log else ""


def reason_against(numbers: dict[str, Any], at_floor: bool = False) -> str:
    """Reason against a sentence from the joint refit, after it passed the search.

    at_floor: the error was at the floor, so that the sentence must remove a part of consequence.
    """
    low, high = numbers["interval"]
    if low <= 0.0 <= high:
        return "its interval covers zero"
    if numbers["probability"] < NAMED:
        return f"it may be chance, {probability_words(numbers['probability'])}"
    if numbers["acts_in_runs"] < LEAST_RUNS:
        return f"it acts in {numbers['acts_in_runs']:.1f} runs, and one run repeats nothing"
    if numbers["held_out_gain"] <= HELD_OUT:
        return "left-out conditions are no better with it"
    taken = (numbers["rmse_before"] ** 2 - numbers["rmse"] ** 2) / numbers["acts_in"]
    least = invariants.WORTH * numbers["floor_before"]
    if at_floor and taken <= least**2:
        return (
            f"it takes {max(taken, 0.0) ** 0.5:.1f} N out of the error where it acts, "
            f"{least:.1f} N count"
        )
    return ""


def _refitted_proposal(
    session: Session, result: Diagnosis, step: Step, outcome: Outcome, best: RefittedSentence,
    model: ModelFile | None,
) -> Proposal:  # fmt: skip
    """The file of the best sentence, refitted as by `add`."""
    best = replace(best, sentence=_named(best.sentence, session))
    effect = effect_of(best.sentence)
    wider = replace(session, effects={**session.effects, effect.identifier: effect})
    known = session.file_of(model or ModelFile(), step.state.fit)
    _, after, numbers = wider.add(known, effect.identifier, _with_candidate(step, effect))
    energy = effect_contribution(after.state.fit, len(after.state.fit.terms) - 1)[0] ** 2
    numbers |= {
        "held_out_level": verdict.six_digits(held_out_level(after.state, session)),
        "acts_in": verdict.six_digits(_participating(energy) / energy.size or 1.0),
        "acts_in_runs": verdict.six_digits(_participating(energy.sum(axis=1))),
    }
    if numbers["rmse"] > invariants.limits(after.state).error:
        numbers["doubts"].append("the error is not at the floor: more is left than this")
    term = after.state.fit.terms[-1]
    low, high = (float(v) for v in numbers["interval"])
    named = term.named()
    sentence = replace(
        best.sentence,
        numbers={n: named[n] for n in best.sentence.numbers},
        interval=(low, high),
        evidence=tuple(_data_sentences(session, numbers, outcome, after)),
    )
    reason = f"error of {session.force} {numbers['rmse_before']:.1f} -> {numbers['rmse']:.1f} N"
    return Proposal(PROPOSED, reason, result, outcome, sentence, text_of(sentence), numbers)


def _participating(energy: np.ndarray) -> float:
    """Number of samples, or runs, that have the energy of an effect (participation ratio): all
    where each has the same, one where a single one has it all, 0 without energy."""
    return float(energy.sum() ** 2 / max(float(np.sum(energy**2)), 1e-300))


def _with_candidate(step: Step, effect: type[Effect]) -> Step:
    """The step with the columns of the new effect, as `add` needs it."""
    old = step.state
    offered = partial(make_candidates, old.model, old.whitened.fit, [effect], old.residual)
    state = replace(old, offered=offered)
    return Step(state, replace(screen(state), typical=step.screen.typical), [])


def _named(s: Sentence, session: Session) -> Sentence:
    """The sentence with a unique name: two patches are two effects."""
    first, number = s.identifier, 1
    while s.identifier in session.effects:
        number += 1
        s = replace(s, name=f"{first}_{number}")
    return s


def _data_sentences(
    session: Session, n: dict[str, Any], outcome: Outcome, after: Step
) -> Iterator[str]:
    """Statements about the data, for the docstring of the file."""
    runs, folder = session.data.runs, Path(session.campaign.path).name
    yield f"From {runs.runs} runs of {len(runs.groups)} conditions of {folder}."
    yield (
        f"Error of {session.force} {n['rmse_before']:.1f} -> {n['rmse']:.1f} N, floor "
        f"{n['floor']:.1f} N; in left-out conditions {n['held_out']:.1f} N, in left-out levels "
        f"{n['held_out_level']:.1f} N."
    )
    others = [_short(t.sentence) for t in outcome.confused]
    assert outcome.best is not None
    alias = outcome.best.sentence.site.coordinate.alias
    if alias:
        others.append(f"the same over {' or '.join(alias)}")
    if others:
        yield f"These runs cannot tell it from: {'; '.join(others[:2])}."


def _short(s: Sentence) -> str:
    site = s.site
    over = f" over {site.coordinate.name}" if site.coordinate.name else ""
    when = f", {site.modulator.words}" if site.modulator.words else ""
    return f"{site.hook.words}{over}{when}"


def held_out_level(state: State, session: Session) -> float:
    """Error of the first channel with sizes that were fitted without a whole level of what is set
    per run, where there are several."""
    runs = state.runs
    worst = 0.0
    for values in session.level_settings():
        levels, place = np.unique(np.round(values, 6), return_inverse=True)
        if len(levels) < 2:
            continue
        names = tuple(f"{v:g}" for v in levels)
        merged = replace(runs, condition=place, condition_names=names)
        seen = SimpleNamespace(
            runs=merged, fit=state.fit, fitter=state.fitter, floors=state.floors,
            residual=state.residual,
        )  # fmt: skip
        worst = max(worst, heldout.rmse(seen))  # type: ignore[arg-type]
    return worst or heldout.rmse(state)
