# SPDX-License-Identifier: Apache-2.0
"""The thesis's matrix, measured and laid beside its results."""

from __future__ import annotations

import argparse
import json
import os
from pathlib import Path

from flatplank_analysis.pages.book import Book
from flatplank_data.arguments import Parser, add_json
from flatplank_validation.thesis.chapters import CHAPTERS
from flatplank_validation.thesis.lab import Lab
from flatplank_validation.thesis.page import PAGE, TABLE, show, write


def parser() -> argparse.ArgumentParser:
    p = Parser(prog="flatplank thesis", description=__doc__)
    p.add_argument(
        "--chapter", action="append", metavar="N", help=f"only this one: {', '.join(CHAPTERS)}"
    )
    p.add_argument("--out", type=Path, default=Path("thesis"), help="folder of page and runs")
    p.add_argument("--jobs", type=int, help="processes; default: all cores")
    add_json(p)
    return p


def main(argv: list[str]) -> int:
    """Exit code 0: the page is written and every difference has its reason; 1: one has none."""
    o = parser().parse_args(argv)
    wanted = o.chapter or list(CHAPTERS)
    for key in wanted:
        if key not in CHAPTERS:
            raise ValueError(f"--chapter {key}: the results are in {', '.join(CHAPTERS)}")
    o.out.mkdir(parents=True, exist_ok=True)
    lab = Lab(o.out.resolve() / "runs", o.jobs or os.cpu_count() or 1)
    book = Book(o.out, "figures")
    shown = {key: (CHAPTERS[key], show(CHAPTERS[key], lab, book)) for key in wanted}
    data = write(shown, o.out)
    if o.json:
        print(json.dumps(data, indent=1))
    else:
        print("; ".join(f"{n} {name}" for name, n in data["counts"].items()))
        print(o.out / PAGE)
        print(o.out / TABLE)
    return 1 if data["counts"]["without a reason"] else 0
