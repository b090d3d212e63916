# SPDX-License-Identifier: Apache-2.0
"""One HTML page that opens offline, with its figures as SVG and PNG and the numbers as JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from flatplank_analysis.discovery import where
from flatplank_analysis.discovery.effect import KINDS
from flatplank_analysis.discovery.floor import BELOW
from flatplank_analysis.discovery.report import figures
from flatplank_analysis.discovery.report.collapse import collapse_of
from flatplank_analysis.discovery.report.text import channel_of
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.discovery.steps import AcceptedEffect, Search
from flatplank_analysis.discovery.verdict import Diagnosis
from flatplank_analysis.discovery.view import Cause
from flatplank_analysis.pages.book import Book, write_page
from flatplank_data.errors import FlatplankError
from flatplank_data.files import write_atomic
from flatplank_data.wording import probability_words, quantity, span

HERE = Path(__file__).parent
BEFORE_AND_AFTER = "before_and_after"
"""name of the figure of the run that gains most by what was found"""
PARTS = {
    "to-do": "What to do",
    "floor": "Error against floor",
    "where": "Where it fails",
    "what": "What it is",
    "left": "What is left",
    "down": "The error on its way down",
    "detectable": "What these runs could have shown",
}
"""parts of the page: anchor -> name"""


def write_report(
    result: Diagnosis,
    folder: Path,
    campaign: str,
    history: Sequence[Mapping[str, Any]] = (),
    about: str = "",
) -> Path:
    """Write page, figures and JSON; returns the page. about: where the runs come from."""
    search = result.drawable(campaign)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FlatplankError(
            f"cannot be made ({error.strerror})", str(folder), "choose another place"
        ) from error
    write_atomic(folder / "diagnosis.json", json.dumps(result.to_dict(), indent=1) + "\n")
    content = _content(result, search, Book(folder), history)
    tasks = result.tasks(campaign)
    parts = [(key, name) for key, name in PARTS.items() if tasks or key != "to-do"]
    page = folder / "index.html"
    named = {e.identifier: e.word() for e in search.effects}
    return write_page(page, "diagnosis.html.j2", HERE, named, campaign=campaign, about=about,
                      tasks=tasks, parts=parts, **content)  # fmt: skip


def _content(
    result: Diagnosis, search: Search, book: Book, history: Sequence[Mapping[str, Any]]
) -> dict[str, Any]:
    first = search.steps[0]
    runs = search.model.runs
    maps = where.make_maps(runs, first.state.residual[0], first.state.floors[0].by_condition)
    steps = waterfall_steps(search, history)
    svg = {
        BEFORE_AND_AFTER: book.add(BEFORE_AND_AFTER, figures.before_and_after(search))
        if result.found
        else "",
        "conditions": book.add("conditions", figures.conditions(search.steps)),
        "ranking": book.add("ranking", figures.ranking(search)),
        "residual": book.add("residual", figures.residual(search.last)),
        "waterfall": book.add("waterfall", figures.waterfall(steps, result.floor, runs)),
    }
    return dict(
        d=result,
        below=BELOW if any(c["floors"] < 1.0 for c in result.conditions) else "",
        channel=channel_of(runs),
        amount=runs.amount,
        svg=svg,
        maps=[
            {
                "svg": book.add(f"map{i}", figures.map_of(m, runs)),
                "text": f"{m.words()} ({where.p_words(m.p_value)})",
            }
            for i, m in enumerate(maps[:4])
        ],
        effects=[_effect(search, book, i, found) for i, found in enumerate(result.found)],
        refused=_refused(result, search),
        p_from=where.P_FROM,
        events=[_event(runs, e) for e in result.events[:8]],
        detectable=[(k, quantity(*v, 2)) for k, v in sorted(result.detectable.items())],
    )


def _effect(search: Search, book: Book, number: int, found: AcceptedEffect) -> dict[str, Any]:
    cause = Cause.of(found)
    runs, shown = search.model.runs, collapse_of(search, number)
    caption = (
        f"Over the {shown.coordinate}: what a model without the effect leaves (dots), and the "
        f"effect (lines). Dots and lines differ by {runs.amount(shown.off)}"
    )
    return {
        "cause": cause,
        "kind": KINDS[cause.members[0].kind],
        "probability": probability_words(found.decision.probability),
        "held_out_gain": found.decision.held_out_gain,
        "weakly": found.excluded_names,
        "svg": book.add(f"collapse{number}", figures.collapse(search, number)),
        "caption": caption,
    }


def _event(runs: RunSet, event: where.Event) -> dict[str, Any]:
    unit = runs.coordinates[event.coordinate].unit
    place = span(event.start, event.end, unit)
    return {
        "coordinate": event.coordinate, "place": place, "level": event.level,
        "conditions": event.conditions,
    }  # fmt: skip


def _refused(result: Diagnosis, search: Search) -> list[dict[str, str]]:
    taken = {m.name for c in result.causes() for m in c.members}
    out: dict[str, dict[str, str]] = {}
    for step in search.steps:
        for d in step.refits:
            name = d.term.effect.identifier
            if d.reasons and name not in taken:
                unit = d.term.effect.main_parameter().unit
                size = quantity(d.term.size, unit)
                out[name] = {"name": name, "size": size, "why": "; ".join(d.reasons)}
    return list(out.values())


def waterfall_steps(search: Search, history: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Waterfall steps (name, `rmse`, `held_out`) of a model file and of the effects found next."""
    steps = history_steps(history)
    if not steps:
        return figures.steps_of(search)
    began = [t.effect.identifier for t in search.steps[0].state.fit.terms]
    ended = [e["name"] for e in history[-1].get("effects") or ()]
    # a search that began before the file's last step found effects that are in the file already
    return steps + (figures.steps_of(search)[1:] if began == ended else [])


def history_steps(history: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Waterfall steps from the history of a model file."""
    sign = {"add": "+ ", "remove": "− "}
    return [
        {
            "name": sign.get(str(h.get("action")), "") + str(h.get("effect") or h.get("action")),
            "rmse": float(h["rmse"]),
            "held_out": h.get("held_out"),
        }
        for h in history
        if h.get("rmse") is not None
    ]
