# SPDX-License-Identifier: Apache-2.0
"""A report of a campaign: one page that opens offline.

Figures, tables and numbers lie beside the page.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from pathlib import Path

from flatplank_analysis.cli import common
from flatplank_analysis.report_files.build import build
from flatplank_data.errors import FlatplankError


def main(argv: Sequence[str] | None = None) -> int:
    """`report DIR... [--tire FILE] [--reference DIR...] [--out DIR]`; prints the path."""
    parser = common.campaign_parser("report", __doc__, several=True)
    parser.add_argument(
        "--out", metavar="DIR", help="where to write (default: report in the first DIR)"
    )
    parser.add_argument(
        "--reference",
        metavar="DIR",
        nargs="+",
        default=[],
        help="sessions of the reference tire, a folder each: control charts over them",
    )
    common.tire_argument(parser)
    common.parallel_arguments(parser)
    arguments = parser.parse_args(argv)
    return common.run_or_report_nothing_usable("report", lambda: _run(arguments))


def _run(arguments) -> int:
    if not arguments.folder:
        raise FlatplankError("no campaign", "command line", "name a folder")
    first = arguments.folder[0]
    loaded = [common.load_folder(folder, arguments.mapping) for folder in arguments.folder]
    campaign = reduce(lambda one, other: one.merged(other), loaded)
    local = "report" if "://" in first else Path(first) / "report"
    out = Path(arguments.out or local)
    page = build(
        campaign,
        out,
        jobs=arguments.jobs,
        scheduler=arguments.scheduler,
        progress=common.show_progress,
        tire=arguments.tire,
        reference=[common.load_folder(f, arguments.mapping) for f in arguments.reference],
    )
    common.print_problems(campaign.problems)
    if arguments.json:
        data = {"page": str(page), "data": str(out / "report.json")}
        common.print_json(data | {"problems": [str(p) for p in campaign.problems]})
    else:
        print(page)
    return 0
