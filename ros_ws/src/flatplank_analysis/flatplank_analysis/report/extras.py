# SPDX-License-Identifier: Apache-2.0
"""Results of the measurements that are no slip steps: stiffness, footprints, unloaded turns."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from flatplank_analysis.kinds.camber_sweep import camber_sweep
from flatplank_analysis.kinds.cleat import cleat
from flatplank_analysis.kinds.parking import parking
from flatplank_analysis.kinds.turning import turning
from flatplank_analysis.post.gridding import SPACING, on_grid
from flatplank_analysis.post.settling import REFERENCE_FORCE, fit_exponential
from flatplank_analysis.report.waveforms import waveform_run
from flatplank_analysis.steady.contact import fit_contact_length
from flatplank_analysis.steady.rolling_radius import FREE_WHEEL
from flatplank_analysis.steady.stiffness import (
    locked_friction,
    standing_lateral_stiffness,
    static_longitudinal_stiffness,
    vertical_stiffness,
)
from flatplank_analysis.steady.stopping import until_stop
from flatplank_analysis.steady.transmission import friction_torque
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError
from flatplank_data.problem import problem_of
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable

Found = dict[str, Any]
Extra = Callable[[Campaign, list[MeasurementTable], Mapping[str, Any]], Found]
#: kind of measurement -> what is made of it, in this order
EXTRAS: dict[str, Extra] = {}
STANDING: dict[str, tuple[str, Callable[[MeasurementTable], float]]] = {
    "stiffness_longitudinal": ("C_x", static_longitudinal_stiffness),
    "stiffness_lateral": ("C_y", standing_lateral_stiffness),
    "locked_wheel": ("μ", locked_friction),
}
"""kind of measurement -> what a standing tire tells, and how"""
KINDS = {"stiffness_vertical": "stiffness"} | dict.fromkeys(STANDING, "standing")
"""kinds of measurement that are evaluated under another key of `EXTRAS`"""
RUN_BY_RUN: dict[str, Callable[[MeasurementTable], Any]] = {
    "cleat": cleat,
    "parking": parking,
    "turning": turning,
    "camber_sweep": camber_sweep,
}
"""kind of measurement -> what a run of it tells by itself"""


def extra(measurement: str) -> Callable[[Extra], Extra]:
    """Register the evaluation of a kind of measurement."""

    def register(function: Extra) -> Extra:
        EXTRAS[measurement] = function
        return function

    return register


def other_measurements(
    campaign: Campaign, kinds: Sequence[str] = (), free_radius: float = math.nan
) -> Found:
    """Results by name; a run that cannot be used is noted among the campaign's problems.

    `kinds`: keys of `EXTRAS`, all without it; `free_radius` R0 [m] of the tire record, for
    footprints whose run record has none.
    """
    known = {"free_radius": free_radius}
    found: Found = {}
    for kind, function in EXTRAS.items():
        if kinds and kind not in kinds:
            continue
        runs = campaign.where(partial(_is_of, kind))
        tables = list(runs.tables())
        if tables:
            found |= function(campaign, tables, known | found)
    return found


def _is_of(kind: str, info: RunRecord) -> bool:
    return kind_of(info) == kind


def kind_of(info: RunRecord) -> str:
    """Key of `EXTRAS`: the measurement, or `waveform` for slip that is no forward step."""
    if info.measurement == "slip" and not info.is_step:
        return "waveform"
    return KINDS.get(info.measurement, info.measurement)


def _each(
    campaign: Campaign,
    tables: Iterable[MeasurementTable],
    function: Callable[[MeasurementTable], Any],
) -> list[tuple[MeasurementTable, Any]]:
    out = []
    for table in tables:
        try:
            out.append((table, function(table)))
        except FlatplankError as error:
            campaign.note(problem_of(error, table.info.file))
    return out


@extra("stiffness")
def _stiffness(campaign: Campaign, tables: list[MeasurementTable], _: Mapping) -> Found:
    runs = [
        {
            "run": table.info.name,
            "pressure": table.info.pressure,
            "loading": c.loading,
            "unloading": c.unloading,
            "mean": c.mean,
            "window": c.window,
            "loaded_radius": table["loaded_radius"][:: max(len(table) // 800, 1)],
            "fz": table["fz"][:: max(len(table) // 800, 1)],
        }
        for table, c in _each(campaign, tables, vertical_stiffness)
    ]
    return {"vertical_stiffness": runs} if runs else {}


@extra("standing")
def _standing(campaign: Campaign, tables: list[MeasurementTable], _: Mapping) -> Found:
    """C_x, C_y, friction of the standing tire, one row per run."""

    def one(table: MeasurementTable) -> dict[str, Any]:
        quantity, tell = STANDING[table.info.measurement]
        value = tell(table)
        if not np.isfinite(value):
            what = f"{quantity} cannot be told: the force hardly changes over the travel"
            raise FlatplankError(what, table.info.file, "let the road go on until the tire slides")
        facts = {n: getattr(table.info, n) for n in ("name", "fz", "pressure", "gamma_deg")}
        return {"quantity": quantity, "value": value} | facts

    rows = [value for _, value in _each(campaign, tables, one)]
    return {"standing": rows} if rows else {}


@extra("footprint")
def _footprint(campaign: Campaign, tables: list[MeasurementTable], found: Mapping) -> Found:
    """a over load; (7.20) is fitted where the vertical stiffness of that pressure is known."""
    stiffness = {r["pressure"]: r["mean"] for r in found.get("vertical_stiffness", [])}
    rows = []
    for table in tables:
        bar = table.get("pressure") / 1e5
        bar = np.where(np.isfinite(bar), bar, table.info.pressure)
        rows += list(
            zip(table["fz"], bar, table["half_length"], table.get("half_width"), strict=True)
        )
    fz, bar, a, b = (np.array(v) for v in zip(*rows, strict=True))
    out: Found = {"footprints": {"fz": fz, "pressure": bar, "half_length": a, "half_width": b}}
    cz = np.array([stiffness.get(round(float(p), 3), np.nan) for p in bar])
    known = np.isfinite(cz)
    if known.any():
        radius = float(tables[0].info.extra.get("free_radius", found["free_radius"]))
        fit = fit_contact_length(fz[known], a[known], cz[known], radius)
        out["contact_length"] = {
            "q_ra1": fit.q_ra1,
            "q_ra2": fit.q_ra2,
            "r_0": fit.radius,
            "rmse": fit.rmse,
            "remark": "" if fit.both else "q_ra2 not determined by one load: held at 0",
        }
    return out


@extra("unloaded_turn")
def _unloaded(campaign: Campaign, tables: list[MeasurementTable], _: Mapping) -> Found:
    try:
        curve = friction_torque(tables)
    except FlatplankError as error:
        campaign.note(problem_of(error, tables[0].info.file))
        return {}
    return {
        "friction_torque": {
            "speed": curve.speed,
            "torque": curve.torque,
            "scatter": curve.scatter,
        }
    }


@extra("free_rolling")
def _settling(campaign: Campaign, tables: list[MeasurementTable], _: Mapping) -> Found:
    """Settling distance (Appendix E) and steady error over the last 1.5 m (section 5.6).

    A wheel without flexplates has no controller: its force is that of its own resistance.
    """

    def one(table: MeasurementTable) -> dict[str, Any]:
        grid = on_grid(until_stop(table), ["fx"])
        fit = fit_exponential(grid.position, grid["fx"])
        force = grid["fx"][np.isfinite(grid["fx"])]
        last = force[-round(1.5 / SPACING) :]
        free = table.info.r_e_source == FREE_WHEEL
        reference = math.nan if free else REFERENCE_FORCE
        return {
            "run": table.info.name,
            "fz": table.info.fz,
            "reference": reference,
            "settling_distance": math.nan if free else fit.settles_at(reference),
            "p1": fit.p1,
            "p2": fit.p2,
            "p3": fit.p3,
            "steady_force": float(last.mean()),
            "steady_error": float(last.mean()) / reference - 1.0,
            "position": grid.position[::20],
            "fx": grid["fx"][::20],
        }

    return {"free_rolling": [value for _, value in _each(campaign, tables, one)]}


@extra("waveform")
def _waveforms(campaign: Campaign, tables: list[MeasurementTable], _: Mapping) -> Found:
    return {"waveforms": [value for _, value in _each(campaign, tables, waveform_run)]}


def _run_by_run(kind: str, tell: Callable[[MeasurementTable], Any]) -> Extra:
    """One row per run: its name, its condition, and what was found."""

    def evaluate(campaign: Campaign, tables: list[MeasurementTable], _: Mapping) -> Found:
        rows = [
            {"run": table.info.name, "condition": table.info.condition, "found": found}
            for table, found in _each(campaign, tables, tell)
        ]
        return {kind: rows} if rows else {}

    return evaluate


EXTRAS |= {kind: _run_by_run(kind, tell) for kind, tell in RUN_BY_RUN.items()}
