# SPDX-License-Identifier: Apache-2.0
"""Linear transient model: a contact point on a carcass spring (7.1-7.11), in x."""

from __future__ import annotations

from typing import Any

import numpy as np

from .base import RunInputs, column


class LinearX:
    """Fx = C_x u with sigma_x du/dx + u = sigma_x kappa and C_x = C_Fkappa / sigma_x."""

    def simulate(self, params: np.ndarray, inputs: RunInputs) -> np.ndarray:
        """Fx [N] (sets, runs, samples); params (sets, 2): sigma [m], slip stiffness [N]."""
        sigma, stiffness = column(params, 0), column(params, 1)
        spring = stiffness / sigma
        first = inputs.start_fx[None, :] / np.where(spring == 0.0, 1.0, spring)
        u = deflection(inputs.travel[None], inputs.slip_x[None], sigma[..., None], first)
        return spring[..., None] * u


def deflection(
    travel: np.ndarray, slip: np.ndarray, sigma: np.ndarray, start: np.ndarray
) -> np.ndarray:
    """Solve sigma du + u |dx| = sigma ds for the deflection u [m], exact for any increment (7.9).

    `travel` |dx| and `slip` ds [m] are increments along the last axis that broadcast to (sets,
    runs, samples), as does `sigma` [m]; `start` is u before sample 0 (sets, runs). At rest u
    follows the slip in full; over a long way it approaches sigma ds/|dx|.
    """
    kept, share = relaxed(travel, sigma)
    gained = share * slip
    kept, gained = np.broadcast_arrays(kept, gained)
    # samples first, so that the loop works on contiguous (sets, runs) planes
    kept = np.ascontiguousarray(np.moveaxis(kept, -1, 0))
    out = np.array(np.moveaxis(gained, -1, 0))
    u = np.broadcast_to(np.asarray(start, float), out.shape[1:])
    for factor, plane in zip(kept, out, strict=True):
        plane += factor * u
        u = plane
    return np.moveaxis(out, 0, -1)


def relaxed(travel: Any, sigma: Any) -> tuple[Any, Any]:
    """Share of the deflection that an increment of `travel` [m] keeps, and share of its slip that
    becomes deflection [-] (7.9); `sigma` [m]."""
    ratio = np.divide(travel, sigma)
    small = ratio < 1e-9
    share = np.where(small, 1.0, -np.expm1(-ratio) / np.where(small, 1.0, ratio))
    return np.exp(-ratio), share
