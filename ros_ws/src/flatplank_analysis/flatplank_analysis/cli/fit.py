# SPDX-License-Identifier: Apache-2.0
"""Fit a tire model to a campaign; every number with its standard error."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from typing import Any

from flatplank_analysis.cli import common
from flatplank_analysis.data.campaign import Campaign
from flatplank_analysis.identify.results import to_plain
from flatplank_analysis.report.analysis import analyse
from flatplank_analysis.report.results import CampaignResult
from flatplank_analysis.report.tables import carcass_table, linear_table

FORMAT = "flatplank-fit/1"


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank fit DIR --model linear|nonlinear|mf [--json]`."""
    parser = common.campaign_parser("fit", __doc__)
    parser.add_argument("--model", choices=sorted(MODELS), default="linear")
    common.parallel_arguments(parser)
    arguments = parser.parse_args(argv)
    return common.guarded("fit", lambda: _run(arguments))


def _run(arguments: argparse.Namespace) -> int:
    begin = time.perf_counter()
    campaign = common.load_campaign(arguments)
    found, show = MODELS[arguments.model](campaign, arguments)
    common.tell(campaign.problems)
    if arguments.json:
        head = {"format": FORMAT, "model": arguments.model, "campaign": campaign.path}
        tail = {
            "problems": [str(p) for p in campaign.problems],
            "seconds": round(time.perf_counter() - begin, 3),
        }
        common.print_json(head | found | tail)
    else:
        show()
    return 0


Fitted = tuple[dict[str, Any], Callable[[], None]]


def _analyse(campaign: Campaign, arguments: argparse.Namespace, nonlinear: bool) -> CampaignResult:
    return analyse(
        campaign,
        jobs=arguments.jobs,
        scheduler=arguments.scheduler,
        nonlinear=nonlinear,
        progress=common.show_progress,
    )


def _linear(campaign: Campaign, arguments: argparse.Namespace) -> Fitted:
    result = _analyse(campaign, arguments, nonlinear=False)
    found = {"tire": result.tire, "conditions": [c.to_json() for c in result.conditions]}
    return found, lambda: _print(linear_table(result))


def _nonlinear(campaign: Campaign, arguments: argparse.Namespace) -> Fitted:
    result = _analyse(campaign, arguments, nonlinear=True)
    points = [
        {
            "point": to_plain(p.point._asdict()),
            "carcass": p.carcass.to_json() if p.carcass else None,
            "why_no_carcass": p.why_no_carcass,
            "rmse": {f"{c.kappa:g}": to_plain(v) for c, v in p.models["nonlinear"].rmse.items()}
            if "nonlinear" in p.models
            else {},
        }
        for p in result.points
    ]
    return {"tire": result.tire, "points": points}, lambda: _print(carcass_table(result))


def _print(table) -> None:
    rows = [[c if isinstance(c, str) else f"{c:.5g}" for c in row] for row in table.rows]
    common.print_rows(table.header, rows)
    print(f"\n{table.note}")


MODELS: dict[str, Callable[[Campaign, argparse.Namespace], Fitted]] = {
    "linear": _linear,
    "nonlinear": _nonlinear,
}
