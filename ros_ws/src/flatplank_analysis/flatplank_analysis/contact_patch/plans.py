# SPDX-License-Identifier: Apache-2.0
"""Runs that the bench can make next, as predictions before they are measured."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flatplank_analysis.contact_patch.data import grid_groups, steps_along
from flatplank_analysis.contact_patch.grid import SPEED, node_positions
from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.contact_patch.tire_runs import SETTINGS, TireRuns
from flatplank_analysis.discovery.runs import RunSet
from flatplank_data.machine import SLOW

LOCKED = 0.0015
"""[m] plank travel before the wheel turns"""


@dataclass(frozen=True)
class Plan:
    """A run that can be made, with the model that predicts it."""

    text: str
    settings: dict[str, Any]
    model: TireModel


def plans_for(model: TireModel) -> list[Plan]:
    """Feasible runs around those of the campaign."""
    data = model.data
    load, pressure, step = data.reference.load, data.reference.pressure, usual_step(data.runs)
    usual = {"fz": load, "pressure": pressure, "step_position": step, "start": 1}
    others: dict[str, dict[str, Any]] = {
        "once more": {},
        f"with the step at {step - 0.6:.1f} m": {"step_position": step - 0.6},
        f"with the step at {step + 0.7:.1f} m": {"step_position": step + 0.7},
        f"at {1.3 * load:.0f} N": {"fz": round(1.3 * load)},
        f"at {SLOW:g} m/s": {"speed": SLOW},
        "from a start angle of 60 deg": {"start": 1.5},
        "out of a preload of 1 % driving": {"preload": 0.01},
    }
    levels = sorted({float(k) for k in np.round(data.kappa, 4)}, key=abs)
    # small slips show play best, large ones friction
    return [
        planned(model, f"slip {100 * kappa:+g} % {words}", {"kappa": kappa} | usual | other)
        for kappa in dict.fromkeys([*levels[:3], *levels[-2:]])
        for words, other in others.items()
    ]


def usual_step(runs: RunSet) -> float:
    """Step position in the middle of the runs [m]."""
    steps = runs.facts.get("step", np.array([np.nan]))
    return float(np.nanmedian(steps)) if np.isfinite(steps).any() else 1.5


def planned(model: TireModel, text: str, settings: dict[str, Any]) -> Plan:
    """A run with these settings, predicted with the references of the given model."""
    data = planned_data(model.data, settings)
    planned = TireModel(data)
    planned.parameters = model.parameters
    planned.take_references(model)
    return Plan(text, settings, planned)


def planned_data(data: TireRuns, s: dict[str, Any]) -> TireRuns:
    """Inputs of one planned run: constant plank speed, a locked start, one slip step."""
    speed, preload = float(s.get("speed", SPEED)), float(s.get("preload", 0.0))
    end = float(data.position.max()) - 0.004
    place = np.concatenate([[0.0, 0.0, 0.0], node_positions(s["step_position"], end)])
    radius = float(np.median(data.radius))
    after = np.maximum(place - s["step_position"], 0.0)
    rolled = np.maximum(place - LOCKED, 0.0) * (1.0 + preload) + (s["kappa"] - preload) * after
    angle = (rolled / radius)[None]
    position = place[None]
    rest = np.array([[0.0, 0.1, 0.2]])
    time = np.concatenate([rest, 0.2 + place[None, 3:] / speed], axis=1)
    load = np.full_like(position, float(s["fz"]))
    start = np.radians(120.0 * (float(s["start"]) - 1.0))
    one = {
        "nominal": float(s["fz"]),
        "radius": radius,
        "alpha": float(s.get("alpha", np.median(data.alpha))),
        "gamma": float(np.median(data.gamma)),
        "kappa": float(s["kappa"]),
        "pressure": float(s["pressure"]),
        "step": float(s["step_position"]),
        "start": start,
        "order": float(data.runs.order.max()) + 1.0,
        "speed": speed,
    }
    facts = {k: np.array([v]) for k, v in one.items()}
    channels = data.runs.channels
    runs = RunSet(
        names=("planned",),
        condition=np.zeros(1, dtype=int),
        condition_names=("planned",),
        channels=channels,
        measured=np.zeros((len(channels), *position.shape)),
        time=time,
        order=facts["order"],
        coordinates={},
        units=data.runs.units,
        facts=facts,
    )
    return replace(
        data,
        against=data.reference,
        runs=runs,
        position=position,
        angle=angle,
        travel=steps_along(position),
        turned=steps_along(angle),
        step_time=steps_along(time),
        load=load,
        **{name: facts[name] for name in SETTINGS},
        since_step=position - s["step_position"],
        wheel_turn=angle + start,
        signals={k: np.broadcast_to(v.mean(axis=0)[:1], position.shape).copy()
                 for k, v in data.signals.items()},
        side_force=np.zeros(1),
        grids=grid_groups([("planned",)]),
    )  # fmt: skip
