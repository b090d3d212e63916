# SPDX-License-Identifier: Apache-2.0
"""Jobs of the page Discover: simulate, compare, diagnose, add, undo, report."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import asdict
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from flatplank_analysis.contact_patch.comparison import errors
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery import screen, verdict, where
from flatplank_analysis.discovery.fit import Term
from flatplank_analysis.discovery.modelfile import ModelFile, load_model, save_unchanged
from flatplank_analysis.discovery.report.collapse import collapse_of
from flatplank_analysis.discovery.state import term_of
from flatplank_analysis.discovery.steps import Step
from flatplank_analysis.discovery.verdict import Diagnosis
from flatplank_analysis.discovery.view import Member
from flatplank_analysis.effects import consent
from flatplank_control.bench.simulator import simulator
from flatplank_data.errors import FlatplankError
from flatplank_data.folders import Stamp, stamp_of
from flatplank_data.progress import Progress
from flatplank_data.run_record import RunRecord
from flatplank_data.wording import axis_of

POINTS = 250
"""points of a drawn curve"""
MAPS = 4
"""number of residual maps"""
RANKED = 12
"""number of ranked effects"""
CONSTANT = ("fz", "pressure", "alpha_deg", "gamma_deg")
"""settings that may be constant in a campaign"""


class _Open(NamedTuple):
    """Campaign and model of one request; only read data is kept between requests."""

    session: Session
    path: Path
    """path of the model file"""
    model: ModelFile
    diagnoses: dict[str, Diagnosis]
    """state of a model -> its diagnosis, of this campaign; the last one is kept"""

    @property
    def start(self) -> ModelFile | None:
        """Start model; None: that of the library."""
        return self.model if self.model.parameters else None


@lru_cache(maxsize=2)
def _read(
    _folder: str, _stamp: Stamp, _files: tuple[str, ...]
) -> tuple[list[Session], dict[str, Diagnosis]]:
    """Room for the session of a campaign, and for its diagnoses."""
    return [], {}


def _opened(progress: Progress, folder: str, model: str) -> _Open:
    """Campaign and model as they are now on disk."""
    path = Path(model)
    file = load_model(path) if path.exists() else ModelFile()
    own = tuple(e.file for e in file.effects if e.file)
    read, diagnoses = _read(folder, stamp_of(folder), own)
    if not read:
        read.append(Session.open(folder, own, progress=progress))
    return _Open(read[0], path, file, diagnoses)


def open_(progress: Progress, folder: str, model: str) -> dict[str, Any]:
    """Read a campaign and its model file."""
    at = _opened(progress, folder, model)
    runs = at.session.data.runs
    return {
        "runs": runs.runs,
        "conditions": list(runs.condition_names),
        "undecidable": verdict.undecidable(runs),
        "problems": [str(p) for p in at.session.campaign.problems],
    } | _model(at)


def allow(progress: Progress, file: str, digest: str) -> dict[str, Any]:
    """Allow an effect file to run; FlatplankError when it is not what the user has read."""
    content = consent.read(Path(file))
    if consent.digest(content) != digest:
        raise FlatplankError("was changed meanwhile", file, "open the campaign again")
    consent.allow(Path(file), content)
    return {}


def _model(at: _Open) -> dict[str, Any]:
    return {
        "effects": [{"name": e.name, "text": e.words, **e.parameters} for e in at.model.effects],
        "history": list(at.model.history),
        "writable": os.access(at.path.parent, os.W_OK),
        "file": str(at.path),
    }


def compare(progress: Progress, folder: str, model: str) -> dict[str, Any]:
    """Evaluate the present model: error against floor, curves and residual maps."""
    at = _opened(progress, folder, model)
    progress("fit of the model", 0.2)
    return _picture(at, at.session.fit(at.start))


def _picture(at: _Open, step: Step) -> dict[str, Any]:
    session = at.session
    runs, state = session.data.runs, step.state
    level, residual = state.floors[0], state.residual[0]
    maps = where.make_maps(runs, residual, level.by_condition)[:MAPS]
    return (
        errors(session, step)
        | {
            "maps": [_map(m) for m in maps],
            "curves": _curves(session, step),
            "ranked": _ranked(step),
        }
        | _model(at)
    )


def _map(m: where.Map) -> dict[str, Any]:
    return {
        "coordinate": m.coordinate,
        "unit": m.unit,
        "edges": m.edges,
        "mean": m.mean,
        "text": f"{m.words()} ({where.p_words(m.p_value)})",
    }


def _curves(session: Session, step: Step) -> list[dict[str, Any]]:
    """Mean of the repeats, measured and modelled, by condition."""
    runs = session.data.runs
    measured, predicted = runs.mean(runs.measured[0]), runs.mean(step.state.fit.predicted[0])
    name = next((k for k, c in runs.coordinates.items() if c.local), next(iter(runs.coordinates)))
    thin = slice(None, None, max(1, runs.samples // POINTS))
    place = runs.coordinates[name]
    factor, over = axis_of(name, place.unit, (place.values.min(), place.values.max()))
    return [
        {
            "condition": label,
            "x": factor * place.values[rows[0]][thin],
            "measured": measured[i][thin],
            "model": predicted[i][thin],
            "over": over,
        }
        for i, (label, rows) in enumerate(zip(runs.condition_names, runs.groups, strict=True))
    ]


def _ranked(step: Step) -> list[dict[str, Any]]:
    """Screened candidates with their gain before any refit."""
    out = []
    for item in screen.best_per_effect(step.screen)[:RANKED]:
        member = Member.of(term_of(item.candidate, item.sizes))
        row = {"name": member.name, "gain": item.gain, "visible": item.visible >= screen.VISIBLE}
        coordinate = item.candidate.effect.coordinate
        out.append(row | {"members": [asdict(member)], "coordinate": coordinate})
    return out


def _state(at: _Open) -> str:
    """The present model, as `_Open.diagnoses` has it."""
    return repr(at.start and at.start.state())


def _diagnosis(at: _Open, progress: Progress) -> Diagnosis:
    """Diagnosis of the present model."""
    state = _state(at)
    if state not in at.diagnoses:
        at.diagnoses.clear()
        at.diagnoses[state] = at.session.diagnose(at.start, progress)
    return at.diagnoses[state]


def diagnose(progress: Progress, folder: str, model: str) -> dict[str, Any]:
    """Search for what the model lacks."""
    at = _opened(progress, folder, model)
    result = _diagnosis(at, progress)
    answer = result.to_dict()
    answer["next_run"] = runs_of(at.session, result.next_run)
    if result.search is None:
        return answer | {"ranked": [], "collapse": []}
    refits = {d.term.effect.identifier: d for s in result.search.steps for d in s.refits}
    ranked = _ranked(result.search.steps[0])
    for row in ranked:
        if row["name"] in refits:
            decision = refits[row["name"]]
            row |= {"gain": decision.drop, "reasons": list(decision.reasons)}
    for effect, found in zip(answer["effects"], result.found, strict=True):
        effect["coordinate"] = found.decision.term.effect.coordinate
    collapse = [_collapse(result.search, i) for i in range(len(result.found))]
    return answer | {"ranked": ranked, "collapse": collapse}


def _collapse(search: Any, number: int) -> dict[str, Any]:
    """Residual without one effect, over the coordinate of the effect, and its prediction; of each
    condition the mean of its runs."""
    data, names = collapse_of(search, number), search.model.runs.condition_names
    factor, over = axis_of(data.coordinate, data.unit, (data.places.min(), data.places.max()))
    series = []
    for i, rows in data.groups:
        at = data.every(rows[0], POINTS)
        x = factor * data.places[rows[0]][at]
        left, effect = data.left[rows].mean(axis=0)[at], data.part[rows[0]][at]
        series.append(
            {
                "condition": names[i],
                "left": np.stack([x, left], axis=1),
                "effect": np.stack([x, effect], axis=1),
            }
        )
    return {"name": data.effect, "over": over, "series": series}


def add(progress: Progress, folder: str, model: str, effect: str) -> dict[str, Any]:
    """Put an effect into the model and refit everything."""
    at = _opened(progress, folder, model)
    progress("refit of everything", 0.3)
    changed, step, numbers = at.session.add(at.model, effect, alike=_others(at, effect))
    return _kept(at, changed, step) | {"added": numbers}


def _others(at: _Open, name: str) -> list[Term]:
    """Other members of the class of an effect, as the present model was diagnosed."""
    result = at.diagnoses.get(_state(at))
    for found in result.found if result else ():
        terms = [found.decision.term, *(r.term for r in found.reported)]
        if name in [t.effect.identifier for t in terms]:
            return [t for t in terms if t.effect.identifier != name]
    return []


def undo(progress: Progress, folder: str, model: str) -> dict[str, Any]:
    """Restore the model before the last step; `undone`: that step."""
    at = _opened(progress, folder, model)
    before, last = at.model.undone(), at.model.history[-1]
    progress("fit of the model", 0.3)
    step = at.session.fit(before)
    return _kept(at, before, step) | {"undone": f"{last['action']} {last['effect']}"}


def _kept(at: _Open, changed: ModelFile, step: Step) -> dict[str, Any]:
    save_unchanged(changed, at.path)
    return _picture(at._replace(model=changed), step)


def report(progress: Progress, folder: str, model: str, target: str) -> dict[str, Any]:
    """Write the report page of a diagnosis with its figures to the folder `target`."""
    from flatplank_analysis.discovery.report.page import write_report

    at = _opened(progress, folder, model)
    result = _diagnosis(at, progress)
    progress("figures", 0.95)
    path, about = at.session.campaign.path, at.session.about
    page = write_report(result, Path(target), path, at.model.history, about)
    return {"page": str(page)}


def runs_of(session: Session, proposal: Mapping[str, Any]) -> dict[str, Any]:
    """The proposal with `tire` and `runs`: one mapping of settings per proposed run.

    `conditions` in its settings are labels of the campaign; each becomes a separate run.
    """
    settings = dict(proposal.get("settings") or {})
    if not settings:
        return dict(proposal)
    infos = {run.info.name: run.info for run in session.campaign.runs}
    runs = session.data.runs
    known = {
        label: infos[runs.names[rows[0]]]
        for label, rows in zip(runs.condition_names, runs.groups, strict=True)
    }
    if "conditions" not in settings:
        starts = [{"start": start} for start in settings.pop("starts", [])] or [{}]
        usual = _usual(list(known.values())) | settings
        made = [usual | start for start in starts]
    else:
        labels = settings.pop("conditions")
        made = [_slip(known[label]) | settings for label in labels]
    return {**proposal, "tire": next(iter(known.values())).tire, "runs": made}


def _usual(infos: list[RunRecord]) -> dict[str, float]:
    """Median of each setting in CONSTANT over the runs."""
    values = {k: [getattr(i, k) for i in infos] for k in CONSTANT}
    return _finite({k: float(np.median(v)) for k, v in values.items()})


def _slip(info: RunRecord) -> dict[str, float]:
    return _finite({k: float(getattr(info, k)) for k in ("kappa", *CONSTANT)})


def _finite(values: Mapping[str, float]) -> dict[str, float]:
    return {k: v for k, v in values.items() if math.isfinite(v)}


def simulate(progress: Progress, folder: str, seed: int) -> dict[str, Any]:
    """Simulate nine slips from three starts in a new folder, with a sealed answer."""
    progress("simulating the first run", 0.0)
    simulator().make_challenge(
        Path(folder), seed, lambda k, n, _name: progress(f"run {k} of {n} simulated", k / n)
    )
    return {"folder": folder}
