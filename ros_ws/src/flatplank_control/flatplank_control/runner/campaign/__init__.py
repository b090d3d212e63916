# SPDX-License-Identifier: Apache-2.0
"""Campaigns: expand a plan to runs, judge each run, and resume after a stop."""

from flatplank_control.runner.campaign.conductor import Conductor, Job, Outcome
from flatplank_control.runner.campaign.journal import Journal, pressure_after, write_note
from flatplank_control.runner.campaign.order import PlannedRun
from flatplank_control.runner.campaign.plan import (
    CampaignPlan,
    PlanError,
    is_campaign,
    load_plan,
    plan_from_text,
    shipped_plans,
)
from flatplank_control.runner.campaign.quality import Limits, Verdict, judge_run

__all__ = [
    "CampaignPlan", "Conductor", "Job", "Journal", "Limits", "Outcome", "PlanError",
    "PlannedRun", "Verdict", "is_campaign", "judge_run", "load_plan", "plan_from_text",
    "pressure_after", "shipped_plans", "write_note",
]  # fmt: skip
