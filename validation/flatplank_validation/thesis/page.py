# SPDX-License-Identifier: Apache-2.0
"""Writes the thesis beside ours: one page with its figures inside, and its comparison as CSV and
JSON."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from flatplank_analysis.figures.draw import save
from flatplank_analysis.identify.results import to_plain
from flatplank_analysis.pages.book import Book, Picture, write_page
from flatplank_analysis.pages.csv_text import csv_text
from flatplank_analysis.report.table import Table
from flatplank_analysis.report_files.build import number
from flatplank_data.errors import FlatplankError
from flatplank_data.files import write_atomic
from flatplank_validation.thesis.lab import Lab
from flatplank_validation.thesis.registry import (
    AGREES,
    DIFFERS,
    UNSHOWN,
    Chapter,
    Entry,
    Finding,
    Value,
    finding,
)

PAGE, TABLE, DATA = "thesis.html", "comparison.csv", "comparison.json"
FORMAT = "flatplank-thesis/1"
HEADER = (
    "chapter", "figure or table", "quantity", "unit", "thesis", "place in the thesis", "ours",
    "difference", "tolerance", "verdict", "why",
)  # fmt: skip
NO_DATA = "nothing of ours shows it"


@dataclass(frozen=True)
class Shown:
    """An entry with what was measured for it."""

    entry: Entry
    pictures: Sequence[tuple[Picture, str]]
    """each with its caption"""
    findings: Sequence[Finding]
    table: Table | None
    missing: str
    """why there is no picture"""

    @property
    def anchor(self) -> str:
        return "e-" + self.entry.number.replace(" ", "-").replace(".", "-")


def show(chapter: Chapter, lab: Lab, book: Book) -> list[Shown]:
    """Measure and draw all entries of a chapter."""
    out = []
    for entry in chapter.entries:
        lab.say(f"{chapter.title.split(':')[0]}: {entry.number} {entry.title}")
        out.append(_show(entry, lab, book))
    return out


def _show(entry: Entry, lab: Lab, book: Book) -> Shown:
    pictures, missing, table = [], entry.absent, None
    slug = entry.number.replace(" ", "_").lower()
    try:
        for k, figure in enumerate(entry.draw(lab) if entry.draw else ()):
            named = replace(figure, name=f"{slug}{'abcdef'[k] if k else ''}_{figure.name}")
            pictures.append((save(book, named), f"{figure.title}. {figure.caption}"))
        table = entry.table(lab) if entry.table else None
    except FlatplankError as error:
        missing = str(error)
    if entry.draw and not pictures:
        missing = missing or NO_DATA
    found = [finding(entry.number, row, lab) for row in entry.rows]
    return Shown(entry, pictures, found, table, missing)


def counts(findings: Sequence[Finding]) -> dict[str, int]:
    """Rows by verdict, in a fixed order; and those without a reason."""
    found = Counter(f.verdict for f in findings)
    unexplained = sum(f.unexplained for f in findings)
    return {name: found[name] for name in (AGREES, DIFFERS, UNSHOWN)} | {
        "without a reason": unexplained
    }


def text(value: Value | None) -> str:
    """A value for people."""
    if value is None:
        return "–"
    return number(value)


def cells(chapter: Chapter, f: Finding) -> list[Any]:
    """A line of the comparison."""
    row = f.row
    ours = "" if f.ours is None else f.ours
    return [
        chapter.key, f.entry, row.quantity, row.unit, row.thesis, row.place, ours, f.difference,
        row.rule.text, f.verdict, f.why,
    ]  # fmt: skip


def write(chapters: Mapping[str, tuple[Chapter, Sequence[Shown]]], out: Path) -> dict[str, Any]:
    """Write page, CSV and JSON; returns what the JSON has."""
    lines = [
        cells(chapter, f)
        for chapter, shown in chapters.values()
        for one in shown
        for f in one.findings
    ]
    findings = [f for _, shown in chapters.values() for one in shown for f in one.findings]
    count = counts(findings)
    data = {
        "format": FORMAT,
        "page": str(out / PAGE),
        "counts": count,
        "rows": [dict(zip(HEADER, map(to_plain, line), strict=True)) for line in lines],
        "missing": {
            one.entry.number: one.missing
            for _, shown in chapters.values()
            for one in shown
            if one.missing
        },
    }
    write_atomic(out / TABLE, csv_text([HEADER, *lines]))
    write_atomic(out / DATA, json.dumps(data, indent=1))
    write_page(
        out / PAGE,
        "thesis.html.j2",
        Path(__file__).parent,
        parts=[(f"c-{chapter.key}", chapter.title) for chapter, _ in chapters.values()]
        + [("all", "All rows")],
        chapters=list(chapters.values()),
        count=count,
        text=text,
        number=number,
        total=sum(n for name, n in count.items() if name != "without a reason"),
        agrees=AGREES,
        differs=DIFFERS,
    )
    return data
