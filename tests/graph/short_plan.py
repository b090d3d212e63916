# SPDX-License-Identifier: Apache-2.0
"""The shortest campaign: one slip run over 0.23 m of road, its r_e given."""

from __future__ import annotations


def short_plan(name: str, run: str = "kappa: 0.02", more: str = "") -> str:
    """Its YAML text.

    Args:
        name: of the plan.
        run: keys of the one run, as between braces.
        more: further lines of the plan, each ended.
    """
    return f"""
format: flatplank-plan/1
name: {name}
tire: TOY
{more}r_e: given
common: {{step_position: 0.03, end_position: 0.23}}
runs:
- {{measurement: slip, {run}, effective_rolling_radius: 0.3108}}
"""
