# SPDX-License-Identifier: Apache-2.0
"""A report of a campaign: one page that opens offline, figures, tables and numbers beside it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from flatplank_analysis.cli import common
from flatplank_analysis.report.build import build


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank report DIR [--out DIR]`; prints the page's path."""
    parser = common.campaign_parser("report", __doc__)
    parser.add_argument("--out", metavar="DIR", help="where to write (default: DIR/report)")
    common.parallel_arguments(parser)
    arguments = parser.parse_args(argv)
    return common.guarded("report", lambda: _run(arguments))


def _run(arguments) -> int:
    campaign = common.load_campaign(arguments)
    local = "report" if "://" in arguments.folder else Path(arguments.folder) / "report"
    out = Path(arguments.out or local)
    page = build(
        campaign,
        out,
        jobs=arguments.jobs,
        scheduler=arguments.scheduler,
        progress=common.show_progress,
    )
    common.tell(campaign.problems)
    if arguments.json:
        data = {"page": str(page), "data": str(out / "report.json")}
        common.print_json(data | {"problems": [str(p) for p in campaign.problems]})
    else:
        print(page)
    return 0
