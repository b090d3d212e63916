# SPDX-License-Identifier: Apache-2.0
"""Permutation test: do differences between repeats follow a setting?

Repeats of a condition could have been measured in any order. A setting without influence explains
the differences between repeats no better than with its values exchanged among them. The test makes
no assumption on the scatter, which few repeats determine poorly.
"""

from __future__ import annotations

import numpy as np

from flatplank_analysis.discovery.runs import RunSet

TIMES, SEED = 5000, 1
POWERS = (1, 2)
"""powers of the setting"""


def exchange_test(
    runs: RunSet, residual: np.ndarray, responses: np.ndarray, values: np.ndarray
) -> float:
    """p-value of the hypothesis that the setting has no influence.

    Args:
        runs: with repeats.
        residual: (runs, samples) of a channel.
        responses: (hooks, runs, samples), change by one unit of the setting at each hook.
        values: (runs,) of the setting.
    """
    random = np.random.default_rng(SEED)
    drawn = np.tile(values.astype(float), (TIMES + 1, 1))
    contrast = runs.contrast(residual)
    along = np.zeros(responses.shape[:2])
    inner = []
    for g in runs.groups:
        drawn[1:, g] = random.permuted(drawn[1:, g], axis=1)
        # every condition has the same weight, whatever its scatter
        weight = 1.0 / max(float(np.sqrt(np.mean(contrast[g] ** 2))), 1e-12)
        part = weight * responses[:, g]
        along[:, g] = np.einsum("rt,hrt->hr", weight * contrast[g], part)
        inner.append(np.einsum("hrt,hst->hrs", part, part))
    taken = np.array([_explained_energy(runs, along, inner, drawn**k) for k in POWERS]).max(axis=0)
    return float(np.mean(taken >= taken[0] * (1.0 - 1e-9)))


def _explained_energy(
    runs: RunSet, along: np.ndarray, inner: list[np.ndarray], u: np.ndarray
) -> np.ndarray:
    """Energy of the contrasts explained by the best response, for sets of values u (n, runs)."""
    energy = np.zeros((len(along), len(u)))
    for g, products in zip(runs.groups, inner, strict=True):
        v = u[:, g]
        own = v**2 @ np.diagonal(products, axis1=1, axis2=2).T
        shared = np.einsum("nr,hrs,ns->nh", v, products, v) / len(g)
        energy += (own - shared).T
    floor = 1e-9 * max(float(energy.max()), 1.0)
    return ((along @ u.T) ** 2 / np.maximum(energy, floor)).max(axis=0)
