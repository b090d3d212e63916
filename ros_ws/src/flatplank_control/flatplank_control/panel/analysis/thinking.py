# SPDX-License-Identifier: Apache-2.0
"""The loop of discovery for the page: compare, diagnose, add, remove, report."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from flatplank_analysis.discovery import screen, verdict, where
from flatplank_analysis.discovery.fit import amplitude
from flatplank_analysis.discovery.modelfile import ModelFile, load_model, save_model
from flatplank_analysis.discovery.search import Step
from flatplank_analysis.errors import FlatplankError
from flatplank_analysis.tirebase.session import Session

Progress = Callable[[str, float], None]
POINTS = 250
MAPS = 4
RANKED = 12


class _Desk:
    """What lies open."""

    session: Session | None = None
    path: Path = Path()
    model: ModelFile = ModelFile()


_desk = _Desk()


def _session() -> Session:
    if _desk.session is None:
        raise FlatplankError("no campaign is open", "Discover", "open one first")
    return _desk.session


def open_(progress: Progress, folder: str, model: str = "") -> dict[str, Any]:
    """Read a campaign and its model file, `model` or model.yaml beside the runs."""
    progress("reading the runs", 0.05)
    _desk.session = Session.open(folder)
    _desk.path = Path(model) if model else Path(folder) / "model.yaml"
    _desk.model = load_model(_desk.path) if _desk.path.exists() else ModelFile()
    runs = _desk.session.data.runs
    return {
        "runs": runs.runs,
        "conditions": list(runs.condition_names),
        "undecidable": verdict.undecidable(runs),
        "problems": [str(p) for p in _desk.session.campaign.problems],
    } | _model()


def _model() -> dict[str, Any]:
    return {
        "effects": [{"name": e.name, **e.parameters} for e in _desk.model.effects],
        "history": list(_desk.model.history),
        "writable": os.access(_desk.path.parent, os.W_OK),
        "file": str(_desk.path),
    }


def compare(progress: Progress) -> dict[str, Any]:
    """The model as it is: error against floor, curves and residual maps."""
    session = _session()
    progress("fit of the model", 0.2)
    return _picture(session, session.fit(_desk.model if _desk.model.parameters else None))


def _picture(session: Session, step: Step) -> dict[str, Any]:
    runs, state = session.data.runs, step.state
    level, residual = state.floors[0], state.residual[0]
    maps = where.make_maps(runs, residual, level.floor)[:MAPS]
    return (
        session.numbers(step)
        | {
            "conditions": [
                {
                    "condition": name,
                    "runs": len(rows),
                    "rmse": level.rmse_condition[i],
                    "beyond": level.per_condition[i],
                    "floor": level.floor,
                }
                for i, (name, rows) in enumerate(
                    zip(runs.condition_names, runs.groups, strict=True)
                )
            ],
            "maps": [_map(m) for m in maps],
            "curves": _curves(session, step),
            "ranked": _ranked(step),
        }
        | _model()
    )


def _map(m: where.Map) -> dict[str, Any]:
    return {
        "coordinate": m.coordinate,
        "unit": m.unit,
        "edges": m.edges,
        "mean": m.mean,
        "place": m.place,
        "share": m.place_share,
        "p_value": m.p_value,
    }


def _curves(session: Session, step: Step) -> list[dict[str, Any]]:
    """Mean of the repeats, measured and model, by condition."""
    runs = session.data.runs
    measured, predicted = runs.mean(runs.measured[0]), runs.mean(step.state.fit.predicted[0])
    name = next((k for k, c in runs.coordinates.items() if c.local), next(iter(runs.coordinates)))
    thin = slice(None, None, max(1, runs.samples // POINTS))
    return [
        {
            "condition": label,
            "x": runs.coordinates[name].values[rows[0]][thin],
            "measured": measured[i][thin],
            "model": predicted[i][thin],
            "over": f"{name} [{runs.coordinates[name].unit}]",
        }
        for i, (label, rows) in enumerate(zip(runs.condition_names, runs.groups, strict=True))
    ]


def _ranked(step: Step) -> list[dict[str, Any]]:
    """Screened candidates: gain, before any refit."""
    out = []
    for item in screen.best_per_effect(step.screen)[:RANKED]:
        effect = item.candidate.effect
        out.append(
            {
                "name": effect.identifier,
                "title": effect.title,
                "kind": effect.kind,
                "gain": item.gain,
                "visible": item.visible,
                "what": effect.what,
                "check": effect.check,
                "removes": effect.removes,
                "coordinate": effect.coordinate,
            }
        )
    return out


def diagnose(progress: Progress) -> dict[str, Any]:
    """Search for what the model lacks."""
    session = _session()
    result = session.diagnose(_desk.model if _desk.model.parameters else None, progress)
    answer = result.to_dict()
    if result.search is None:
        return answer | {"ranked": [], "collapse": []}
    refits = {d.term.effect.identifier: d for s in result.search.steps for d in s.refits}
    ranked = _ranked(result.search.steps[0])
    for row in ranked:
        if row["name"] in refits:
            decision = refits[row["name"]]
            row |= {"gain": decision.drop, "reasons": list(decision.reasons)}
    for effect, found in zip(answer["effects"], result.found, strict=True):
        kind = found.decision.term.effect
        effect |= {"what": kind.what, "check": kind.check, "removes": kind.removes}
    collapse = [_collapse(result.search, i) for i in range(len(result.found))]
    return answer | {"ranked": ranked, "collapse": collapse}


def _collapse(search: Any, number: int) -> dict[str, Any]:
    """What is left without one effect, over the effect's own coordinate, and its prediction."""
    last, runs = search.last, search.model.runs
    state, term = last.state, last.found[number].decision.term
    part = amplitude(state.fit, len(state.fit.terms) - len(last.found) + number)[0]
    without = state.residual[0] + part
    known = runs.coordinates
    name = term.effect.coordinate if term.effect.coordinate in known else next(iter(known))
    series = []
    for i, rows in enumerate(runs.groups):
        if not np.any(np.abs(part[rows]) > 0.02 * np.abs(part).max()):
            continue
        r = rows[0]
        x = known[name].values[r]
        order = np.argsort(x, kind="stable")[:: max(1, runs.samples // POINTS)]
        series.append(
            {
                "condition": runs.condition_names[i],
                "left": np.stack([x[order], without[rows].mean(axis=0)[order]], axis=1),
                "effect": np.stack([x[order], part[r][order]], axis=1),
            }
        )
    title = f"{name} [{known[name].unit}]"
    return {"name": term.effect.identifier, "over": title, "series": series}


def add(progress: Progress, effect: str) -> dict[str, Any]:
    """Put an effect into the model and refit everything."""
    session = _session()
    progress("refit of everything", 0.3)
    changed, step, numbers = session.add(_desk.model, effect)
    return _kept(session, changed, step) | {"added": numbers}


def remove(progress: Progress, effect: str) -> dict[str, Any]:
    """Take an effect out and refit everything."""
    session = _session()
    progress("refit of everything", 0.3)
    changed, step, _ = session.remove(_desk.model, effect)
    return _kept(session, changed, step)


def _kept(session: Session, changed: ModelFile, step: Step) -> dict[str, Any]:
    _desk.model = changed
    save_model(changed, _desk.path)
    return _picture(session, step)


def report(progress: Progress, folder: str) -> dict[str, Any]:
    """The page of a diagnosis, with its figures."""
    from flatplank_analysis.discovery.report.page import write_report

    session = _session()
    model = _desk.model if _desk.model.parameters else None
    result = session.diagnose(model, progress)
    progress("figures", 0.95)
    page = write_report(result, Path(folder), session.campaign.path, _desk.model.history)
    return {"page": str(page)}
