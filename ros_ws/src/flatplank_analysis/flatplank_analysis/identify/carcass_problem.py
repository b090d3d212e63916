# SPDX-License-Identifier: Apache-2.0
"""The carcass stiffness of one condition as a weighted least-squares problem (7.25), (7.26)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..models.base import RunInputs, stack_runs
from ..models.contact import TOYO, ContactGeometry
from ..models.nonlinear import NonlinearX
from ..models.steady_law import TableLaw
from .least_squares import Solution, solve
from .linear import LinearFit
from .mean_response import shared_fits
from .quality import transient_weights
from .runs import StepRun, by_level
from .steady_curve import SteadyCurve, curve_law, steady_curve

GROWTH = 1.06
"""Cells of the fit grow by this factor from the runs' own grid at the step ..."""
LARGEST_CELL = ((0.8, 0.008), (np.inf, 0.02))
"""... to this width [m] up to this distance [m]: the relaxation of the patch collapses early."""
LATE = 0.7
"""The last part of a run counts as settled even when its slope is not yet small."""
START = 2e5
"""Start value of c_cx [N/m] (section 7.2)."""


@dataclass(frozen=True)
class CarcassProblem:
    """Weighted residuals of all runs of one condition over (c_cx) and the curve's forces."""

    inputs: RunInputs
    distance: np.ndarray
    """Cell centres (samples,) [m] after the step."""
    measured: np.ndarray
    """Mean force per cell (runs, samples) [N]."""
    weight: np.ndarray
    """Root of the weights (7.25), summed over the cell (runs, samples)."""
    settled: np.ndarray
    """Samples per cell where the force has settled, else 0 (runs, samples)."""
    level: np.ndarray
    """Slip level of each run, as an index into the curve (runs,)."""
    curve: SteadyCurve
    geometry: ContactGeometry
    friction: float
    tread_stiffness: float | None
    longitudinal: bool = True

    def simulate(self, lanes: np.ndarray) -> np.ndarray:
        """Model force (lanes, runs, samples); lanes (lanes, 1 + k) of c_cx and curve forces."""
        law = curve_law(self.curve.kappa, lanes[:, 1:] if len(lanes) > 1 else lanes[0, 1:])
        return self.model(law).simulate(lanes[:, :1], self.inputs)

    def model(self, law: TableLaw) -> NonlinearX:
        """The model with this steady law."""
        return NonlinearX(
            lambda _: law,
            self.geometry,
            self.friction,
            self.tread_stiffness,
            longitudinal=self.longitudinal,
        )

    def residuals(self, stiffness: np.ndarray) -> np.ndarray:
        """For the search over c_cx alone: (lanes, 1) -> (lanes, runs * samples)."""
        force = self.model(self.curve.law()).simulate(stiffness, self.inputs)
        return (self.weight * (force - self.measured)).reshape(len(stiffness), -1)


def search_carcass(problem: CarcassProblem, bounds: tuple[float, float] = (2e4, 5e6)) -> Solution:
    """Minimise (7.26) over c_cx [N/m]."""
    low, high, start = (np.array([v]) for v in (*bounds, START))
    return solve(problem.residuals, start, low, high, start, 1e-7)


def carcass_problem(
    runs: Sequence[StepRun],
    fits: Sequence[LinearFit] | None = None,
    *,
    geometry: ContactGeometry = TOYO,
    friction: float | None = None,
    tread_stiffness: float | None = None,
    longitudinal: bool = True,
) -> CarcassProblem:
    """Data, weights (7.25) and steady curve of one condition, ready for the search."""
    fits = shared_fits(runs) if fits is None else fits
    curve = steady_curve(runs, fits)
    if friction is None:
        load = np.mean([run.mean_load for run in runs])
        friction = float(np.max(np.abs(curve.force)) / load)
    x, force, weight, settled = _measured(runs, fits)
    order = {value: i for i, value in enumerate(by_level(runs))}
    level = np.array([order[run.level] for run in runs])
    rows = [r.inputs_at(x, f.start_force.value) for r, f in zip(runs, fits, strict=True)]
    return CarcassProblem(
        stack_runs(rows),
        x,
        force,
        weight,
        settled,
        level,
        curve,
        geometry,
        friction,
        tread_stiffness,
        longitudinal,
    )


def _measured(
    runs: Sequence[StepRun], fits: Sequence[LinearFit]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Cell centres (n,), mean force, root of the summed weights, settled samples (runs, n).

    Cells that a run does not fill have no weight in it.
    """
    longest = max((run.after_step(run.distance) for run in runs), key=len)
    first = _cells(len(longest), float(longest[1] - longest[0]))
    centres = _cell_sums(longest, first) / np.diff(first)
    force, weight, settled = (np.zeros((len(runs), len(centres))) for _ in range(3))
    for i, (run, fit) in enumerate(zip(runs, fits, strict=True)):
        own = run.after_step(run.distance)
        full = int(np.searchsorted(first, len(own), side="right")) - 1
        edges = first[: full + 1]
        force[i, :full] = _cell_sums(run.after_step(run.fx), edges) / np.diff(edges)
        weights = transient_weights(own, fit.transient_end)
        weight[i, :full] = np.sqrt(_cell_sums(weights, edges))
        late = own >= min(fit.transient_end, LATE * own[-1])
        settled[i, :full] = _cell_sums(late.astype(float), edges)
    return centres, force, weight, settled


def _cells(samples: int, spacing: float) -> np.ndarray:
    """Index of the first sample of every cell, and of the end."""
    edges, width = [0.0], spacing
    while edges[-1] < samples * spacing:
        edges.append(edges[-1] + width)
        limit = next(size for end, size in LARGEST_CELL if edges[-1] < end)
        width = min(width * GROWTH, limit)
    index = np.unique(np.round(np.array(edges) / spacing).astype(int))
    return index[index <= samples]


def _cell_sums(values: np.ndarray, edges: np.ndarray) -> np.ndarray:
    return np.add.reduceat(values[: edges[-1]], edges[:-1])
