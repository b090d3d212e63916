# SPDX-License-Identifier: Apache-2.0
"""Orders of magnitude of a standing tire, which scale with its radius and its inflation pressure.

A tire is an air spring: it carries the pressure on its contact patch, and a membrane with the
pressure p has the stiffness pi p sqrt(D W) (D, W: diameter and width, Rotta 1949). Each is known
by its order of magnitude only, see `force_units`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from flatplank_data.force_units import largest, of_moments, usual_radius
from flatplank_data.table import MeasurementTable
from flatplank_data.unit_relations import COARSE, Relation, relation

SPRING = 2.7
"""stiffness over pressure times radius [-]: 213 kN/m at 2.5 bar and 311 mm of the thesis' tire;
3.4 for a membrane whose width is 0.6 of the radius"""
LOAD = 0.15
"""load over pressure times radius squared [-]; tire of the thesis: 3.7 kN at 2.5 bar"""
PATCH = 0.23
"""half of the contact length over the radius [-]; tire of the thesis: 71 mm at 3.7 kN"""


def of_loading(table: MeasurementTable) -> Iterator[Relation]:
    """Relations of a tire that is pressed onto the road."""
    radius = usual_radius(table)
    text = "'loaded_radius' is {} in the mean, usual is {}"
    yield from _about(text, _mean(table, "loaded_radius"), radius, "m", {"loaded_radius": 1})
    yield from _of_load(table)
    stroke = float(np.ptp(table["loaded_radius"]))
    pressure, powers = _pressure(table)
    text = "the load changes by {}, usual is {} at this stroke and pressure"
    change, powers = float(np.ptp(table["fz"])), powers | {"fz": 1, "loaded_radius": -1}
    yield from _about(text, change, SPRING * pressure * radius * stroke, "N", powers)


def of_standing(table: MeasurementTable) -> Iterator[Relation]:
    """Relations of a held wheel under which the road creeps."""
    yield from _of_load(table)
    load, (pressure, by) = _mean(table, "fz"), _pressure(table)
    spring = SPRING * pressure * usual_radius(table)
    across = abs(math.sin(math.radians(table.info.alpha_deg)))
    travel = float(np.ptp(table["plank_position"]))
    for name, share in {"fx": math.sqrt(1.0 - across**2), "fy": across}.items():
        text = f"'{name}' goes up to {{}}, usual is {{}} at this travel and pressure"
        usual, powers = spring * share * travel, by | {name: 1, "plank_position": -1}
        yield from _about(text, largest(table, name), usual, "N", powers)
        text = f"'{name}' goes up to {{}}, the load is {{}}"
        most, powers = largest(table, name), {name: 1, "fz": -1}
        yield from relation(text, most, load, "N", powers, below=math.inf, above=COARSE)
    yield from of_moments(table, load)


def of_footprint(table: MeasurementTable) -> Iterator[Relation]:
    """Relations of prints: the patch carries the pressure."""
    length, (pressure, by) = _mean(table, "half_length"), _pressure(table)
    text = "'half_length' is {} in the mean, usual is {}"
    yield from _about(text, length, PATCH * usual_radius(table), "m", {"half_length": 1})
    text = "'half_width' is {} in the mean, 'half_length' {}"
    powers = {"half_width": 1, "half_length": -1}
    yield from _about(text, _mean(table, "half_width"), length, "m", powers)
    text = "'fz' is {} in the mean, usual is {} on this length at this pressure"
    load, powers = _mean(table, "fz"), by | {"fz": 1, "half_length": -2}
    yield from _about(text, load, pressure * 4.0 * length**2, "N", powers)


def _of_load(table: MeasurementTable) -> Iterator[Relation]:
    pressure, powers = _pressure(table)
    usual = LOAD * pressure * usual_radius(table) ** 2
    text = "'fz' is {} in the mean, usual is {} at this pressure"
    yield from _about(text, _mean(table, "fz"), usual, "N", powers | {"fz": 1})


def _about(
    text: str, value: float, usual: float, unit: str, powers: dict[str, int]
) -> Iterator[Relation]:
    yield from relation(text, value, usual, unit, powers, COARSE, COARSE)


def _mean(table: MeasurementTable, name: str) -> float:
    return float(np.nanmean(np.abs(table[name]))) if table.has(name) else math.nan


def _pressure(table: MeasurementTable) -> tuple[float, dict[str, int]]:
    """Inflation pressure [Pa], and its power in a quotient: of the column, else of the record."""
    if table.has("pressure"):
        return _mean(table, "pressure"), {"pressure": -1}
    return 1e5 * table.info.pressure, {}
