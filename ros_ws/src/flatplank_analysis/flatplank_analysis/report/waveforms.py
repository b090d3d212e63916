# SPDX-License-Identifier: Apache-2.0
"""Runs whose slip is no step: the linear model driven by the measured slip, frequency response."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from flatplank_analysis.identify.least_squares import solve
from flatplank_analysis.identify.quality import rmse
from flatplank_analysis.identify.runs import StepRun, step_run
from flatplank_analysis.models.linear import LinearX
from flatplank_analysis.post.filtering import low_pass
from flatplank_analysis.post.frequency import frequency_response
from flatplank_analysis.steady.rolling_radius import BRAKING
from flatplank_data.errors import FlatplankError
from flatplank_data.table import MeasurementTable

PERIODIC = ("sine", "triangle")
SPACING = 0.005
"""grid of the fit [m]"""
SLIP_CUTOFF = 40.0
"""low-pass of the slip, which is a derivative of encoder counts [1/m]"""
SHORT = 3.0
"""2 pi sigma over the wavelength from which on a wave tells C/sigma only: |1 + i 3| is 3 to 5 %"""
START = np.array([0.4, 9e4])
LOWER, UPPER = np.array([0.005, 0.0]), np.array([5.0, 1e7])


def waveform_run(table: MeasurementTable) -> dict[str, Any]:
    """Linear model of any waveform: sigma [m] and C [N] by least squares over the whole run."""
    run = _until_braking(step_run(table))
    first = float(np.mean(run.fx[run.distance < 0.0])) if np.any(run.distance < 0.0) else 0.0
    inputs = run.inputs(SPACING, first)
    x, (force,) = run.grid(SPACING, run.fx[None])

    def residuals(lanes: np.ndarray) -> np.ndarray:
        return LinearX().simulate(lanes, inputs)[:, 0] - force

    found = solve(residuals, START, LOWER, UPPER, START)
    modelled = force + found.residual
    slip = _slip(run, x)
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
    return out | {"determined": 2.0 * np.pi * longest * out["sigma"] < SHORT}


def _until_braking(run: StepRun) -> StepRun:
    """Without the end, where plank and wheel stop one after the other: a slip nobody asked for."""
    keep = run.distance <= run.distance[-1] - BRAKING
    names = ("distance", "fx", "fy", "mz", "fz", "slip")
    return replace(run, **{name: getattr(run, name)[keep] for name in names})


def _slip(run: StepRun, x: np.ndarray) -> np.ndarray:
    """Slip over distance: derivative of the rim's slip travel, low-passed."""
    travel = np.interp(x, run.distance, run.slip)
    return low_pass(np.gradient(travel, x), SPACING, SLIP_CUTOFF)


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
