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

from flatplank_analysis.catalogues.catalogue import Catalogue
from flatplank_analysis.catalogues.conditions import CONDITIONS, conditions_of
from flatplank_analysis.catalogues.kept import FORMAT, Update, file_of, stored
from flatplank_analysis.catalogues.shown import COLUMNS, SHOWN, problem_lines
from flatplank_analysis.cli import common
from flatplank_data.arguments import Parser, add_json

SHOWN_COLUMNS = (
    "folder", "file", "tire", "fz", "pressure", "kappa", "date", "bench", "quality", "verdict",
    "kind",
)  # fmt: skip
"""columns that are printed"""


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
    conditions = conditions_of(o.where)
    keeps = {name: CONDITIONS[name].column for name in conditions if name in CONDITIONS}
    columns = None if o.json or o.chart else {*SHOWN_COLUMNS, *keeps.values()}
    found = stored(o.root, columns) if conditions else None
    if found is None:
        from flatplank_analysis.catalogues.build import updated

        found = updated(o.root, jobs=o.jobs, scheduler=o.scheduler, progress=common.show_progress)
    runs = Catalogue(Path(o.root), found.table).where(**conditions)
    page = _chart(runs, o) if o.chart else None
    if o.json:
        common.print_json(_told(o.root, found, runs if conditions else None, page))
        return 0
    print(_headline(o.root, found, bool(conditions)))
    _print(runs if conditions else runs.unusable, bool(conditions))
    if page:
        print(page)
    return 0


def _chart(runs: Catalogue, o: argparse.Namespace) -> Path:
    from flatplank_analysis.catalogues.chart import write_chart

    return write_chart(
        runs, o.chart, jobs=o.jobs, scheduler=o.scheduler, progress=common.show_progress
    )


def _told(root: str, found: Update, runs: Catalogue | None, page: Path | None) -> dict[str, Any]:
    said: dict[str, Any] = {
        "format": FORMAT, "file": str(file_of(root)), "folders": len(found.stamps),
        "runs": found.table.num_rows, "read": list(found.read), "gone": list(found.gone),
    }  # fmt: skip
    if runs is not None:
        said["rows"] = runs.table.to_pylist()
    return said | ({"page": str(page)} if page else {})


def _headline(root: str, found: Update, asked: bool) -> str:
    path = file_of(root)
    size = f"{found.table.num_rows} runs in {len(found.stamps)} folders"
    if asked and not found.read:
        when = datetime.fromtimestamp(path.stat().st_mtime).strftime("%Y-%m-%d %H:%M")
        return f"{size}, as of {when}; `flatplank catalogue {root}` looks for what changed"
    if not found.kept:
        return f"{size}; {path} cannot be written: the catalogue is made anew each time"
    return f"{size}, {len(found.read)} read, {len(found.gone)} gone: {path}"


def _print(runs: Catalogue, asked: bool) -> None:
    """The selected runs; without a selection the files that cannot be used."""
    if asked:
        usable = runs.usable.table
        shown = usable.slice(0, SHOWN)
        cells = [COLUMNS[name].texts(shown[name]) for name in SHOWN_COLUMNS]
        header = [COLUMNS[name].head for name in SHOWN_COLUMNS]
        common.print_rows(header, list(zip(*cells, strict=True)))
        size = usable.num_rows
        print(f"{size} runs" + (f", {SHOWN} shown" if size > SHOWN else ""))
        return
    for line in problem_lines(runs.table):
        print(line)
