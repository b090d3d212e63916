# SPDX-License-Identifier: Apache-2.0
"""The page docs/discovery-blind.md, written from a journal by one command."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from flatplank_analysis.discovery.score import QUIET, SILENT
from flatplank_control.blind.journal import code_version
from flatplank_control.blind.markdown import table
from flatplank_control.blind.points import Share, confusion, points_of, share

Points = Sequence[Mapping[str, Any]]
GROUPS = {
    "none": "nothing hidden: no effect named (target 95 %)",
    "x1": "one effect, 1 x detectable: right class first, nothing false",
    "x2": "one effect, 2 x detectable and above: the same (target 95 %)",
    "pair": "two effects: both named, nothing false (target 85 %)",
    "outside": "outside the library: said so, with place and period (target 90 %)",
}


def group_of(entry: Mapping[str, Any]) -> str:
    """Which row of the table an entry belongs to."""
    case = entry["case"]
    if case["group"] != "single":
        return case["group"]
    return "x1" if case["factor"] < 2.0 else "x2"


def page(
    entries: Sequence[Mapping[str, Any]], command: str, rivals: str = "", whole: int = 0
) -> str:
    """The whole page in Markdown; `whole`: campaigns in the list that was asked for."""
    usable = [e for e in entries if e["diagnosis"] is not None]
    hidden = sorted({"+".join(e["case"]["hidden"]) for e in entries if e["diagnosis"] is None})
    scored = [(group_of(e), e["case"]["world"], points_of(e)) for e in usable]
    points = [p for _, _, p in scored]
    codes = Counter(e["code"] for e in usable)
    parts = [
        "# Blind test of the discovery",
        f"Written by `{command}` from {len(usable)} campaigns{_part(len(entries), whole)}. "
        f"Fingerprint of the code that "
        f"diagnosed: {', '.join(f'{c} ({n} campaigns)' for c, n in codes.items())}; of the "
        f"present code: {code_version()}. Nothing on this page is typed by hand.",
        _WHAT,
        "## Scores",
        _scores(scored),
        "## Sizes and held-out error",
        _sizes(points),
        "## By effect",
        _by_effect(scored),
        "## Confusion matrix",
        "Rows: what was hidden. Columns: what was named first (in brackets a verdict, when "
        "nothing was named), with counts.",
        _matrix(points),
    ]
    if hidden:
        parts.append(
            "Not visible in the runs of its design, by the generator's own computation, and so "
            f"not asked: {', '.join(hidden)}."
        )
    if rivals:
        parts += ["## Beside what one would do today", rivals]
    return "\n\n".join(parts) + "\n"


def _part(done: int, whole: int) -> str:
    if done >= whole:
        return ""
    return (
        f" (**{done} of the {whole} of the list were looked at so far**: read the intervals in "
        "brackets; the command goes on where it stopped)"
    )


_WHAT = """Campaigns are made by two generators that share no formula with the models: the bristle
plant of the simulated bench (without bus and hub), and a second tire of cells that are carried
through the patch (other pressure, other friction curve, other machine). Answers are kept apart;
what diagnoses sees the tables of the runs only. The *detectable size* of an effect is computed by
the generator from its own noise (80 % power at a family-wise level of 5 % over 100 columns, a
perfect fit of its own tire and any symmetric force law allowed), and is at least 1.5 times the
size that is of no consequence.
The two of a pair have three times their detectable size each.
Nulls have no scatter or 3 % scatter of the tire from run to run, and four colours of noise.
Intervals in brackets are Wilson's, 95 %. An extra `tire_law` is not counted as a false effect: it
says that the force law is of another form, not that the machine has a fault. Where an effect of
the same class is named in another unit than what was hidden, its size is not judged."""


def _scores(scored: Sequence[tuple[str, str, Mapping[str, Any]]]) -> str:
    rows = []
    worlds = sorted({w for _, w, _ in scored})
    for key, text in GROUPS.items():
        own = [(w, p) for g, w, p in scored if g == key]
        cells = [str(share(p["right"] for _, p in own))]
        cells += [str(share(p["right"] for w, p in own if w == world)) for world in worlds]
        rows.append([text, *cells])
    singles = [p for g, _, p in scored if g in ("x1", "x2")]
    strong = [p for g, _, p in scored if g == "x2"]
    rows.append(
        [
            "2 x and above: named first, whatever follows",
            str(share(p["first_right"] for p in strong)),
            *[""] * len(worlds),
        ]
    )
    rows.append(
        [
            "one effect: something false named beside or instead",
            str(share(p["false"] > 0 for p in singles)),
            *[""] * len(worlds),
        ]
    )
    outside = [p for g, _, p in scored if g == "outside"]
    rows.append(
        [
            "outside the library: `none of these` or `partly`, place aside",
            str(share(p["verdict"] in SILENT for p in outside)),
            *[""] * len(worlds),
        ]
    )
    nothing = [p for g, _, p in scored if g == "none"]
    rows.append(
        [
            "nothing hidden: verdict `at floor` or `tire law only`",
            str(share(p["verdict"] in QUIET for p in nothing)),
            *[""] * len(worlds),
        ]
    )
    return table(["what", "both", *worlds], rows)


def _sizes(points: Points) -> str:
    covered = share(c for p in points for c in p["covered"])
    errors = np.abs([e for p in points for e in p["errors"]])
    held = np.array([p["held_out"] for p in points if p["held_out"] is not None])
    rows = [["90 % intervals that cover the truth (target 85 .. 95 %)", str(covered)]]
    if len(errors):
        rows.append(["median error of the size", f"{np.median(errors):.1%}"])
        rows.append(["sizes within 15 %", str(share(errors < 0.15))])
    if len(held):
        rows.append(["held-out error over floor, median", f"{np.median(held):.2f}"])
        rows.append(["held-out error at most 1.1 floors", str(share(held <= 1.1))])
    return table(["what", "value"], rows)


def _by_effect(scored) -> str:
    singles = [(g, p) for g, _, p in scored if g in ("x1", "x2")]
    rows = []
    for truth in sorted({p["truth"] for _, p in singles}):
        cells = []
        for key in ("x1", "x2"):
            own = [p for g, p in singles if g == key and p["truth"] == truth]
            cells.append(f"{sum(p['right'] for p in own)}/{len(own)}" if own else "-")
        rows.append([truth, *cells])
    return table(["hidden", "right at 1 x", "right at 2 x and above"], rows)


def _matrix(points: Points) -> str:
    verdicts = {*QUIET, *SILENT, "not decidable"}
    rows = []
    for truth, row in sorted(confusion(points).items()):
        ordered = sorted(row.items(), key=lambda item: -item[1])
        cells = [f"({n}) {c}" if n in verdicts else f"{n} {c}" for n, c in ordered]
        rows.append([truth, str(sum(row.values())), ", ".join(cells)])
    return table(["hidden", "campaigns", "named first"], rows)


def summary(entries: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """The scores for programs."""
    usable = [e for e in entries if e["diagnosis"] is not None]
    out: dict[str, Any] = {}
    for key in GROUPS:
        s: Share = share(points_of(e)["right"] for e in usable if group_of(e) == key)
        low, high = s.interval()
        out[key] = {
            "hits": s.hits,
            "trials": s.trials,
            "interval": None if math.isnan(low) else [round(low, 4), round(high, 4)],
        }
    return out
