# SPDX-License-Identifier: Apache-2.0
"""Covariance of a least-squares fit whose runs scatter: every run is one independent witness.

Inside a run the samples may be correlated in any way; only the runs' scores J_r' e_r count. The
scores are freed of the leverage of their own run (CR2 of Bell and McCaffrey), and the t
distribution gets the degrees of freedom that the spread of information over the runs allows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

LEVERAGE_LIMIT = 0.98
"""Share of one direction that one run may carry; above it, its residual says nothing."""


@dataclass(frozen=True)
class Covariance:
    """Covariance (p, p), degrees of freedom (p,), and the information J'J (p, p)."""

    matrix: np.ndarray
    dof: np.ndarray
    information: np.ndarray
    runs: np.ndarray
    """Names of the runs (runs,)."""
    brought: np.ndarray
    """What every run brings to the error of the parameters (runs, p)."""

    @property
    def std_error(self) -> np.ndarray:
        """Standard errors (p,)."""
        return np.sqrt(np.maximum(np.diag(self.matrix), 0.0))

    @property
    def correlation(self) -> np.ndarray:
        """Correlation matrix (p, p)."""
        size = self.std_error
        scale = np.where(size > 0.0, size, 1.0)
        return self.matrix / np.outer(scale, scale)


@dataclass(frozen=True)
class Carried:
    """Errors that an earlier fit carries into this one (two-step estimation, Murphy and Topel)."""

    runs: np.ndarray
    """Runs of the earlier fit (m,)."""
    response: np.ndarray
    """Change of this fit's rows by what each of them brought to the earlier one (m, n)."""


def run_covariance(
    jacobian: np.ndarray,
    residual: np.ndarray,
    run: np.ndarray,
    prior: np.ndarray | None = None,
    carried: Carried | None = None,
) -> Covariance:
    """Covariance from weighted Jacobian (n, p), residual (n,), and the run of each row (n,).

    `prior` (p, p): information that is not from runs (priors), added to J'J. `carried`: errors of
    what was fitted before and is held here, run by run, for the same run may have made both.
    """
    known = run if carried is None else np.concatenate([run, carried.runs])
    names, place = np.unique(known, return_inverse=True)
    index, p = place[: len(run)], jacobian.shape[1]
    scores, informations = np.zeros((len(names), p)), np.zeros((len(names), p, p))
    np.add.at(scores, index, jacobian * residual[:, None])
    np.add.at(informations, index, jacobian[:, :, None] * jacobian[:, None, :])
    own = informations.sum(axis=0)
    total = own if prior is None else own + prior
    # Work where the information is the unit matrix; directions without any stay out.
    values, vectors = np.linalg.eigh(total)
    kept = values > 1e-13 * max(float(values[-1]), 1e-300)
    back = vectors[:, kept] / np.sqrt(values[kept])
    whole = back.T @ informations @ back
    freed = np.array([_freed(k, back.T @ s) for k, s in zip(whole, scores, strict=True)])
    if carried is not None:
        pull = carried.response @ jacobian @ back
        np.add.at(freed, place[len(run) :], -pull)
    matrix = freed.T @ freed
    if prior is not None:
        matrix = matrix + back.T @ prior @ back
    dof = _degrees_of_freedom(back, whole, len(names))
    return Covariance(back @ matrix @ back.T, dof, total, names, freed @ back.T)


def _freed(share: np.ndarray, score: np.ndarray) -> np.ndarray:
    """(I - K_r)^(-1/2) score: what the residual would be had the run not pulled the fit."""
    values, vectors = np.linalg.eigh(share)
    values = np.clip(values, 0.0, LEVERAGE_LIMIT)
    return vectors @ ((vectors.T @ score) / np.sqrt(1.0 - values))


def _degrees_of_freedom(back: np.ndarray, whole: np.ndarray, runs: int) -> np.ndarray:
    """Per parameter: runs that it rests on, less the parameters they feed (p,)."""
    each = np.einsum("pk,rkl,pl->rp", back, whole, back)
    total = each.sum(axis=0)
    share = each / np.where(total > 0.0, total, 1.0)
    effective = 1.0 / np.maximum(np.sum(share**2, axis=0), 1e-12)
    left = max(runs - back.shape[1], 1) / runs
    return np.maximum(effective * left, 1.0)
