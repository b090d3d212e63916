# SPDX-License-Identifier: Apache-2.0
"""Fit and report of the demo's campaign."""

from __future__ import annotations

from pathlib import Path

from flatplank_analysis.data import Campaign
from flatplank_analysis.report.analysis import analyse
from flatplank_analysis.report.build import write
from flatplank_control.demo.steps import Teller


def fit_and_report(
    folder: Path, out: Path, jobs: int | None, teller: Teller
) -> tuple[Path, list[str]]:
    """The page, and what the fits found in words."""
    teller.step("models fitted to the bags, figures and report")
    campaign = Campaign.load(folder)
    result = analyse(campaign, jobs=jobs)
    page = write(result, out)
    return page, [str(problem) for problem in campaign.problems]
