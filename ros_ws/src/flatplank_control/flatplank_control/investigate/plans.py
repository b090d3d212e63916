# SPDX-License-Identifier: Apache-2.0
"""Batches as campaign plans, and what they take."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

import yaml

from flatplank_analysis.investigation.planner import Price
from flatplank_analysis.investigation.settings import Setting
from flatplank_control.runner.campaign import plan_from_text
from flatplank_control.runner.campaign.dry_run import dry_run
from flatplank_control.runner.campaign.plan import FORMAT, CampaignPlan

SET_UP = {"fz": 0.0, "pressure": 5.0, "alpha_deg": 2.0}
"""what changes of a condition take beside the dry run, in which a simulated operator has his hands
at everything [min]: air and its settling, the steering's lock"""
Radii = Mapping[tuple[float, float, float], float]
"""condition of a setting -> effective rolling radius [m], where it is known"""


def batch_name(number: int) -> str:
    """Of a plan and its journal."""
    return f"batch_{number:02d}"


def text_of(
    name: str,
    tire: str,
    settings: Sequence[Setting],
    radii: Radii,
    first_run: int,
    more: Mapping[str, Any] | None = None,
) -> str:
    """A plan of settings of one condition; r_e is measured where it is not known.

    more: further keys of the plan, `quality` or `common` for instance.
    """
    radius = radii.get(settings[0].condition)
    given = {} if radius is None else {"effective_rolling_radius": radius}
    plan = {
        "format": FORMAT, "name": name, "tire": tire, "attempts": 1, "first_run": first_run,
        "r_e": "measured" if radius is None else "given", **(more or {}),
        "runs": [{"measurement": "slip", **s.plain(), **given} for s in settings],
    }  # fmt: skip
    return yaml.safe_dump(plan, sort_keys=False)


def settings_of(plan: CampaignPlan) -> dict[str, Setting]:
    """The settings of a plan's slip runs by key."""
    out = {}
    for run in plan.runs:
        m = run.measurement
        if m.measurement == "slip":
            out[run.key] = Setting(
                m.kappa, m.start, m.step_position, m.fz, m.pressure, m.alpha_deg
            )
    return out


def price_of(
    tire: str,
    settings: Sequence[Setting],
    radii: Radii,
    stands: Setting | None,
    more: Mapping[str, Any] | None = None,
) -> Price:
    """Minutes of a batch's dry run, the plank's way back before its first run with it, and of
    what is changed from how the bench stands."""
    text = text_of("price", tire, (settings[0], *settings), radii, 0, more)
    before, minutes, changes = stands, _dry_minutes(text), 0
    for s in settings:
        for name, each in SET_UP.items():
            if before is not None and getattr(s, name) != getattr(before, name):
                minutes += each
                changes += 1
        before = s
    return Price(minutes, changes)


@lru_cache(maxsize=512)
def _dry_minutes(text: str) -> float:
    """Without the first run, which finds the plank at the front."""
    times = list(dry_run(plan_from_text(text, "batch")).durations.values())
    return sum(times[1:]) / 60.0
