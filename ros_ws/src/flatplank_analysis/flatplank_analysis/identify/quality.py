# SPDX-License-Identifier: Apache-2.0
"""Measures of chapter 7: where the transient part ends, how large the error is there."""

from __future__ import annotations

import numpy as np

SLOPE_LIMIT = 0.05
"""The transient part ends where slope over steady force falls below this [1/m]."""
TRANSIENT_WEIGHT = 100.0
"""Weight of a squared error in the transient part against 1 in the steady part (7.25)."""


def transient_end(distance: np.ndarray, response: np.ndarray, steady_force: float) -> float:
    """Distance since the step [m] at which the transient part of a fitted response ends.

    Section 7.1: the gradient, normalised with the steady-state force, falls below 0.05 (per metre,
    our reading). Without a steady force (kappa = 0) the whole part after the step counts.
    """
    after = distance >= 0.0
    x, f = distance[after], response[after]
    if len(x) < 3 or not np.isfinite(steady_force) or abs(steady_force) < 1e-9:
        return float(x[-1]) if len(x) else 0.0
    slope = np.abs(np.gradient(f, x)) / abs(steady_force)
    # After the steepest place: a plateau at the beginning has no slope either.
    first = int(np.argmax(slope))
    below = np.flatnonzero(slope[first:] < SLOPE_LIMIT)
    return float(x[first + below[0]]) if len(below) else float(x[-1])


def is_transient(distance: np.ndarray, end: float) -> np.ndarray:
    """Mask of the samples from the step to the end of the transient part."""
    return (distance >= 0.0) & (distance <= end)


def transient_weights(distance: np.ndarray, end: float) -> np.ndarray:
    """Weights of (7.25): 100 in the transient part, 1 in the steady part, 0 before the step."""
    weights = np.where(is_transient(distance, end), TRANSIENT_WEIGHT, 1.0)
    return np.where(distance >= 0.0, weights, 0.0)


def rmse(measured: np.ndarray, modelled: np.ndarray, mask: np.ndarray | None = None) -> float:
    """Root-mean-square error [N] over the samples of the mask."""
    error = np.asarray(measured, float) - np.asarray(modelled, float)
    if mask is not None:
        error = error[mask]
    return float(np.sqrt(np.mean(error**2))) if error.size else float("nan")


def relative_error(measured: np.ndarray, modelled: np.ndarray) -> float:
    """Relative error e_r of (7.28) as a fraction."""
    return float(np.sum(np.abs(measured - modelled)) / np.sum(np.abs(measured)))


def relaxation_length(slip_stiffness: float, carcass_stiffness: float, contact: float) -> float:
    """sigma_x = C_Fk / c_cx + sigma_c with sigma_c = a (7.27) [m]."""
    return slip_stiffness / carcass_stiffness + contact
