# SPDX-License-Identifier: Apache-2.0
"""Plans on the page Bench, and the proposed next run as a plan."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from flatplank_control.runner.campaign import plan_from_text, shipped_plans
from flatplank_control.runner.campaign.plan import FORMAT
from flatplank_control.runner.measurement import START_ANGLES
from flatplank_data.files import write_atomic
from flatplank_data.yaml_text import dump_yaml
from flatplank_panel import validation as check

Settings = Mapping[str, Any]
FOLDER = "plans"


def _start(s: Settings) -> dict[str, Any]:
    """Start position, or start angle when it is none of the three."""
    if s["start"] in START_ANGLES:
        return {"start": int(s["start"])}
    return {"start_angle_deg": 120.0 * (float(s["start"]) - 1.0)}


def _preload(s: Settings) -> dict[str, Any]:
    """Double step: preload slip from the start of the road, the measured slip at the step."""
    slips = {"kappa_1": s["preload"], "kappa_2": s["kappa"], "length": s["step_position"]}
    return {"waveform": "double_step", "waveform_parameters": slips, "step_position": 0.0}


def _as_it_is(key: str) -> Callable[[Settings], dict[str, Any]]:
    return lambda s: {key: float(s[key])}


BLOCK_OF_SETTING: dict[str, Callable[[Settings], dict[str, Any]]] = {
    **{k: _as_it_is(k) for k in ("kappa", "fz", "pressure", "alpha_deg", "gamma_deg")},
    "step_position": _as_it_is("step_position"),
    "start": _start,
    "speed": _as_it_is("speed"),
    # last, because it moves the step
    "preload": _preload,
}
"""setting of a proposal -> keys of a plan; ValueError for a setting that a plan cannot express"""


def block_of(settings: Settings) -> dict[str, Any]:
    """One run of a plan; ValueError names a setting that no plan can express."""
    for key in settings:
        if key not in BLOCK_OF_SETTING:
            raise ValueError(f"{key}: a plan cannot express it; measure by hand")
    for key in ("kappa", "step_position"):
        if key not in settings:
            raise ValueError(f"{key}: the proposal does not state it; measure by hand")
    block: dict[str, Any] = {"measurement": "slip"}
    for key in (k for k in BLOCK_OF_SETTING if k in settings):
        block |= BLOCK_OF_SETTING[key](settings)
    return block


def plans_of(data: Path) -> dict[str, Path]:
    """Available plans: title -> file; packaged ones, then those in DATA/plans."""
    shipped = {name.replace("_", " "): path for name, path in shipped_plans().items()}
    own = sorted((data / FOLDER).glob("*.yaml"))
    return shipped | {f"{FOLDER}/{p.name}": p for p in own}


def write_next(proposal: Mapping[str, Any], campaign: str, data: Path) -> Path:
    """Write a checked plan DATA/plans/next_run_CAMPAIGN.yaml; ValueError when the bench cannot
    make it.

    `proposal`: mapping with what, tire, repeats, and the settings of its runs in `runs`.
    """
    runs = proposal.get("runs")
    if not runs:
        raise ValueError("the proposal names no run that the bench can make")
    repeats = int(proposal.get("repeats") or 3)
    name = check.name(f"next_run_{campaign}")
    blocks = [block_of(settings) | {"repeats": repeats} for settings in runs]
    plan = {"format": FORMAT, "name": name, "tire": proposal.get("tire", ""), "runs": blocks}
    purpose = " ".join(str(proposal.get("what", "")).split())
    text = f"# {purpose}\n" + dump_yaml(plan)
    path = data / FOLDER / f"{name}.yaml"
    plan_from_text(text, path.name)
    path.parent.mkdir(exist_ok=True)
    write_atomic(path, text)
    return path
