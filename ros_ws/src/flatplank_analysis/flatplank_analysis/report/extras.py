# SPDX-License-Identifier: Apache-2.0
"""Results of the measurements without a slip step: stiffness, footprints, unloaded turns, free
rolling, and waveforms (linear model driven by the measured slip, frequency response).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from flatplank_analysis.identify.least_squares import solve
from flatplank_analysis.identify.results import rmse
from flatplank_analysis.identify.runs import StepRun, step_run
from flatplank_analysis.kinds.camber_sweep import camber_sweep
from flatplank_analysis.kinds.cleat import cleat
from flatplank_analysis.kinds.parking import parking
from flatplank_analysis.kinds.turning import turning
from flatplank_analysis.models.linear import LinearX
from flatplank_analysis.post.frequency import frequency_response
from flatplank_analysis.post.gridding import SPACING, low_pass, on_grid
from flatplank_analysis.post.motion import until_stop
from flatplank_analysis.starts import mean_over_starts
from flatplank_analysis.steady.rolling_radius import BRAKING, FREE_WHEEL
from flatplank_analysis.steady.settling import REFERENCE_FORCE, fit_exponential
from flatplank_analysis.steady.stiffness import (
    fit_contact_length,
    locked_friction,
    standing_lateral_stiffness,
    static_longitudinal_stiffness,
    vertical_stiffness,
)
from flatplank_analysis.steady.transmission import friction_torque
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError
from flatplank_data.problem import problem_from_error
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable

PERIODIC = ("sine", "triangle")
WAVE_SPACING = 0.005
"""grid spacing of the fit [m]"""
SLIP_CUTOFF = 40.0
"""low-pass of the slip, which is a derivative of encoder counts [1/m]"""
SHORT_WAVE = 3.0
"""2 pi sigma / wavelength above which a wave gives only C/sigma: |1 + 3i| is 3 within 6 %"""
WAVE_START = np.array([0.4, 9e4])
WAVE_LOWER, WAVE_UPPER = np.array([0.005, 0.0]), np.array([5.0, 1e7])

Found = dict[str, Any]
Extra = Callable[[Campaign, list[MeasurementTable], Mapping[str, Any]], Found]
STANDING: dict[str, tuple[str, Callable[[MeasurementTable], float]]] = {
    "stiffness_longitudinal": ("C_x", static_longitudinal_stiffness),
    "stiffness_lateral": ("C_y", standing_lateral_stiffness),
    "locked_wheel": ("μ", locked_friction),
}
"""kind of measurement -> result of a standing tire, and its function"""
KINDS = {"stiffness_vertical": "stiffness"} | dict.fromkeys(STANDING, "standing")
"""kinds of measurement that are evaluated under another key of `EXTRAS`"""
RUN_BY_RUN: dict[str, Callable[[MeasurementTable], Any]] = {
    "cleat": cleat,
    "parking": parking,
    "turning": turning,
    "camber_sweep": camber_sweep,
}
"""kind of measurement -> evaluation of a single run"""


def other_measurements(
    campaign: Campaign, kinds: Sequence[str] = (), free_radius: float = math.nan
) -> Found:
    """Results by name; a run that cannot be used is noted among the campaign's problems.

    `kinds`: keys of `EXTRAS`, by default all; `free_radius` R0 [m] of the tire record, for
    footprints whose run record has none.
    """
    known = {"free_radius": free_radius}
    found: Found = {}
    for kind, function in EXTRAS.items():
        if kinds and kind not in kinds:
            continue
        runs = campaign.where(partial(_is_of, kind))
        if tables := list(runs.tables()):
            found |= function(campaign, tables, known | found)
    return found


def stiffness_runs(campaigns: Iterable[Campaign]) -> list[Found]:
    """Results of the vertical stiffness runs of all campaigns."""
    found = (other_measurements(c, ("stiffness",)) for c in campaigns)
    return [run for one in found for run in one.get("vertical_stiffness", [])]


def measured_at_rest(campaigns: Sequence[Campaign], free_radius: float) -> Found:
    """Vertical stiffness runs and footprints of all campaigns, evaluated together."""
    found: Found = {"vertical_stiffness": stiffness_runs(campaigns)}
    tables = [t for c in campaigns for t in c.where(partial(_is_of, "footprint")).tables()]
    known = {"free_radius": free_radius} | found
    return found | (_footprint(campaigns[0], tables, known) if tables else {})


def _is_of(kind: str, info: RunRecord) -> bool:
    return kind_of(info) == kind


def kind_of(info: RunRecord) -> str:
    """Key of `EXTRAS`: the measurement, or `waveform` for slip that is no forward step."""
    if info.measurement == "slip" and not info.is_step:
        return "waveform"
    return KINDS.get(info.measurement, info.measurement)


def _rows(name: str, result_of: Callable[[MeasurementTable], Any]) -> Extra:
    """A result under `name` with a row per run; a run that cannot be evaluated is noted."""

    def evaluate(campaign: Campaign, tables: list[MeasurementTable], _: Mapping) -> Found:
        rows = []
        for table in tables:
            try:
                rows.append(result_of(table))
            except FlatplankError as error:
                campaign.add_problem(problem_from_error(error, table.info.file))
        return {name: rows} if rows else {}

    return evaluate


def _stiffness(table: MeasurementTable) -> dict[str, Any]:
    c = vertical_stiffness(table)
    thin = slice(None, None, max(len(table) // 800, 1))
    return {
        "run": table.info.name,
        "pressure": table.info.pressure,
        "start": table.info.start,
        "loading": c.loading,
        "unloading": c.unloading,
        "mean": c.mean,
        "window": c.window,
        "loaded_radius": table["loaded_radius"][thin],
        "fz": table["fz"][thin],
    }


def inside_window(run: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray, float]:
    """Loaded radii [m] and loads [N] of a vertical stiffness run inside its window, and r_0 [m].

    r_0 is where the run's own line reaches Fz = 0: an error of 1 mm in a radius from another
    source would be 6 % of the stiffness.
    """
    radius, force = np.asarray(run["loaded_radius"]), np.asarray(run["fz"])
    inside = (radius >= run["window"][0]) & (radius <= run["window"][1]) & (force > 0.0)
    radius, force = radius[inside], force[inside]
    return radius, force, float(np.mean(radius + force / run["mean"]))


def _standing(table: MeasurementTable) -> dict[str, Any]:
    """C_x, C_y or friction of the standing tire."""
    quantity, value_of = STANDING[table.info.measurement]
    value = value_of(table)
    if not np.isfinite(value):
        what = f"{quantity} cannot be told: the force hardly changes over the travel"
        raise FlatplankError(what, table.info.file, "let the road go on until the tire slides")
    facts = {n: getattr(table.info, n) for n in ("name", "fz", "pressure", "gamma_deg", "start")}
    return {"quantity": quantity, "value": value} | facts


def _footprint(campaign: Campaign, tables: list[MeasurementTable], found: Mapping) -> Found:
    """Half contact length over load; (7.20) is fitted where C_z of that pressure is known."""
    runs: dict[float, list[Found]] = {}
    for run in found.get("vertical_stiffness", []):
        runs.setdefault(run["pressure"], []).append(run)
    stiffness = {
        pressure: float(mean_over_starts([r["mean"] for r in own], [r["start"] for r in own]))
        for pressure, own in runs.items()
    }
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


def _unloaded(campaign: Campaign, tables: list[MeasurementTable], _: Mapping) -> Found:
    try:
        return {"friction_torque": friction_torque(tables)}
    except FlatplankError as error:
        campaign.add_problem(problem_from_error(error, tables[0].info.file))
        return {}


def _free_rolling(table: MeasurementTable) -> dict[str, Any]:
    """Settling distance (Appendix E) and steady error over the last 1.5 m (section 5.6).

    A wheel without flexplates has no controller: its force is that of its own resistance, and
    nothing settles.
    """
    grid = on_grid(until_stop(table), ["fx"])
    force = grid["fx"][np.isfinite(grid["fx"])]
    steady = float(force[-round(1.5 / SPACING) :].mean())
    free = table.info.r_e_source == FREE_WHEEL
    reference = math.nan if free else REFERENCE_FORCE
    fit = None if free else fit_exponential(grid.position, grid["fx"])
    return {
        "run": table.info.name,
        "fz": table.info.fz,
        "reference": reference,
        "settling_distance": math.nan if fit is None else fit.settles_at(reference),
        "fit": fit,
        "steady_force": steady,
        "steady_error": steady / reference - 1.0,
        "position": grid.position[::20],
        "fx": grid["fx"][::20],
    }


def waveform_run(table: MeasurementTable) -> dict[str, Any]:
    """Linear model of any waveform: sigma [m] and C [N] by least squares over the whole run."""
    run = _until_braking(step_run(table))
    first = float(np.mean(run.fx[run.distance < 0.0])) if np.any(run.distance < 0.0) else 0.0
    inputs = run.inputs(WAVE_SPACING, first)
    x, (force,) = run.grid(WAVE_SPACING, run.fx[None])

    def residuals(sets: np.ndarray) -> np.ndarray:
        return LinearX().simulate(sets, inputs)[:, 0] - force

    found = solve(residuals, WAVE_START, WAVE_LOWER, WAVE_UPPER, WAVE_START)
    modelled = force + found.residual
    # slip over distance: derivative of the rim's slip travel, low-passed
    travel = np.interp(x, run.distance, run.slip)
    slip = low_pass(np.gradient(travel, x), WAVE_SPACING, SLIP_CUTOFF)
    waveform = dict(table.info.waveform or {})
    out = {
        "run": table.info.name,
        "waveform": str(waveform.get("name", "")),
        "fz": table.info.fz,
        "sigma": float(found.x[0]),
        "slip_stiffness": float(found.x[1]),
        "rmse": rmse(force, modelled),
        "distance": x,
        "slip": slip,
        "fx": force,
        "model": modelled,
    }
    if out["waveform"] not in PERIODIC:
        return out | {"determined": True}
    out |= _frequency(out)
    longest = float(np.min(out.get("frequency", np.inf)))
    return out | {"determined": 2.0 * np.pi * longest * out["sigma"] < SHORT_WAVE}


def _until_braking(run: StepRun) -> StepRun:
    """The run without its end, where plank and wheel stop one after the other, and so slip."""
    keep = run.distance <= run.distance[-1] - BRAKING
    names = ("distance", "fx", "fy", "mz", "fz", "slip")
    return replace(run, **{name: getattr(run, name)[keep] for name in names})


def _frequency(found: dict[str, Any]) -> dict[str, Any]:
    skip = min(3.0 * found["sigma"], 0.4 * float(np.ptp(found["distance"])))
    try:
        response = frequency_response(found["distance"], found["slip"], found["fx"], skip)
    except FlatplankError as error:
        return {"why_no_frequency_response": error.what}
    sigma, stiffness = response.first_order()
    return {
        "frequency": response.frequency,
        "gain": response.gain,
        "phase_deg": response.phase_deg,
        "sigma_by_frequency": sigma,
        "slip_stiffness_by_frequency": stiffness,
    }


def _single_run_result(
    result_of: Callable[[MeasurementTable], Any], table: MeasurementTable
) -> Found:
    return {"run": table.info.name, "condition": table.info.condition, "found": result_of(table)}


EXTRAS: dict[str, Extra] = {
    "stiffness": _rows("vertical_stiffness", _stiffness),
    "standing": _rows("standing", _standing),
    "footprint": _footprint,
    "unloaded_turn": _unloaded,
    "free_rolling": _rows("free_rolling", _free_rolling),
    "waveform": _rows("waveforms", waveform_run),
} | {kind: _rows(kind, partial(_single_run_result, of)) for kind, of in RUN_BY_RUN.items()}
"""kind of measurement -> its evaluation, in this order"""
