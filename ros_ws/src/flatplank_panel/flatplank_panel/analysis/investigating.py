# SPDX-License-Identifier: Apache-2.0
"""Jobs of an investigation for the page, one step per request: choose a batch, evaluate it.

All results are in the folder; only the last diagnosis is kept between two steps.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flatplank_analysis.discovery.view import stored
from flatplank_analysis.investigation.evidence import e_value_words
from flatplank_analysis.investigation.loop import Loop, decoy_words
from flatplank_analysis.investigation.notebook import proposal_of, summary, verdict_of
from flatplank_analysis.investigation.report import code_of, entries_of
from flatplank_control.investigate.bench import Execute, batch_name
from flatplank_control.investigate.opening import (
    NOTEBOOK,
    DiskLog,
    executor_of_made_batches,
    executor_on_twin,
    open_loop,
    save_notebook,
)
from flatplank_control.runner.steps import PlanFailed
from flatplank_data.journals import SUFFIX
from flatplank_data.progress import Progress
from flatplank_data.yaml_text import parse_yaml

SHOWN = (
    "number", "what", "reason", "runs", "minutes", "until", "answer", "back", "evidence", "error",
    "error_alone", "floor", "so_far",
)  # fmt: skip
_DIAGNOSED: dict[str, Any] = {}
"""folder -> last diagnosis; holds one folder only"""


def investigation_state(progress: Progress, folder: str) -> dict[str, Any]:
    """State of the investigation in a folder."""
    return _content(DiskLog(Path(folder)).events)


def choose_batch(progress: Progress, folder: str, minutes: float, tire: str) -> dict[str, Any]:
    """Start or continue, and choose the next batch unless one waits."""
    progress("choosing the next runs", 0.0)
    loop = _loop(folder, minutes, executor_of_made_batches(Path(folder)), tire)
    loop.begin()
    if not loop.waiting and not loop.ended:
        loop.decide()
    return _kept(loop, folder)


def measure_batch(
    progress: Progress, folder: str, minutes: float, tire: str, twin: Mapping[str, Any] | None
) -> dict[str, Any]:
    """Make the chosen batch on the twin, or read it from the runner; then diagnose again."""
    where = Path(folder)
    made: list[str] = []

    def say(text: str) -> None:
        made.append(text)
        progress(text, len(made) / max(len(loop.waiting["settings"]) if loop.waiting else 1, 1))

    if twin:
        execute = executor_on_twin(
            where, twin["preset"], twin["plant"], twin["seed"], jobs=None, say=say
        )
    else:
        execute = executor_of_made_batches(where)
    loop = _loop(folder, minutes, execute, tire)
    progress("measuring" if twin else "diagnosing", 0.0)
    try:
        loop.measure()
    except PlanFailed as error:
        raise ValueError(str(error)) from None
    return _kept(loop, folder)


def refuse_batch(progress: Progress, folder: str, minutes: float, tire: str) -> dict[str, Any]:
    """Refuse the waiting batch; ValueError when some of its runs exist already."""
    where = Path(folder)
    loop = _loop(folder, minutes, executor_of_made_batches(where), tire)
    assert loop.waiting is not None
    name = batch_name(loop.waiting["number"])
    if (where / f"{name}{SUFFIX}").exists():
        raise ValueError(f"{name} was begun: approve it, and skip the runs that you do not want")
    loop.refuse()
    return _kept(loop, folder)


def _loop(folder: str, minutes: float, execute: Execute, tire: str) -> Loop:
    loop = open_loop(Path(folder), minutes, execute, tire)
    loop.diagnosed = _DIAGNOSED.get(folder)
    return loop


def _kept(loop: Loop, folder: str) -> dict[str, Any]:
    _DIAGNOSED.clear()
    _DIAGNOSED[folder] = loop.diagnosed
    save_notebook(loop, Path(folder))
    return _content(loop.log.events)


def _content(events: list[dict[str, Any]]) -> dict[str, Any]:
    """Content of a log for the page."""
    if not events:
        return {"entries": [], "waiting": None, "ended": "", "left": None}
    log = summary(events)
    last = events[-1]
    waiting = last if last["event"] == "batch" else None
    return {
        "entries": [{k: e.get(k) for k in SHOWN} for e in entries_of(log)],
        "waiting": waiting and {k: waiting[k] for k in ("number", "what", "reason", "minutes")}
        | {"plan": waiting["plan"], "runs": len(parse_yaml(waiting["plan"])["runs"])},
        "ended": log["ended"] or "", "reason": log["reason"], "minutes": log["minutes"],
        "budget": log["budget"], "left": max(log["budget"] - log["minutes"], 0.0),
        "runs": log["runs"], "evidence": e_value_words(log["log_e"]), "limit": 1.0 / log["alpha"],
        "verdict": verdict_of(log),
        "effects": [
            {k: e[k] for k in ("text", "members")}
            for e in map(stored, (log["verdict"] or {}).get("effects", ()))
        ],
        "decoys": decoy_words(log["batches"]),
        "proposal": proposal_of(log["proposal"]) if log["proposal"] else "",
        "code": code_of(log["proposal"]), "notebook": NOTEBOOK,
    }  # fmt: skip
