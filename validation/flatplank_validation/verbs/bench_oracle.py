# SPDX-License-Identifier: Apache-2.0
"""How near the search is to the limit of the data.

Sizes that it states for itself, and widths of its intervals, beside a test that knows which effect
to look for.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flatplank_data.arguments import Parser, add_json
from flatplank_data.errors import FlatplankError
from flatplank_validation.blind import journal
from flatplank_validation.blind.markdown import table
from flatplank_validation.evaluation.oracle import LIMITS, least_size, narrowest

WANTED = {"stated / law": (1.3, 2.0), "width / law": (1.2, math.nan)}
"""goals: median, and nine in ten"""


def main(argv: Sequence[str]) -> int:
    """`flatplank bench-oracle JOURNAL [--limit N] [--json]`."""
    parser = Parser(prog="flatplank bench-oracle", description=__doc__)
    parser.add_argument("journal", type=Path, help="of bench-blind: .jsonl, or .jsonl.gz of docs")
    parser.add_argument("--limit", type=int, help="only so many campaigns with one hidden effect")
    add_json(parser)
    o = parser.parse_args(argv)
    entries = journal.diagnosed(o.journal)
    rows = []
    chosen = [e for e in entries if _asked(e)][: o.limit]
    if not chosen:
        raise FlatplankError(
            "holds no diagnosed campaign with one hidden effect", str(o.journal), "name a journal"
            " of `flatplank bench-blind`, as docs/reference/discovery-blind.jsonl.gz"
        )  # fmt: skip
    for number, entry in enumerate(chosen):
        print(f"\roracle {number + 1}/{len(chosen)}", end="", file=sys.stderr, flush=True)
        rows.append(ratios(entry))
    print(file=sys.stderr)
    if o.json:
        print(json.dumps(rows, indent=1))
    else:
        print(page(rows))
    return 0


def _asked(entry: Mapping[str, Any]) -> bool:
    """True for a campaign with one hidden effect."""
    return len(entry["answer"]["effects"]) == 1


def ratios(entry: Mapping[str, Any]) -> dict[str, Any]:
    """Sizes of one campaign relative to each other; NaN where one does not exist."""
    case, (hidden,) = entry["case"], entry["answer"]["effects"]
    name, own = hidden["name"], hidden["detectable"]
    base, law = (least_size(case, name, limit) for limit in LIMITS)
    stated = (entry["diagnosis"].get("detectable") or {}).get(name)
    said = math.nan
    if stated is not None and stated["unit"] == hidden["unit"]:
        said = float(stated["size"])
    out = {
        "key": entry["key"],
        "base / own": base / own,
        "law / base": law / base,
        "consequence / law": max(hidden["consequence"], law) / law,
        "stated / law": said / max(law, 1e-30),
        "stated / (law or consequence)": said / max(law, hidden["consequence"]),
        "width / law": math.nan,
    }
    for e in entry["diagnosis"]["effects"]:
        if e["name"] == name and e["unit"] == hidden["unit"]:
            width = e["interval"][1] - e["interval"][0]
            out["width / law"] = width / narrowest(case, name, hidden["size"], "law")
    return out


def page(rows: Sequence[Mapping[str, Any]]) -> str:
    """Table of the ratios: median, one and nine in ten, and what is wanted."""
    return f"{len(rows)} campaigns with one hidden effect\n\n" + table(
        ["ratio", "campaigns", "10 %", "median", "90 %", "wanted: median, 90 %"],
        list(_lines(rows)),
    )


def _lines(rows: Sequence[Mapping[str, Any]]) -> Iterator[list[str]]:
    for name in rows[0]:
        if name == "key":
            continue
        values = np.array([row[name] for row in rows], dtype=float)
        known = values[np.isfinite(values)]
        if not len(known):
            yield [name, "0", "", "", "", ""]
            continue
        parts = [f"{v:.2f}" for v in np.percentile(known, (10, 50, 90))]
        wanted = ", ".join(f"{w:g}" for w in WANTED.get(name, ()) if not math.isnan(w))
        yield [name, str(len(known)), *parts, wanted]
