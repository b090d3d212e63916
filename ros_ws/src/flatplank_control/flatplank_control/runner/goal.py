# SPDX-License-Identifier: Apache-2.0
"""The text of a goal: a measurement or a campaign, checked before anything moves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flatplank_control.runner import measurement, plans
from flatplank_control.runner.campaign import is_campaign
from flatplank_data.yaml_text import load_yaml

EXAMPLE = "{measurement: slip, kappa: 0.05, effective_rolling_radius: 0.3108}"
SAYS_WHAT = ("measurement", "kappa", "waveform")
"""one of them makes of settings a wish"""


class GoalError(ValueError):
    """A goal that asks for nothing that can be made; one line."""


def mapping_of(text: str) -> Mapping[str, Any]:
    """What the goal's YAML says; GoalError when it says nothing, or is no mapping."""
    data = load_yaml(text, "plan")
    if data is None or data == {}:
        raise GoalError(f"plan: empty; say what to measure, for instance {EXAMPLE}")
    if not isinstance(data, Mapping):
        shown = " ".join(str(data).split())[:40]
        raise GoalError(f"plan: '{shown}' is no plan; give keys and values like {EXAMPLE}")
    return data


def measurement_of(data: Mapping[str, Any]) -> measurement.Measurement:
    """The single measurement of a goal that is no campaign; ValueError in one line."""
    wanted = measurement.from_mapping(data, "plan")
    if not any(key in data for key in SAYS_WHAT):
        raise GoalError(
            f"plan: says how, but not what to measure: add one of {', '.join(SAYS_WHAT)}"
        )
    plans.plan_of(wanted)
    return wanted


__all__ = ["GoalError", "is_campaign", "mapping_of", "measurement_of"]
