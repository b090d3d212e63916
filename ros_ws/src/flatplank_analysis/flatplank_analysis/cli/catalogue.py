# SPDX-License-Identifier: Apache-2.0
"""All runs of all campaigns below a folder: select, chart.

Record, quality and verdict of each; kept in one Parquet file.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

import pandas as pd

from flatplank_analysis.catalogues import build
from flatplank_analysis.catalogues.catalogue import Catalogue, of
from flatplank_analysis.catalogues.conditions import CONDITIONS
from flatplank_analysis.cli import common
from flatplank_data.arguments import Parser, add_json
from flatplank_data.errors import FlatplankError

SHOWN = 40
"""rows that are printed; --json has all"""


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank catalogue ROOT [--where KEY=VALUE...] [--chart DIR] [--json]`."""
    parser = Parser(prog="flatplank catalogue", description=__doc__)
    parser.add_argument("root", metavar="ROOT", help="folder with campaigns below it")
    parser.add_argument(
        "--where", metavar="KEY=VALUE", nargs="+", default=(),
        help="runs that fulfil all of these, in the catalogue as it was kept: "
        f"{', '.join(CONDITIONS)}; as tire=TOY pressure=2.5bar load=3000..4000 since=2026-05-01",
    )  # fmt: skip
    parser.add_argument(
        "--chart", metavar="DIR", help="page of the control charts of one tire, over its sessions"
    )
    common.parallel_arguments(parser)
    add_json(parser)
    return _run(parser.parse_args(argv))


def _run(o: argparse.Namespace) -> int:
    conditions = dict(_condition(text) for text in o.where)
    found = build.stored(o.root) if conditions else None
    if found is None:
        found = build.updated(
            o.root, jobs=o.jobs, scheduler=o.scheduler, progress=common.show_progress
        )
    runs = of(o.root, found).where(**conditions)
    page = _chart(runs, o) if o.chart else None
    if o.json:
        common.print_json(_told(o.root, found, runs if conditions else None, page))
        return 0
    print(_headline(o.root, found, bool(conditions)))
    _print(runs if conditions else runs.unusable, bool(conditions))
    if page:
        print(page)
    return 0


def _condition(text: str) -> tuple[str, str]:
    name, mark, value = text.partition("=")
    if not mark or not value:
        raise FlatplankError(f"'{text}' is not KEY=VALUE", "--where", "write tire=TOY")
    return name, value


def _chart(runs: Catalogue, o: argparse.Namespace) -> Path:
    from flatplank_analysis.catalogues.chart import write_chart

    return write_chart(
        runs, o.chart, jobs=o.jobs, scheduler=o.scheduler, progress=common.show_progress
    )


def _told(
    root: str, found: build.Update, runs: Catalogue | None, page: Path | None
) -> dict[str, Any]:
    said: dict[str, Any] = {
        "format": build.FORMAT, "file": str(build.file_of(root)), "folders": len(found.stamps),
        "runs": found.table.num_rows, "read": list(found.read), "gone": list(found.gone),
    }  # fmt: skip
    if runs is not None:
        rows = runs.rows.astype(object)
        said["rows"] = rows.where(rows.notna(), None).to_dict("records")
    return said | ({"page": str(page)} if page else {})


def _headline(root: str, found: build.Update, asked: bool) -> str:
    path = build.file_of(root)
    size = f"{found.table.num_rows} runs in {len(found.stamps)} folders"
    if asked and not found.read:
        when = datetime.fromtimestamp(path.stat().st_mtime).strftime("%Y-%m-%d %H:%M")
        return f"{size}, as of {when}; `flatplank catalogue {root}` looks for what changed"
    if not found.kept:
        return f"{size}; {path} cannot be written: the catalogue is made anew each time"
    return f"{size}, {len(found.read)} read, {len(found.gone)} gone: {path}"


def _print(runs: Catalogue, asked: bool) -> None:
    """The selected runs; without a selection the files that cannot be used."""
    rows = runs.rows
    if asked:
        header = ("folder", "run", "tire", "Fz [N]", "p [bar]", "kappa [%]", "date", "bench",
                  "quality", "verdict")  # fmt: skip
        usual = rows[rows["kind"].notna()]
        slips = (100.0 * usual["kappa"]).round(3)
        columns = [usual["folder"], usual["file"], usual["tire"], usual["fz"], usual["pressure"],
                   slips, usual["date"].str[:10], usual["bench"], usual["quality"],
                   usual["verdict"]]  # fmt: skip
        cells = [[_text(v) for v in column.head(SHOWN)] for column in columns]
        common.print_rows(header, list(zip(*cells, strict=True)))
        print(f"{len(usual)} runs" + (f", {SHOWN} shown" if len(usual) > SHOWN else ""))
        return
    for folder, error in rows[["folder", "error"]].head(SHOWN).itertuples(index=False):
        print(f"{folder}: {error}")
    if len(rows) > SHOWN:
        print(f"and {len(rows) - SHOWN} more")


def _text(value: Any) -> str:
    if pd.isna(value) or value == "":
        return "-"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
