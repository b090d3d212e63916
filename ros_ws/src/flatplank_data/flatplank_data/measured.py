# SPDX-License-Identifier: Apache-2.0
"""Derives values of the run record from the samples of a run, and compares them with its record.

Slip, start of the step and rolling radius are those that slip control used; load, angles and speed
are measured. What follows a stop of the wheel counts for nothing.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from flatplank_data.naming import STEPS
from flatplank_data.problem import Problem
from flatplank_data.record_checks import default_of
from flatplank_data.run_record import RunRecord
from flatplank_data.stops import WheelStop, road_moves, speed_of, wheel_stop

UNKNOWN = "unknown"
"""name of an unnamed tire or measurement"""
SLIP, FREE_ROLLING = "slip", "free_rolling"
VARYING = "varying"
"""name of an unknown waveform, whose slip varies after its start"""
LOAD_STEP = 50.0
"""rounding of a measured load, so that repeats get one condition [N]"""
ANGLE_STEP = 0.1
"""rounding of measured angles [deg]"""
START_TOLERANCE = 10.0
"""tolerance of the three start angles of the wheel (0, 120, 240 deg) [deg]"""
SAME_KAPPA = 0.002
"""slips that differ by less are equal [-]"""
SAME_RADIUS = 1e-5
"""rolling radii that differ by less are equal [m]"""
SAME_PLACE = 1e-3
"""step positions that differ by less are equal [m]"""

PARTS = 20
"""parts in which a signal is looked at to see where it has settled"""
ROUNDED = {
    "fz": ("fz", 1.0, LOAD_STEP, "N"),
    "alpha_deg": ("steer_angle", 180.0 / math.pi, ANGLE_STEP, "deg"),
    "gamma_deg": ("total_camber", 180.0 / math.pi, ANGLE_STEP, "deg"),
}
"""key -> column, factor from SI, rounding and unit"""
STOPPED = "stopped"
"""status of a run whose wheel was stopped on the way"""
NO_TEXTS: Mapping[int, str] = {}

Columns = Mapping[str, np.ndarray]
Facts = dict[str, Any]


def measured_facts(
    columns: Columns,
    stop_texts: Mapping[int, str] = NO_TEXTS,
    waveforms: Sequence[Mapping[str, Any]] = (),
) -> Facts:
    """Values for keys of the run record, as far as the samples determine them.

    stop_texts: reason of a stop of the wheel -> its text. waveforms: those that were set, in
    order: name, start_position [m], parameters. `notes` says what was not constant.
    """
    if "plank_position" not in columns or "time" not in columns:
        return {}
    position, time = columns["plank_position"], columns["time"]
    if len(time) < 10 or np.ptp(position) < 0.01:
        return {"measurement": UNKNOWN}
    moving = road_moves(columns)
    facts: Facts = {}
    if stop := wheel_stop(columns):
        facts |= {"status": STOPPED, "stop_reason": stop_text(stop, stop_texts)}
        moving = moving & (np.arange(len(time)) < stop.row)
    if moving.sum() < 10:
        return facts | {"measurement": UNKNOWN}
    speed = float(np.median(speed_of(time, position)[moving]))
    facts["direction"] = "forward" if speed >= 0.0 else "reverse"
    facts["speed"] = round(abs(speed), 4)
    facts |= _control(columns, moving, waveforms)
    before = moving & (position < facts.get("step_position", math.inf))
    rolled = before if before.sum() >= 10 else moving
    facts |= _load_and_angles(columns, rolled)
    return facts | _start(columns)


def stop_text(stop: WheelStop, texts: Mapping[int, str] = NO_TEXTS) -> str:
    """A stop of the wheel in words."""
    why = texts.get(stop.code, "")
    return f"the wheel was stopped at {stop.position:.2f} m" + (f": {why}" if why else "")


def _control(
    columns: Columns, moving: np.ndarray, waveforms: Sequence[Mapping[str, Any]]
) -> Facts:
    """Which control was active while the plank moved, and its set-points."""
    if _was_active(columns, "controller_error", moving):
        return {"measurement": FREE_ROLLING}
    if not _was_active(columns, "slip_reference", moving):
        return {"measurement": UNKNOWN}
    facts: Facts = {"measurement": SLIP}
    start = _settled(columns, "slip_start", moving, SAME_PLACE)
    radius = _settled(columns, "slip_radius", moving, SAME_RADIUS)
    if math.isfinite(radius):
        facts["effective_rolling_radius"] = radius
    if not math.isfinite(start):
        return facts
    facts["step_position"] = start
    asked = columns["slip_reference"][moving & (columns["plank_position"] > start)]
    asked = asked[np.isfinite(asked)]
    if asked.size and np.ptp(asked) < SAME_KAPPA:
        kappa = round(float(np.median(asked)), 6)
        facts |= {"kappa": kappa, "waveform": {"name": "step", "kappa": kappa}}
    elif asked.size:
        facts |= _waveform(waveforms, start)
    return facts


def _waveform(waveforms: Sequence[Mapping[str, Any]], start: float) -> Facts:
    """The last of the waveforms that were set to start there [m]."""
    there = [w for w in waveforms if abs(w.get("start_position", math.nan) - start) <= SAME_PLACE]
    if not there:
        return {"waveform": {"name": VARYING}}
    last = there[-1]
    values = dict(last.get("parameters") or {})
    slip = {"kappa": values["kappa"]} if "kappa" in values else {}
    return {"waveform": {"name": last.get("name", VARYING), **values}, **slip}


def _was_active(columns: Columns, name: str, moving: np.ndarray) -> bool:
    return name in columns and bool(np.isfinite(columns[name][moving]).mean() > 0.5)


def _settled(columns: Columns, name: str, rolled: np.ndarray, step: float) -> float:
    """The settled value of a column; NaN without one."""
    values = columns[name][rolled] if name in columns else np.zeros(0)
    values = values[np.isfinite(values)]
    return settled(values, step)[0] if values.size else math.nan


def settled(values: np.ndarray, step: float) -> tuple[float, float]:
    """Median of the settled part of a signal (n,), and by how much its two halves differ.

    The settled part is the end of the signal, from where it stays within a rounding step of what
    its last quarter has, or within the width of that quarter.
    """
    parts = np.array([np.median(p) for p in np.array_split(values, min(PARTS, len(values)))])
    late = parts[-max(len(parts) // 4, 1) :]
    reach = max(step, float(np.ptp(late)))
    away = np.flatnonzero(np.abs(parts - np.median(late)) > reach)
    first = int(away[-1]) + 1 if away.size else 0
    kept = values[first * len(values) // len(parts) :]
    early, end = kept[: (len(kept) + 1) // 2], kept[len(kept) // 2 :]
    return float(np.median(kept)), float(np.median(end) - np.median(early))


def _load_and_angles(columns: Columns, rolled: np.ndarray) -> Facts:
    facts: Facts = {}
    notes = []
    for key, (name, factor, step, unit) in ROUNDED.items():
        values = columns[name][rolled] if name in columns else np.zeros(0)
        values = factor * values[np.isfinite(values)]
        if not values.size:
            continue
        value, change = settled(values, step)
        facts[key] = round(round(value / step) * step, 6) + 0.0
        if abs(change) > step:
            notes.append(f"{key} is not constant: it changes by {change:+.3g} {unit}")
    if facts.get("fz", 1.0) <= 0.0:
        del facts["fz"]  # not loaded
    return facts | ({"notes": "; ".join(notes)} if notes else {})


def _start(columns: Columns) -> Facts:
    """Start position 1, 2 or 3 when the wheel began near that start angle."""
    if "wheel_angle" not in columns or not math.isfinite(columns["wheel_angle"][0]):
        return {}
    thirds = math.degrees(float(columns["wheel_angle"][0])) / 120.0
    near = abs(thirds - round(thirds)) * 120.0 < START_TOLERANCE
    return {"start": round(thirds) % 3 + 1} if near else {}


def is_rolling_run_without_load(info: RunRecord) -> bool:
    """True when a record has no load although the tire rolls: nobody has filled the record in."""
    return info.measurement in (SLIP, FREE_ROLLING, UNKNOWN) and not info.fz > 0.0


def missing_keys(info: RunRecord, record: str) -> list[Problem]:
    """A remark on keys that no instrument measures and the record lacks, if there are any.

    `record`: file to write them to.
    """
    rolls = info.measurement in (SLIP, FREE_ROLLING)
    lacking = {
        "tire": info.tire in ("", UNKNOWN),
        "pressure": rolls and not info.pressure > 0.0,
        "measurement": info.measurement == UNKNOWN,
    }
    keys = [key for key, lacks in lacking.items() if lacks]
    remedy = f"write {' and '.join(f'{key}:' for key in keys)} in its {record}"
    what = f"{' and '.join(keys)} unknown: not stated"
    return [Problem(info.file, what, remedy=remedy, fatal=False)] if keys else []


def with_measured_values(given: Mapping[str, Any], measured: Mapping[str, Any]) -> dict[str, Any]:
    """The record's keys `given`; those that are missing or have defaults get `measured` values."""
    defaults = {f.name: default_of(f) for f in dataclasses.fields(RunRecord)}
    silent = {
        key
        for key in measured
        if given.get(key) in (None, "", {}, 0, 0.0, defaults.get(key), "forward")
    }
    return {**given, **{key: measured[key] for key in silent}}


