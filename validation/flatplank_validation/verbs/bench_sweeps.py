# SPDX-License-Identifier: Apache-2.0
"""Effects hidden in forty generated series of sweeps.

The series are of a discrete brush that shares no code with the models; the base is a tire file
that was fitted to the same brush with nothing hidden.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import flatplank_analysis as fp
from flatplank_analysis.cli import common
from flatplank_data.arguments import Parser, add_json
from flatplank_data.files import write_atomic
from flatplank_validation.blind.detectable import cache
from flatplank_validation.blind.journal import code_version, commit, read
from flatplank_validation.sweep_sets.brush import BASE, Plan, sweeps, text_of
from flatplank_validation.sweep_sets.forms import forms
from flatplank_validation.sweep_sets.outside import proposal_rows, proposals
from flatplank_validation.sweep_sets.page import form_rows, page, rows_of, summary
from flatplank_validation.sweep_sets.sets import SERIES, Case, cases

CODE = ("discovery", "inference", "slip_sweeps")
"""folders of the analysis whose results are kept apart"""
MORE = 1000
"""numerical: between the seeds of two lists"""


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank bench-sweeps [--seed N] [--from N] [--count N] [--forms | --outside]
    [--write FILE]`."""
    parser = Parser(prog="flatplank bench-sweeps", description=__doc__)
    parser.add_argument("--seed", type=int, default=1, help="of the forty series (default 1)")
    parser.add_argument("--from", type=int, default=0, dest="start", help="first one (default 0)")
    parser.add_argument("--count", type=int, default=SERIES, help="number of series (default 40)")
    parser.add_argument("--forms", action="store_true", help="tires of other forms, instead")
    parser.add_argument("--outside", action="store_true",
                        help="causes of no library, for `propose`, instead")  # fmt: skip
    parser.add_argument("--journal", metavar="FILE", type=Path,
                        help="file that is gone on with; default: in .cache/blind")  # fmt: skip
    parser.add_argument("--write", metavar="FILE", type=Path, help="the page")
    add_json(parser)
    o = parser.parse_args(argv)
    if not (0 <= o.start < SERIES and o.count > 0):
        parser.error(f"there are {SERIES} series: --from 0 to {SERIES - 1}, --count 1 or more")
    if o.forms or o.outside:
        with tempfile.TemporaryDirectory() as folder:
            there = Path(folder)
            if o.forms:
                header, *rows = form_rows(forms(there, MORE * o.seed))
            else:
                header, *rows = proposal_rows(proposals(there, o.seed))
        common.print_rows(header, rows)
        return 0
    asked = islice(cases(o.seed), o.start, o.start + o.count)
    entries = list(_solved(asked, o.seed, o.journal or cache() / f"sweeps{o.seed}.jsonl"))
    if o.json:
        common.print_json({"series": entries, **{k: str(v) for k, v in summary(entries).items()}})
        return 0
    command = f"./flatplank bench-sweeps --seed {o.seed} --from {o.start} --count {o.count}"
    if o.write:
        write_atomic(o.write, page(entries, command))
    header, *rows = rows_of(entries)
    common.print_rows(header, rows)
    print("\n".join(f"{name}: {value}" for name, value in summary(entries).items()))
    return 0


def _solved(asked: Iterator[Case], seed: int, journal: Path) -> Iterator[dict[str, Any]]:
    """Entries of the series, from the journal where the present code made them."""
    code = code_version(CODE)
    known = {e["series"]: e for e in read(journal) if (e["seed"], e["code"]) == (seed, code)}
    journal.parent.mkdir(parents=True, exist_ok=True)
    with journal.open("a", encoding="utf-8") as stream:
        for case in asked:
            if case.number not in known:
                entry = measure(case, seed) | {"seed": seed, "code": code, "commit": commit()}
                stream.write(json.dumps(entry) + "\n")
                stream.flush()
                known[case.number] = entry
            print(f"series {case.number}", file=sys.stderr, flush=True)
            yield known[case.number]


def measure(case: Case, seed: int) -> dict[str, Any]:
    """One series: what is hidden, what is named, the error before and after."""
    columns = sweeps(case.brush, Plan(), seed=MORE * seed + case.number)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"series_{case.number}.csv"
        path.write_text(text_of(columns), encoding="utf-8")
        began = time.process_time()
        found = fp.sweeps(path).diagnose(BASE)
        seconds = time.process_time() - began
    told = found.to_dict()
    return {
        "series": case.number, "noise": round(case.brush.noise, 1), "hidden": case.hidden,
        "named": [e["name"] for e in told["effects"]],
        "size": told["effects"][0]["text"]["size"] if told["effects"] else "",
        "verdict": found.verdict, "floor": told["floor_rmse"], "before": told["rmse_before"],
        "after": told["rmse_after"], "next": told["next_run"].get("what", ""),
        "seconds": round(seconds, 1),
    }  # fmt: skip
