# SPDX-License-Identifier: Apache-2.0
"""Plans for tests of campaigns."""

from __future__ import annotations

from flatplank_control.runner.campaign import CampaignPlan, plan_from_text

HEAD = "format: flatplank-plan/1\nname: small\ntire: TOY\n"
RUNS = "runs:\n- measurement: slip\n  kappa: [0.0, 0.05]\n  start: [1, 2]\n"
ROAD = "common: {step_position: 0.3, end_position: 0.6}\n"
LENIENT = (
    "quality: {settling: 10000, load_error: 1, load_drift: 1, force_error: 1000, "
    "plateau: 10, repeatability: 10000, speed_error: 1, once_per_turn: 10000}\n"
)


def small(more: str = "", runs: str = RUNS) -> CampaignPlan:
    """A plan in YAML, expanded."""
    return plan_from_text(HEAD + more + runs, "small.yaml")
