# SPDX-License-Identifier: Apache-2.0
"""Runs that the bench can make next, as predictions before they are measured."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flatplank_analysis.contact_patch.data import grid_groups, roughness_of, steps_along
from flatplank_analysis.contact_patch.grid import SPEED, node_positions
from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.contact_patch.tire_runs import SETTINGS, TireRuns
from flatplank_analysis.discovery.runs import Coordinate, RunSet
from flatplank_data.machine import SLOW

STARTS = (1, 2, 3)
"""starts of the wheel, 120 deg apart: from one start alone the wave of a turn is the same in all
runs, as the profile of the road is"""
STEPS = (-0.6, 0.7)
"""further step positions, relative to the usual one [m]"""
LOADS = (0.7, 1.3)
"""further loads, as shares of the usual one"""
LOCKED = 0.0015
"""[m] plank travel before the wheel turns"""


@dataclass(frozen=True)
class Plan:
    """Runs that can be made, with the model that predicts them."""

    text: str
    settings: dict[str, Any]
    model: TireModel


def plans_for(model: TireModel) -> list[Plan]:
    """Feasible runs around those of the campaign."""
    data = model.data
    load, pressure, step = data.reference.load, data.reference.pressure, usual_step(data.runs)
    usual: dict[str, Any] = {
        "fz": load,
        "pressure": pressure,
        "step_position": step,
        "starts": list(STARTS),
    }
    others: dict[str, dict[str, Any]] = {
        "once more": {},
        **{f"with the step at {step + d:.1f} m": {"step_position": step + d} for d in STEPS},
        **{f"at {share * load:.0f} N": {"fz": round(share * load)} for share in LOADS},
        f"at {SLOW:g} m/s": {"speed": SLOW},
        "between the usual starts": {"starts": [start + 0.5 for start in STARTS]},
        "out of a preload of 1 % driving": {"preload": 0.01},
    }
    levels = sorted({float(k) for k in np.round(data.kappa, 4)}, key=abs)
    # small slips show play best, large ones friction
    out = []
    for kappa in dict.fromkeys([*levels[:3], *levels[-2:]]):
        for words, other in others.items():
            settings: dict[str, Any] = {"kappa": kappa} | usual | other
            starts = ", ".join(f"{start:g}" for start in settings["starts"])
            text = f"slip {100 * kappa:+g} % {words}, from starts {starts}"
            out.append(planned(model, text, settings))
    return out


def usual_step(runs: RunSet) -> float:
    """Step position in the middle of the runs [m]."""
    steps = runs.facts.get("step", np.array([np.nan]))
    return float(np.nanmedian(steps)) if np.isfinite(steps).any() else 1.5


def planned(model: TireModel, text: str, settings: dict[str, Any]) -> Plan:
    """Runs with these settings, predicted with the references of the given model."""
    data = planned_data(model.data, settings)
    planned = TireModel(data)
    planned.take_references(model)
    planned.take_parameters_beside(model)
    return Plan(text, settings, planned)


def planned_data(data: TireRuns, s: dict[str, Any]) -> TireRuns:
    """Inputs of a planned run from each of its `starts` (or `start`): constant plank speed, a
    locked start, one slip step."""
    starts = np.atleast_1d(np.asarray(s["starts"] if "starts" in s else s["start"], dtype=float))
    count = len(starts)
    speed, preload = float(s.get("speed", SPEED)), float(s.get("preload", 0.0))
    end = float(data.position.max()) - 0.004
    place = np.concatenate([[0.0, 0.0, 0.0], node_positions(s["step_position"], end)])
    radius = float(np.median(data.radius))
    after = np.maximum(place - s["step_position"], 0.0)
    rolled = np.maximum(place - LOCKED, 0.0) * (1.0 + preload) + (s["kappa"] - preload) * after
    angle = np.tile(rolled / radius, (count, 1))
    position = np.tile(place, (count, 1))
    rest = np.array([0.0, 0.1, 0.2])
    time = np.tile(np.concatenate([rest, 0.2 + place[3:] / speed]), (count, 1))
    load = np.full_like(position, float(s["fz"]))
    one = {
        "nominal": float(s["fz"]),
        "radius": radius,
        "alpha": float(s.get("alpha", np.median(data.alpha))),
        "gamma": float(np.median(data.gamma)),
        "kappa": float(s["kappa"]),
        "pressure": float(s["pressure"]),
        "step": float(s["step_position"]),
        "speed": speed,
    }
    facts = {k: np.full(count, v) for k, v in one.items()}
    facts |= {
        "start": np.radians(120.0 * (starts - 1.0)),
        "order": float(data.runs.order.max()) + 1.0 + np.arange(count),
    }
    channels = data.runs.channels
    runs = RunSet(
        names=("planned",) * count,
        condition=np.zeros(count, dtype=int),
        condition_names=("planned",) * count,
        channels=channels,
        measured=np.zeros((len(channels), *position.shape)),
        time=time,
        order=facts["order"],
        coordinates={
            "distance since the step": Coordinate(position - s["step_position"], "m", local=True)
        },
        units=data.runs.units,
        roughness=roughness_of(position, data.reference.load),
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
        wheel_turn=angle + facts["start"][:, None],
        signals={k: np.broadcast_to(v.mean(axis=0)[:1], position.shape).copy()
                 for k, v in data.signals.items()},
        side_force=np.zeros(count),
        grids=grid_groups([("planned",)] * count),
    )  # fmt: skip
