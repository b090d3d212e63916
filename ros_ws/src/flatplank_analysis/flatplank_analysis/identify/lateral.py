# SPDX-License-Identifier: Apache-2.0
"""The lateral transient: what a tire that starts to roll at a slip angle says of sigma_y, c_cy.

On the flat plank the slip angle is set before the road moves, so the step in side slip is the
start of the motion. A lateral run is the same kind of object as a slip-step run: -Fy in the place
of Fx, tan(alpha) in the place of kappa, the slip angle as level. All fits in x then serve in y.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..data.table import MeasurementTable
from ..errors import FlatplankError
from .carcass import fit_carcass
from .carcass_report import CarcassFit
from .grid import SPACING, bin_means
from .runs import StepRun

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
    columns = np.array([-table["fy"], table["fz"], np.nan_to_num(table.get("mz"))])
    x, (force, fz, mz) = bin_means(x[:last], columns[:, first : first + last], spacing)
    slip = math.tan(alpha)
    return StepRun(
        name=info.name,
        condition=info.condition.operating_point._replace(alpha_deg=math.nan),
        level=info.alpha_deg,
        kappa=slip,
        distance=x,
        fx=force,
        fy=np.zeros_like(x),
        mz=mz,
        fz=fz,
        slip=slip * x,
        gamma=math.radians(info.gamma_deg),
        pressure=info.pressure * 1e5,
        start=info.start,
    )


def fit_lateral_carcass(runs: Sequence[StepRun], **options: Any) -> CarcassFit:
    """c_cy [N/m], cornering stiffness [N/rad] and sigma_y [m] from lateral runs of one condition.

    `options` as for `fit_carcass`.
    """
    found = fit_carcass(runs, longitudinal=False, **options)
    changes = {name: replace(getattr(found, name), name=other) for name, other in RENAMED.items()}
    bias = {RENAMED[name]: value for name, value in found.model_bias.items()}
    stiffness = replace(changes["slip_stiffness"], unit="N/rad")
    return replace(found, model_bias=bias, **(changes | {"slip_stiffness": stiffness}))
