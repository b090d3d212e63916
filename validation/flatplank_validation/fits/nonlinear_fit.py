# SPDX-License-Identifier: Apache-2.0
"""Nonlinear fit of 9 slips x 3 starts against scipy's solve_ivp with minimize.

Same equations (7.13-7.24, quasi-static in the patch mass), same data, same weights (7.25). Prints
both times, their ratio, and how far the two optima lie apart.

    python -m flatplank_validation.fits.nonlinear_fit
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import minimize

from flatplank_analysis.identify.carcass_problem import (
    CarcassProblem,
    carcass_problem,
    search_carcass,
)
from flatplank_analysis.models.nonlinear import LOWEST_SHARE
from flatplank_validation.fits.campaigns import Truth, simulate_runs
from flatplank_validation.fits.command import command

OPTIONS = {"method": "LSODA", "rtol": 1e-6, "atol": 1e-9}
"""Options of solve_ivp: its fastest method; the default tolerance misses the optimum by 4e-4."""
STOP = {"xatol": 2e-5, "fatol": 1e-5}
"""Options of minimize, in units of 1e5 N/m and of the initial cost; smaller changes of the cost
are integration errors, in which the search may not terminate."""


def reference_cost(problem: CarcassProblem) -> Callable[[np.ndarray], float]:
    """Sum of weighted squares over c_cx by scipy's own integrator, run by run."""
    law = problem.curve.law()
    slips = law.first + law.step * np.arange(law.values.shape[-1])
    forces = law.values.reshape(-1)
    slopes = np.gradient(forces, slips)
    fz, pressure = problem.inputs.fz[:, 0], problem.inputs.pressure[:, 0]
    half = problem.geometry.half_length(fz, pressure)
    theta = float(law.stiffness().item()) / (3.0 * problem.friction * fz)

    def one_run(stiffness: float, run: int, kappa: float, start: float) -> np.ndarray:
        a, limit = half[run], theta[run]

        def rate(_: float, state: np.ndarray) -> list[float]:
            slip = state[0]
            base = 1.0 + slip
            sigma = max(1.0 - limit * abs(slip) / base, LOWEST_SHARE) * a / base
            slope = np.interp(slip, slips, slopes)
            return [(kappa - slip) / (sigma + slope / stiffness)]

        first = [np.interp(start, forces, slips)]
        span = (0.0, float(problem.distance[-1]))
        found = solve_ivp(rate, span, first, t_eval=problem.distance, **OPTIONS)
        return np.interp(found.y[0], slips, forces)

    travel = problem.inputs.travel[:, 1:].sum(axis=1)
    kappas = problem.inputs.slip_x[:, 1:].sum(axis=1) / travel

    def cost(stiffness: np.ndarray) -> float:
        total = 0.0
        for run, kappa in enumerate(kappas):
            force = one_run(float(stiffness[0]) * 1e5, run, kappa, problem.inputs.start_fx[run])
            error = problem.weight[run] * (force - problem.measured[run])
            total += float(error @ error)
        return total

    return cost


def optimum_of(cost: Callable[[np.ndarray], float], near: float) -> float:
    """Minimum of a parabola through five costs, insensitive to integration errors."""
    x = near * (1.0 + np.array([-4e-3, -2e-3, 0.0, 2e-3, 4e-3]))
    curve = np.polyfit(x - near, [cost(np.array([v])) for v in x], 2)
    return near - curve[1] / (2.0 * curve[0])


def measure(repeats: int = 5, seed: int = 1) -> dict[str, float]:
    """Times [s], ratio and distance of the optima, measured in one run."""
    runs = simulate_runs(Truth(), np.random.default_rng(seed))
    problem = carcass_problem(runs)
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        solution = search_carcass(problem)
        times.append(time.perf_counter() - begin)
    ours = float(solution.x[0])
    begin = time.perf_counter()
    cost = reference_cost(problem)
    size = cost(np.array([2.0]))
    # Scaled to 1, so that the tolerances apply; gradients of solve_ivp are too coarse for
    # the default method, which stays at the start.
    found = minimize(lambda x: cost(x) / size, np.array([2.0]), method="Nelder-Mead", options=STOP)
    theirs_time = time.perf_counter() - begin
    theirs = optimum_of(lambda x: cost(x) / size, float(found.x[0])) * 1e5
    return {
        "runs": len(runs),
        "time_s": min(times),
        "scipy_time_s": theirs_time,
        "scipy_evaluations": float(found.nfev),
        "ratio": theirs_time / min(times),
        "c_cx": ours,
        "scipy_c_cx": theirs,
        "relative_difference": ours / theirs - 1.0,
    }


main = command(__doc__, lambda chosen: measure(chosen.repeats), repeats=5)

if __name__ == "__main__":
    main()
