# SPDX-License-Identifier: Apache-2.0
"""Finds columns whose values are in another unit than the one that the file states or implies.

A run measures the same thing several times: the rim travels as far as the road, a speed is a way
over a time, the load is the nominal one. Each such relation is a quotient that is 1. A wrong unit
of one column multiplies the quotients that contain this column by the ratio of the units. The unit
is wrong where another one explains the quotients better (sum of the absolute logarithms); no
tolerance is needed, because units are further apart than what a run is off its nominal values.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from flatplank_data.force_units import of_forces
from flatplank_data.machine import FAST, GEAR_RATIO, SLOW, USUAL_RADIUS
from flatplank_data.standing_units import of_footprint, of_loading, of_standing
from flatplank_data.table import COLUMN_UNITS, MeasurementTable
from flatplank_data.unit_relations import COARSE, Relation, relation
from flatplank_data.units import units_of

STANDS = 0.05
"""a wheel whose rim travels less than this share of the road stands [-]"""
ALIKE = 0.02
"""difference of two sums below which both units explain the quotients"""


@dataclass(frozen=True)
class WrongUnit:
    """A column and the unit that its values have."""

    column: str
    unit: str
    expected: str
    text: str
    """the quotient that shows it"""


def wrong_units(table: MeasurementTable) -> list[WrongUnit]:
    """Columns any one of which is in another unit; empty when SI explains the quotients best."""
    relations = [
        relation for part in RELATIONS.get(table.info.measurement, ()) for relation in part(table)
    ]
    found: list[tuple[float, WrongUnit]] = []
    for column in dict.fromkeys(name for r in relations for name in r.powers):
        shown = max((r for r in relations if column in r.powers), key=Relation.rest)
        for unit, factor in units_of(COLUMN_UNITS[column]).items():
            rest = sum(r.rest(column, factor) for r in relations)
            wrong = WrongUnit(column, unit, COLUMN_UNITS[column], shown.text)
            found.append((rest, wrong))
    least = min((rest for rest, _ in found), default=math.inf)
    if not sum(r.rest() for r in relations) > least + ALIKE:
        return []
    return [wrong for rest, wrong in found if rest <= least + ALIKE]


def _of_record(table: MeasurementTable, without: Sequence[str] = ()) -> Iterator[Relation]:
    """Columns that are held, and their nominal values; `without` those that change."""
    info = table.info
    nominal = {
        "fz": info.fz,
        "pressure": 1e5 * info.pressure,
        "side_slip_angle": math.radians(info.alpha_deg),
        "camber_angle": math.radians(info.gamma_deg),
        "total_camber": math.radians(info.gamma_deg),
        "loaded_radius": info.effective_rolling_radius,
    }
    for column, value in nominal.items():
        if table.has(column) and column not in without:
            unit = COLUMN_UNITS[column]
            text = f"'{column}' is {{}} in the mean, nominal {{}}"
            mean = float(np.nanmean(table[column]))
            yield from relation(text, mean, value, unit, {column: 1})


def _of_travel(table: MeasurementTable) -> Iterator[Relation]:
    """Ways, angles and speeds, up to the step, where the wheel rolls freely."""
    info = table.info
    rows = np.isfinite(table["plank_position"]) & np.isfinite(table.get("time"))
    before = rows & (table["plank_position"] <= info.step_position)
    free = bool(before.sum() > 2)
    part = table.rows(before if free else rows)
    if len(part) < 3:
        return
    way, time = float(np.ptp(part["plank_position"])), float(np.ptp(part["time"]))
    usual = 0.5 * math.log(FAST / SLOW)
    text, powers = "the plank runs at {}, usual are {}", {"plank_position": 1, "time": -1}
    speed = way / time if time else math.nan
    yield from _coarse(relation(text, speed, math.sqrt(SLOW * FAST), "m/s", powers), usual)
    text = "the plank travels {} by its speed, {} by its position"
    powers = {"plank_velocity": 1, "time": 1, "plank_position": -1}
    yield from relation(text, _integral(part, "plank_velocity"), way, "m", powers)
    yield from _of_turning(part, way * (1.0 if free else 1.0 + info.kappa))


def _of_turning(part: MeasurementTable, way: float) -> Iterator[Relation]:
    """Angle and speeds of a wheel whose rim travels a way [m]."""
    stated = part.info.effective_rolling_radius
    radius = stated if math.isfinite(stated) else USUAL_RADIUS
    turned = float(np.ptp(part["wheel_angle"])) if part.has("wheel_angle") else math.nan
    by_speed, by_motor = _integral(part, "wheel_velocity"), _integral(part, "motor_velocity")
    if np.fmin(abs(turned), abs(by_speed)) * radius < STANDS * way:
        return  # fmin: one of them may not be measured
    text = f"the rim travels {{}} at a radius of {radius:.3g} m, the plank {{}}"
    powers = {"wheel_angle": 1, "plank_position": -1}
    rim = relation(text, turned * radius, way, "m", powers)
    yield from rim if math.isfinite(stated) else _coarse(rim, 0.0)
    text, powers = text.replace("travels", "travels by its speed"), {
        "wheel_velocity": 1, "time": 1, "plank_position": -1,
    }  # fmt: skip
    rim = relation(text, by_speed * radius, way, "m", powers)
    yield from rim if math.isfinite(stated) else _coarse(rim, 0.0)
    text = "the wheel turns by {} by its motor, by {} by its own speed"
    powers = {"motor_velocity": 1, "wheel_velocity": -1}
    yield from relation(text, by_motor / GEAR_RATIO, by_speed, "rad", powers)


def _coarse(relations: Iterator[Relation], slack: float) -> Iterator[Relation]:
    """Relations that are known by their order of magnitude: they count only beyond it."""
    for one in relations:
        beyond = abs(one.off) > COARSE + slack
        yield dataclasses.replace(one, off=one.off if beyond else 0.0, below=slack, above=slack)


def _integral(table: MeasurementTable, column: str) -> float:
    """Integral of a column over time; NaN without it."""
    values = table.get(column)
    return float(0.5 * ((values[1:] + values[:-1]) * np.diff(table["time"])).sum())


_ROLLING = (_of_record, of_forces, _of_travel)
_LOADED = (partial(_of_record, without=("fz",)), of_loading)
_STANDING = (_of_record, of_standing)
RELATIONS: dict[str, tuple[Callable[[MeasurementTable], Iterator[Relation]], ...]] = {
    "slip": _ROLLING,
    "free_rolling": _ROLLING,
    "cleat": _ROLLING,
    "locked_wheel": (_of_record, of_forces),
    "stiffness": _LOADED,
    "stiffness_vertical": _LOADED,
    "stiffness_longitudinal": _STANDING,
    "stiffness_lateral": _STANDING,
    "footprint": (partial(_of_record, without=("fz", "pressure")), of_footprint),
}
"""kind of measurement -> what is known of it several times"""
