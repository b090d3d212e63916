# SPDX-License-Identifier: Apache-2.0
"""Effects hidden in forty generated series of sweeps.

The series are of a discrete brush that shares no code with the models; the base is a tire file
that was fitted to the same brush with nothing hidden.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from itertools import islice
from pathlib import Path

import flatplank_analysis as fp
from flatplank_analysis.cli import common
from flatplank_data.arguments import Parser, add_json
from flatplank_validation.sweep_sets.brush import BASE, Plan, sweeps, text_of
from flatplank_validation.sweep_sets.sets import SERIES, Case, cases

WANTED = "wanted: nothing named in 19 of 20 nulls; the right name first in 85 % of the others"


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank bench-sweeps [--seed N] [--from N] [--count N] [--json]`."""
    parser = Parser(prog="flatplank bench-sweeps", description=__doc__)
    parser.add_argument("--seed", type=int, default=1, help="of the forty series (default 1)")
    parser.add_argument("--from", type=int, default=0, dest="start", help="first one (default 0)")
    parser.add_argument("--count", type=int, default=40, help="number of series (default 40)")
    add_json(parser)
    o = parser.parse_args(argv)
    if not (0 <= o.start < SERIES and o.count > 0):
        parser.error(f"there are {SERIES} series: --from 0 to {SERIES - 1}, --count 1 or more")
    rows = [measure(case, o.seed) for case in islice(cases(o.seed), o.start, o.start + o.count)]
    if o.json:
        common.print_json({"series": rows, **summary(rows)})
        return 0
    header = ("series", "noise [N]", "hidden", "named", "verdict", "before [N]", "after [N]")
    common.print_rows(header, [tuple(str(v) for v in row.values()) for row in rows])
    print("; ".join(f"{key.replace('_', ' ')}: {value}" for key, value in summary(rows).items()))
    print(WANTED)
    return 0


def measure(case: Case, seed: int) -> dict[str, object]:
    """One series: what is hidden, what is named, the error before and after."""
    columns = sweeps(case.brush, Plan(), seed=1000 * seed + case.number)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"series_{case.number}.csv"
        path.write_text(text_of(columns), encoding="utf-8")
        found = fp.sweeps(path).diagnose(BASE)
    told = found.to_dict()
    return {
        "series": case.number, "noise": round(case.brush.noise, 1), "hidden": case.hidden or "-",
        "named": ", ".join(e["name"] for e in told["effects"]) or "-", "verdict": found.verdict,
        "before": round(told["rmse_before"], 1), "after": round(told["rmse_after"], 1),
    }  # fmt: skip


def summary(rows: Sequence[dict[str, object]]) -> dict[str, str]:
    """Nulls with nothing named, and others with the right name first."""
    nulls = [row for row in rows if row["hidden"] == "-"]
    others = [row for row in rows if row["hidden"] != "-"]
    right = sum(str(row["named"]).split(", ")[0] == row["hidden"] for row in others)
    silent = sum(row["named"] == "-" for row in nulls)
    return {
        "nulls_with_nothing_named": f"{silent} of {len(nulls)}",
        "right_name_first": f"{right} of {len(others)}",
    }
