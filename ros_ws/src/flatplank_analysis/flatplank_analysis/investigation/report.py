# SPDX-License-Identifier: Apache-2.0
"""The notebook of an investigation as a page that opens offline."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from flatplank_analysis.discovery.report.page import Book, template
from flatplank_analysis.investigation import figures
from flatplank_analysis.investigation.evidence import ALPHA, Evidence, times
from flatplank_analysis.investigation.loop import decoy_words
from flatplank_analysis.investigation.notebook import (
    bet_words,
    proposal_of,
    runs_words,
    summary,
    verdict_of,
)
from flatplank_data.files import write_atomic
from flatplank_data.wording import sized

DIAGNOSIS = "diagnosis"
"""folder of the last diagnosis beside the page"""


def write_notebook(events: Sequence[Mapping[str, Any]], folder: Path, campaign: str) -> Path:
    """Page, figures and JSON of a log into a folder; returns the page."""
    folder.mkdir(parents=True, exist_ok=True)
    told = summary(events)
    write_atomic(folder / "investigation.json", json.dumps(told, indent=1) + "\n")
    entries = list(entries_of(told))
    book = Book(folder)
    drawn = {"error": figures.error(entries), "evidence": figures.evidence(entries)}
    page = folder / "index.html"
    text = template("notebook.html.j2", Path(__file__).parent).render(
        campaign=campaign,
        told=told,
        verdict=verdict_of(told),
        entries=entries,
        svg={name: book.add(name, figure) for name, figure in drawn.items() if figure},
        effects=[
            e | {"text": sized(e["size"], e["interval"], e["unit"])}
            for e in (told["verdict"] or {}).get("effects", ())
        ],
        decoys=decoy_words(told["batches"]),
        limit=f"{1.0 / ALPHA:.0f}",
        proposal=proposal_of(told["proposal"]) if told["proposal"] else "",
        code=code_of(told["proposal"]),
        diagnosis=f"{DIAGNOSIS}/index.html"
        if (folder / DIAGNOSIS / "index.html").exists()
        else "",
    )
    write_atomic(page, text)
    return page


def entries_of(told: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Batches with the minutes at which they began and ended, and what they say in words."""
    since, first, evidence = 0.0, told["runs_before"] + 1, Evidence()
    for b in told["batches"]:
        count = len(b["settings"])
        entry = {
            **b,
            "since": since,
            "until": since + b["minutes"],
            "runs": runs_words(first, count),
            "back": [_setting(s) for s in b.get("handed_back", ()) if count],
            "evidence": "",
        }
        since, first = entry["until"], first + count
        if b.get("bet"):
            evidence = evidence.times(b["log_e"], True)
            entry["evidence"] = f"{bet_words(b)}, so far {times(evidence.log)}"
        if "answer" in b:
            entry["so_far"] = evidence.log
        yield entry


def _setting(s: Mapping[str, Any]) -> str:
    return f"slip {100 * s['kappa']:+g} %, start {s['start']}"


def code_of(proposal: Mapping[str, Any] | None) -> str:
    """The file of a proposal, when it is there."""
    path = Path((proposal or {}).get("file", ""))
    return path.read_text(encoding="utf-8") if path.is_file() else ""