def with_values_in_use(
    info: RunRecord, measured: Mapping[str, Any]
) -> tuple[RunRecord, list[Problem]]:
    """The record with the radius and step position in use, and a remark on each difference.

    A difference in slip or control is fatal, because the run would count in the wrong condition.
    """
    problems = [
        Problem(info.file, text, f"key '{key}'", "correct the run record")
        for key, text in _contradictions(info, measured)
    ]
    changes = {}
    for key, same in (("effective_rolling_radius", SAME_RADIUS), ("step_position", SAME_PLACE)):
        given, found = getattr(info, key), measured.get(key, math.nan)
        if info.measurement != SLIP or not abs(found - given) > same:
            continue
        changes[key] = found
        unit, factor = ("mm", 1e3) if key == "effective_rolling_radius" else ("m", 1.0)
        in_use = f"{factor * found:.6g} {unit}"
        text = f"{factor * given:.6g} {unit} stated, {in_use} was in use and is used"
        problems.append(Problem(info.file, text, f"key '{key}'", "", fatal=False))
    return dataclasses.replace(info, **changes) if changes else info, problems


def _contradictions(info: RunRecord, measured: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Keys that contradict the samples, each with the reason."""
    found = measured.get("measurement", UNKNOWN)
    if found != UNKNOWN and info.measurement in {SLIP, FREE_ROLLING} - {found}:
        return [("measurement", f"{info.measurement} stated, but {found} was on")]
    if not info.is_step or found != SLIP:
        return []
    waveform = info.waveform or {}
    name = measured.get("waveform", {}).get("name")
    if name and name not in STEPS and "length" not in waveform:
        return [("waveform", "a step stated, but the slip asked for was not constant")]
    kappa = measured.get("kappa", math.nan)
    if abs(kappa - info.kappa) > SAME_KAPPA:
        return [("kappa", f"{100 * info.kappa:+g} % stated, but {100 * kappa:+g} % was asked for")]
    return []
