# SPDX-License-Identifier: Apache-2.0
"""Work on a campaign as the verbs do it: diagnose, fit, add and remove effects."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flatplank_analysis.contact_patch import alternatives
from flatplank_analysis.contact_patch.data import from_tables, load_runs
from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.contact_patch.parameters import BASE, FORMER, NAMES
from flatplank_analysis.contact_patch.plans import plans_for, usual_step
from flatplank_analysis.contact_patch.tire_runs import TireRuns
from flatplank_analysis.discovery import heldout, invariants, screen, verdict
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.fit import Fit, Fitter, Term
from flatplank_analysis.discovery.modelfile import Entry, ModelFile
from flatplank_analysis.discovery.opening import Options
from flatplank_analysis.discovery.starts import start_of
from flatplank_analysis.discovery.state import channel_weights, make_state, start_base
from flatplank_analysis.discovery.steps import Step
from flatplank_analysis.discovery.verdict import Diagnosis
from flatplank_analysis.effects.checks import sound_library
from flatplank_analysis.effects.grammar.hooks import HOOKS, Hook
from flatplank_analysis.effects.registry import find, library
from flatplank_analysis.inference.beside import Beside
from flatplank_analysis.inference.nextrun import next_run
from flatplank_analysis.inference.search import run_search
from flatplank_analysis.inference.searched import Searched
from flatplank_analysis.pages.provenance import provenance
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError
from flatplank_data.progress import Progress
from flatplank_data.table import MeasurementTable
from flatplank_data.wording import six_digits


def base_of(model: ModelFile) -> dict[str, float]:
    """Base parameters of a model file under their names of today; FlatplankError for an unknown
    base or parameter."""
    where = model.path or "model file"
    if model.base != BASE:
        raise FlatplankError(f"no base '{model.base}'", where, f"write 'base: {BASE}'")
    named = {FORMER.get(name, name): value for name, value in model.parameters.items()}
    if unknown := [name for name in named if name not in NAMES]:
        what = f"the base has no parameter '{unknown[0]}'"
        raise FlatplankError(what, where, f"known: {', '.join(NAMES)}")
    return named


@dataclass
class Session:
    """A campaign with the base of the search and the library of effects."""

    campaign: Campaign
    data: TireRuns
    model: TireModel
    effects: dict[str, type[Effect]]
    files: tuple[str, ...] = ()

    @classmethod
    def open(
        cls,
        folder: str,
        files: Sequence[str] = (),
        mapping: Any = None,
        progress: Progress | None = None,
    ) -> Session:
        """Read a campaign; `files` are effects of the user, which must obey the contract;
        `progress` is told of each run."""
        return cls.of(Campaign.load(folder, mapping, progress), files, progress)

    @classmethod
    def of(
        cls, campaign: Campaign, files: Sequence[str] = (), progress: Progress | None = None
    ) -> Session:
        """The session of a campaign that is loaded."""
        effects = sound_library(files)
        data = load_runs(campaign, progress)
        return cls(campaign, data, TireModel(data), effects, tuple(files))

    @classmethod
    def of_tables(
        cls,
        tables: Sequence[MeasurementTable],
        effects: Mapping[str, type[Effect]] | None = None,
        files: Sequence[str] = (),
    ) -> Session:
        """The session of tables without a folder; `effects`: by default the whole library."""
        data = from_tables(list(tables))
        known = library() if effects is None else effects
        return cls(Campaign("made", []), data, TireModel(data), dict(known), tuple(files))

    def effect_of(
        self, name: str, numbers: Iterable[str], where: str, file: str = ""
    ) -> type[Effect]:
        """An effect by name; FlatplankError when it, or one of its `numbers`, does not exist."""
        effect = self.effects.get(name) or find(name, [*self.files, *([file] if file else [])])
        known = sorted(p.name for p in effect.parameters())
        for number in numbers:
            if number not in known:
                what = f"effect {name} has no parameter '{number}'"
                raise FlatplankError(what, where, f"known: {', '.join(known)}")
        return effect

    def beside(self, folder: str, mapping: Any = None) -> Session:
        """The session of other runs, with the same effects."""
        return Session.open(folder, self.files, mapping)

    @property
    def about(self) -> str:
        """Where the runs come from, for the foot of a page."""
        return provenance(self.campaign.records())

    @property
    def force(self) -> str:
        """Name of the first channel: 'Fx'."""
        return self.model.runs.channels[0].capitalize()

    @property
    def hooks(self) -> Sequence[Hook]:
        """Quantities on which a proposal may act."""
        return HOOKS

    @property
    def may_imitate(self) -> bool:
        """Whether a proposal may take the place of effects that bring the error to the floor."""
        return True

    @property
    def unfit_for_proposals(self) -> str:
        """Why nothing can be proposed, whatever is left; empty: it can."""
        return ""

    def level_settings(self) -> list[np.ndarray]:
        """What is set per run, (runs,) each: the size of the slip, the load."""
        facts = self.model.runs.facts
        return [np.abs(facts["kappa"]), facts["nominal"]]

    def start(self, model: ModelFile) -> dict[str, float]:
        """Base parameters of a model file, also those that this campaign cannot determine."""
        return base_of(model)

    def terms(self, model: ModelFile) -> tuple[Term, ...]:
        """Effects of a model file with their values; FlatplankError for an unknown one."""
        where = model.path or "model file"
        pairs = [(self.effect_of(e.name, e.parameters, where, e.file), e) for e in model.effects]
        return tuple(Term(f, f.vector(dict(e.parameters)), f.held()) for f, e in pairs)

    def searched(
        self,
        model: ModelFile | None,
        progress: Progress | None,
        measured: Mapping[str, Mapping[str, float]] | None,
    ) -> Searched:
        """The search for missing effects, from a model file on; see `diagnose`."""
        options = Options(progress=progress, measured=measured or {})
        if model is not None:
            options.start, options.terms = self.start(model), self.terms(model)
        return run_search(self.model, list(self.effects.values()), options)

    def diagnose(
        self,
        model: ModelFile | None = None,
        progress: Progress | None = None,
        measured: Mapping[str, Mapping[str, float]] | None = None,
    ) -> Diagnosis:
        """Search for missing effects; measured: effect -> parameter -> start value [SI]."""
        began = time.perf_counter()
        if verdict.undecidable(self.data.runs):
            return verdict.undecidable_diagnosis(self.data.runs, time.perf_counter() - began)
        for name, numbers in (measured or {}).items():
            self.effect_of(name, numbers, "starting values")
        search = self.searched(model, progress, measured)
        plans = plans_for(self.model) if any(f.alike for f in search.last.found) else []
        proposal = next_run(search, plans)
        result = verdict.diagnose(search, proposal)
        result = replace(result, next_run=proposal or self.fixed_proposal(result))
        return replace(result, seconds=time.perf_counter() - began)

    def fixed_proposal(self, result: Diagnosis) -> dict[str, Any]:
        """The run that separates two coordinates, when no pair of effects is confusable."""
        steps = self.data.runs.facts["step"]
        several = np.isfinite(steps).any() and np.ptp(steps[np.isfinite(steps)]) >= 0.05
        if several or result.verdict not in (verdict.NONE, verdict.PARTLY):
            return {}
        worst = list(result.events[0].conditions) if result.events else []
        step = round(usual_step(self.data.runs) + 0.7, 3)
        return {
            "what": "the conditions that show it, with a second step position, 3 x",
            "settings": {"step_position": step, "conditions": worst},
            "repeats": 3,
            "separates": [["plank position"], ["distance since the step"]],
        }

    def fit(
        self, model: ModelFile | None, extra: Sequence[Term] = (), before: Step | None = None
    ) -> Step:
        """Fit the model of a file, with floor and ranking; FlatplankError without a floor.

        before: a step without the last of the extra terms; its error must not increase, and its
        floors are the weights.
        """
        if self.model.runs.contradicted:
            raise FlatplankError("; ".join(self.model.runs.contradicted), self.campaign.path)
        why = "" if self.model.runs.repeated else verdict.undecidable(self.model.runs)
        if why:
            raise FlatplankError(why, self.campaign.path, "repeat one condition")
        effects = list(self.effects.values())
        base = start_base(self.model, self.start(model) if model else None)
        terms = [*(self.terms(model) if model else ()), *extra]
        known = None
        if before:
            floors = before.state.floors
        else:
            rough = np.std(np.diff(self.model.runs.measured, axis=-1), axis=(1, 2))
            fitter = Fitter(self.model, channel_weights(self.model, list(rough)))
            known = fitter.fit(base, terms)
            base, terms = known.base, list(known.terms)
            floors = make_state(self.model, fitter, known, effects).floors
        levels = [max(f.floor, 1e-9) for f in floors]
        fitter = Fitter(self.model, channel_weights(self.model, levels))
        fit = fitter.fit(base, terms, known=known)
        if before:
            fit = invariants.not_raising_error(fitter, before.state.fit, [fit])
        state = make_state(self.model, fitter, fit, effects)
        return Step(state, None, [])

    def add(
        self,
        model: ModelFile,
        name: str,
        before: Step | None = None,
        alike: Sequence[Term] | None = (),
    ) -> tuple[ModelFile, Step, dict[str, Any]]:
        """Add an effect to the model and refit everything.

        before: result of `fit(model)`, if available; alike: other members of its class, which the
        model file records ('A or B'); None: they are found by refits.
        """
        effect = self.effect_of(name, (), "add")
        for other in (e for e in model.effects if name in e.alike):
            raise FlatplankError(
                f"'{name}' may be what is in the model as '{other.words}'", "add",
                f"`flatplank remove {other.name}` takes it out; then add '{name}'",
            )  # fmt: skip
        if sum(e.name == name for e in model.effects) >= effect.instances:
            raise FlatplankError(
                f"'{name}' is in the model already", "add", "`flatplank remove` takes it out"
            )
        before = before or self.fit(model)
        known = screen.settings_of(before.screen, name)
        if not known:
            raise FlatplankError(
                f"'{name}' cannot show in these runs, they lack what it needs", "add",
                f"measure runs that have it: `flatplank effects {name}`",
            )  # fmt: skip
        item = known[0]
        if not np.any(item.sizes):
            item = replace(item, sizes=np.full(len(item.sizes), 0.1))
        start, _ = start_of(before.state, item)
        refitted = self.begun(self.file_of(model, before.state.fit), before)
        after = self.fit(refitted, [start], before)
        numbers = self.numbers(after) | {
            "rmse_before": six_digits(self.rmse(before)),
            "floor_before": six_digits(before.state.floors[0].floor),
        }
        beside = Beside.of(before.state, list(self.effects.values()))
        weighed = beside.fitted(after.state.whitened.fit)
        decision = beside.decide(weighed)
        gain = heldout.gain(after.state, after.state.fit, len(after.state.fit.terms) - 1)
        ends = invariants.parameters_at_ends(after.state.fitter, after.state.fit).values()
        numbers |= {
            "size": six_digits(decision.term.size),
            "unit": effect.main_parameter().unit,
            "interval": [six_digits(v) for v in decision.interval],
            "held_out_gain": six_digits(gain),
            "probability": six_digits(decision.probability),
            "doubts": [*decision.reasons, *(f"at an end of its range: {t}" for t in ends)],
        }
        grown = self.file_of(refitted, after.state.fit)
        if alike is None:
            alike = beside.instead_of(weighed)
        if alike:
            without = replace(grown, effects=grown.effects[:-1])
            others = [(term, self.fit(without, [term], before)) for term in alike]
            numbers["class"] = [
                alternatives.member(term, self.numbers(step), after, step) for term, step in others
            ]
            grown = grown.with_class([term.effect.identifier for term in alike])
        return grown.with_step("add", name, numbers), after, numbers

    def remove(self, model: ModelFile, name: str) -> tuple[ModelFile, Step, dict[str, Any]]:
        """Remove the last instance of an effect from the model and refit everything."""
        rows = [i for i, e in enumerate(model.effects) if e.name == name]
        if not rows:
            there = ", ".join(e.name for e in model.effects) or "none"
            raise FlatplankError(f"'{name}' is not in the model", "remove", f"there: {there}")
        kept = tuple(e for i, e in enumerate(model.effects) if i != rows[-1])
        begun = model if model.history else self.begun(model, self.fit(model))
        smaller = replace(begun, effects=kept)
        step = self.fit(smaller)
        numbers = self.numbers(step)
        made = self.file_of(smaller, step.state.fit).with_step("remove", name, numbers)
        return made, step, numbers

    def file_of(self, model: ModelFile, fit: Fit) -> ModelFile:
        """The model file with the parameters and effects of a fit."""
        names = [p.name for p in self.model.parameters]
        own = {e.name: replace(e, file=e.file or self.effects[e.name].file) for e in model.effects}
        pairs = [(t, t.effect.identifier) for t in fit.terms]
        entries = tuple(
            replace(own.get(name, Entry(name, file=t.effect.file)), parameters=t.named())
            for t, name in pairs
        )
        parameters = dict(zip(names, (float(v) for v in fit.base), strict=True))
        return replace(model, parameters=parameters, effects=entries, campaign=self.campaign.path)

    def begun(self, model: ModelFile, step: Step) -> ModelFile:
        """The model file; if it has no history, with a first line from its fit `step`."""
        return model if model.history else model.with_step("start", "", self.numbers(step))

    def rmse(self, step: Step) -> float:
        """Error of the longitudinal force [N]."""
        return self.model.runs.rmse(step.state.residual[0])

    def numbers(self, step: Step) -> dict[str, Any]:
        """Errors of a step for the history: fit, floor, unexplained and held-out [N]."""
        level = step.state.floors[0]
        return {
            "rmse": six_digits(self.rmse(step)),
            "floor": six_digits(level.floor),
            "unexplained": six_digits(level.unexplained),
            "held_out": six_digits(step.held_out),
        }
