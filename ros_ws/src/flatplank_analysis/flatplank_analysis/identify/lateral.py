# SPDX-License-Identifier: Apache-2.0
"""The lateral transient: what a tire that starts to roll at a slip angle says of sigma_y, c_cy.

On the flat plank the slip angle is set before the road moves, so the step in side slip is the
start of the motion. A lateral run is the same kind of object as a slip-step run: -Fy in the place
of Fx and Fx in that of Fy, tan(alpha) in the place of kappa, the slip angle as level. All fits in
x then serve in y.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from flatplank_data.errors import FlatplankError
from flatplank_data.table import MeasurementTable

from .carcass import fit_carcass
from .carcass_report import CarcassFit
from .grid import SPACING, bin_means
from .runs import StepRun
from .steering_zero import TAIL, steering_zero, zero_warning

SMALL_STEP = 0.02
"""Largest slip whose step tells the slip stiffness at a slip angle [-]."""
STARTED = 5e-4
"""Travel after which the road counts as moving [m]."""
RENAMED = {"c_cx": "c_cy", "slip_stiffness": "cornering_stiffness", "sigma_x": "sigma_y"}


def lateral_run(table: MeasurementTable, spacing: float = SPACING) -> StepRun:
    """The part of a run from its start to the slip step, seen as a step in side slip."""
    info = table.info
    alpha = math.radians(info.alpha_deg)
    position = table["plank_position"]
    moving = np.flatnonzero(position > position[0] + STARTED)
    if not len(moving):
        raise FlatplankError("the road does not move", info.file, "leave this run out")
    first = moving[0]
    x = (position[first:] - position[first]) * math.cos(alpha)
    last = len(x)
    if info.kappa != 0.0 and math.isfinite(info.step_position):
        last = int(np.searchsorted(position[first:], info.step_position))
    columns = np.array(
        [-table["fy"], table["fz"], *(np.nan_to_num(table.get(name)) for name in ("mz", "fx"))]
    )
    x, (force, fz, mz, fx) = bin_means(x[:last], columns[:, first : first + last], spacing)
    slip = math.tan(alpha)
    return StepRun(
        name=info.name,
        condition=info.condition.operating_point._replace(alpha_deg=math.nan),
        level=info.alpha_deg,
        kappa=slip,
        distance=x,
        fx=force,
        fy=fx,
        mz=mz,
        fz=fz,
        slip=slip * x,
        gamma=math.radians(info.gamma_deg),
        pressure=info.pressure * 1e5,
        start=info.start,
        slip_stiffness=_own_step(table),
    )


def _own_step(table: MeasurementTable) -> float:
    """dFx/dkappa of the run's slip step [N]; NaN where it is none, or not a small one."""
    info, x = table.info, table["plank_position"]
    if not 0.0 < abs(info.kappa) <= SMALL_STEP or not table.has("fx"):
        return math.nan
    before = (x > info.step_position - TAIL) & (x < info.step_position)
    after = x > x[-1] - TAIL
    if x[-1] < info.step_position + 2.0 * TAIL or not before.any():
        return math.nan
    return float(np.mean(table["fx"][after]) - np.mean(table["fx"][before])) / info.kappa


def fit_lateral_carcass(runs: Sequence[StepRun], **options: Any) -> CarcassFit:
    """c_cy [N/m], cornering stiffness [N/rad] and sigma_y [m] from lateral runs of one condition.

    From runs at +alpha and -alpha the steering zero is found first, and taken off; without them
    cornering stiffness and c_cy carry a warning. `options` as for `fit_carcass`.
    """
    zero = steering_zero(runs)
    if zero is not None:
        runs = [zero.corrected(run) for run in runs]
    found = fit_carcass(runs, longitudinal=False, **options)
    changes = {name: replace(getattr(found, name), name=other) for name, other in RENAMED.items()}
    bias = {RENAMED[name]: value for name, value in found.model_bias.items()}
    changes["slip_stiffness"] = replace(changes["slip_stiffness"], unit="N/rad")
    warning = zero_warning([run.level for run in runs])
    for name in ("c_cx", "slip_stiffness"):
        changes[name] = changes[name].with_note(warning)
    beside = () if zero is None else (zero.zero, zero.ply)
    return replace(found, model_bias=bias, beside=beside, **changes)
