# SPDX-License-Identifier: Apache-2.0
"""Orders of magnitude of forces and moments, which scale with load and radius of the tire.

A tire pushes along the road with its slip stiffness, up to friction; without slip, with its
rolling resistance. The centre of the pressure lies in the contact patch, so no moment exceeds the
load times the radius, or what the force has at the wheel centre. A tire that slips to one side has
a trail. Each is known by its order of magnitude only: a unit a thousand times larger or smaller is
found, pounds for newtons are not.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from flatplank_data.machine import USUAL_RADIUS
from flatplank_data.table import MeasurementTable
from flatplank_data.unit_relations import COARSE, Relation, relation

STIFFNESS = 20.0
"""slip stiffness over load, along and across [1, 1/rad]; tire of the thesis: 94 kN at 3.7 kN"""
RESISTANCE = 0.01
"""rolling resistance over load [-]; tires of cars: 0.006 to 0.012 (classes of UN R117)"""
TRAIL = 0.1
"""pneumatic trail over radius [-]: a third of half the contact length (Pacejka 2012, 3.2.1)"""
ARMS = math.log(3.0)
"""a moment at the wheel centre is at most load times radius, plus the force at twice the load"""
MOMENTS = ("mx", "my", "mz")


def of_forces(table: MeasurementTable) -> Iterator[Relation]:
    """Relations of the forces and moments of a rolling or a locked wheel."""
    if not table.has("fz"):
        return
    info = table.info
    load = float(np.nanmean(np.abs(table["fz"])))
    locked = info.measurement == "locked_wheel"
    slips = {
        "fx": 1.0 if locked else abs(info.kappa),
        "fy": abs(math.tan(math.radians(info.alpha_deg))),
    }
    for name, slip in slips.items():
        share = min(STIFFNESS * slip, 1.0) or (RESISTANCE if name == "fx" else math.nan)
        text = f"'{name}' goes up to {{}}, usual is {{}} at this load and slip"
        powers = {name: 1, "fz": -1}
        yield from relation(
            text, largest(table, name), share * load, "N", powers, COARSE, above=math.inf
        )
    yield from of_moments(table, load)


def of_moments(table: MeasurementTable, load: float) -> Iterator[Relation]:
    """Relations of the moments of a tire under a load [N]."""
    radius = usual_radius(table)
    for name in MOMENTS:
        text = f"'{name}' goes up to {{}}, load times radius is {{}}"
        powers = {name: 1, "fz": -1}
        yield from relation(
            text, largest(table, name), load * radius, "N m", powers, below=math.inf, above=ARMS
        )
    if table.info.alpha_deg:
        text = "'mz' goes up to {}, side force times trail is {}"
        usual, powers = TRAIL * radius * largest(table, "fy"), {"mz": 1, "fy": -1}
        yield from relation(
            text, largest(table, "mz"), usual, "N m", powers, COARSE, above=math.inf
        )


def usual_radius(table: MeasurementTable) -> float:
    """Radius that the run record states, else that of the tire of the thesis [m]."""
    stated = table.info.effective_rolling_radius
    return stated if math.isfinite(stated) else USUAL_RADIUS


def largest(table: MeasurementTable, name: str) -> float:
    """Largest absolute value of a column; NaN without it."""
    return float(np.nanmax(np.abs(table[name]))) if table.has(name) else math.nan
