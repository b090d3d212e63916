# SPDX-License-Identifier: Apache-2.0
"""The notebook of an investigation as a page that opens offline, with figures over the minutes."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from flatplank_analysis.discovery.report.figures import BLUE, GREY, ORANGE, clean, figure_of
from flatplank_analysis.discovery.view import stored
from flatplank_analysis.investigation.evidence import ALPHA
from flatplank_analysis.investigation.loop import decoy_words
from flatplank_analysis.investigation.notebook import entries_of, proposal_of, summary, verdict_of
from flatplank_analysis.pages.book import Book, write_page
from flatplank_data.files import write_atomic

DIAGNOSIS = "diagnosis"
"""folder of the last diagnosis beside the page"""
LEAST_LOG, MOST_LOG = -6.0, 30.0
"""range of decimal logarithms in the figure; values beyond are drawn at the edge"""


def write_notebook(
    events: Sequence[Mapping[str, Any]], folder: Path, campaign: str, about: str = ""
) -> Path:
    """Write page, figures and JSON of a log into a folder; return the page. about: where the runs
    come from."""
    folder.mkdir(parents=True, exist_ok=True)
    content = summary(events)
    write_atomic(folder / "investigation.json", json.dumps(content, indent=1) + "\n")
    entries = list(entries_of(content))
    book = Book(folder)
    drawn = {"error": error_figure(entries), "evidence": evidence_figure(entries)}
    return write_page(
        folder / "index.html",
        "notebook.html.j2",
        Path(__file__).parent,
        campaign=campaign,
        about=about,
        content=content,
        verdict=verdict_of(content),
        entries=entries,
        svg={name: book.add(name, figure) for name, figure in drawn.items() if figure},
        effects=[stored(e) for e in (content["verdict"] or {}).get("effects", ())],
        decoys=decoy_words(content["batches"]),
        limit=f"{1.0 / ALPHA:.0f}",
        proposal=proposal_of(content["proposal"]) if content["proposal"] else "",
        code=code_of(content["proposal"]),
        diagnosis=f"{DIAGNOSIS}/index.html"
        if (folder / DIAGNOSIS / "index.html").exists()
        else "",
    )


def code_of(proposal: Mapping[str, Any] | None) -> str:
    """The file of a proposal, if it exists."""
    path = Path((proposal or {}).get("file", ""))
    return path.read_text(encoding="utf-8") if path.is_file() else ""


def error_figure(entries: Sequence[Mapping[str, Any]]) -> Figure | None:
    """Error of the model with the found effects, and floor, after every batch."""
    measured = [e for e in entries if e.get("error") is not None]
    if not measured:
        return None
    minutes = [e["until"] for e in measured]
    figure = figure_of(8.0, 2.9)
    axes = figure.add_subplot()
    axes.plot(minutes, [e["error_alone"] for e in measured], "^:", color=GREY, label="tire alone")
    axes.plot(
        minutes, [e["error"] for e in measured], "o-", color=BLUE, label="with what was found"
    )
    axes.plot(minutes, [e["floor"] for e in measured], "s--", color=ORANGE, label="floor: repeats")
    for e in measured:
        axes.annotate(
            str(e["number"]), (e["until"], e["error"]), xytext=(0, 6),
            textcoords="offset points", fontsize=8, ha="center", color=GREY,
        )  # fmt: skip
    axes.set_ylim(
        bottom=0.0,
        top=1.15 * max(max(e[k] for k in ("error", "error_alone", "floor")) for e in measured),
    )
    return _over_minutes(figure, axes, entries, "RMSE of Fx [N]")


def evidence_figure(entries: Sequence[Mapping[str, Any]]) -> Figure | None:
    """The e-value of the investigation after every batch, with the limit for a claim."""
    measured = [e for e in entries if e.get("so_far") is not None]
    if not measured:
        return None
    minutes = [0.0, *(e["until"] for e in measured)]
    logs = np.array([0.0, *(e["so_far"] for e in measured)]) / np.log(10.0)
    figure = figure_of(8.0, 2.9)
    axes = figure.add_subplot()
    axes.step(minutes, np.clip(logs, LEAST_LOG, MOST_LOG), where="post", color=BLUE)
    axes.plot(minutes, np.clip(logs, LEAST_LOG, MOST_LOG), "o", color=BLUE, label="e-value")
    axes.axhline(-np.log10(ALPHA), color=ORANGE, lw=1.5, ls="--",
                 label=f"{1.0 / ALPHA:.0f}: confirmed")  # fmt: skip
    low, high = min(-1.0, float(logs.min())), max(2.0, float(logs.max()))
    axes.set_ylim(max(low, LEAST_LOG) - 0.3, 1.1 * min(high, MOST_LOG))
    axes.yaxis.get_major_locator().set_params(integer=True)
    axes.yaxis.set_major_formatter(lambda value, _: f"$10^{{{value:.0f}}}$")
    return _over_minutes(figure, axes, entries, "e-value")


def _over_minutes(figure: Figure, axes, entries: Sequence[Mapping[str, Any]], what: str) -> Figure:
    """Minutes as x axis, with a band for every second batch."""
    for e in entries[1::2]:
        axes.axvspan(e["since"], e["until"], color="#edf2f7", zorder=0)
    axes.set_xlim(0.0, 1.03 * max(*(e["until"] for e in entries), 1.0))
    axes.set_xlabel("minutes of the bench", fontsize=9)
    axes.set_ylabel(what, fontsize=9)
    figure.legend(fontsize=8, frameon=False, ncols=3, loc="outside upper center")
    clean(axes)
    return figure
