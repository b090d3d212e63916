# SPDX-License-Identifier: Apache-2.0
"""Fit and report of the demo's campaign."""

from __future__ import annotations

from pathlib import Path

from flatplank_analysis.report.analysis import analyse
from flatplank_analysis.report.results import CampaignResult
from flatplank_analysis.report_files.build import write
from flatplank_data.campaign import Campaign
from flatplank_sim.demo.steps import Teller


def fit_and_report(
    folder: Path, out: Path, jobs: int | None, teller: Teller
) -> tuple[Path, list[str]]:
    """The page, and what the fits found in words."""
    teller.step("models fitted to the bags, figures and report")
    campaign = Campaign.load(folder)
    result = analyse(campaign, jobs=jobs)
    page = write(result, out)
    return page, [*_found(result), *(str(problem) for problem in campaign.problems)]


def _found(result: CampaignResult) -> list[str]:
    """Slip stiffness, relaxation length and errors of the models, in words."""
    point = result.nominal()
    if point is None:
        return []
    lines = []
    small = min(
        (c for c in point.conditions if c.condition.kappa > 0), key=lambda c: c.condition.kappa
    )
    fit = small.linear
    lines.append(
        f"linear model at {100 * small.condition.kappa:+g} %: relaxation length "
        f"{fit.sigma.value:.3f} m, slip stiffness {fit.slip_stiffness.value / 1000:.1f} kN"
    )
    for model in point.models.values():
        mean = sum(model.rmse.values()) / max(len(model.rmse), 1)
        lines.append(
            f"{model.title}: RMSE in the transient part {mean:.0f} N (mean over the slips)"
        )
    return lines
