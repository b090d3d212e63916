# SPDX-License-Identifier: Apache-2.0
"""Carcass stiffness per operating condition with the weights of (7.25), and what follows."""

from __future__ import annotations

from collections.abc import Sequence

from flatplank_data.errors import FlatplankError

from ..models.contact import TOYO, ContactGeometry
from .carcass_joint import solve_jointly
from .carcass_problem import carcass_problem, search_carcass
from .carcass_report import CarcassFit, report
from .mean_response import balanced, shared_fits
from .runs import StepRun


def fit_carcass(
    runs: Sequence[StepRun],
    *,
    geometry: ContactGeometry = TOYO,
    friction: float | None = None,
    tread_stiffness: float | None = None,
    bounds: tuple[float, float] = (2e4, 5e6),
    refine_curve: bool = True,
    longitudinal: bool = True,
) -> CarcassFit:
    """Identify c_cx [N/m] from all runs of one condition (7.25), (7.26).

    `friction` mu (None: largest steady force over load, as in section 7.2), `tread_stiffness` c_px
    [N/m2] (None: tied to the slip stiffness of the steady curve). `refine_curve`: steady forces
    under this model; False keeps the asymptotes of the linear fits, as the thesis does.
    """
    if len({r.condition for r in runs}) != 1 or len({r.level for r in runs}) < 3:
        raise FlatplankError(
            "the carcass stiffness needs three or more slip levels of one condition",
            runs[0].place if runs else "",
            "add slip levels",
        )
    runs = balanced(runs)
    fits = shared_fits(runs)
    problem = carcass_problem(
        runs,
        fits,
        geometry=geometry,
        friction=friction,
        tread_stiffness=tread_stiffness,
        longitudinal=longitudinal,
    )
    solution = search_carcass(problem, bounds)
    state, done = solve_jointly(problem, float(solution.x[0]), bounds, refine_curve)
    low, high = (abs(state.c_cx - b) <= 1e-6 * b for b in bounds)
    edge = "lower" if low else "upper" if high else ""
    return report(runs, fits, state, edge, done and solution.converged)
