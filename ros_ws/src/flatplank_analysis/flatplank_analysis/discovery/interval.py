# SPDX-License-Identifier: Apache-2.0
"""How well a size is known: a sandwich of what scores really do, and the form of the law."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import t as student

from flatplank_analysis.discovery.fit import Fit
from flatplank_analysis.discovery.gram import solve
from flatplank_analysis.discovery.state import State

FORM = 0.03
"""standard deviation of a relative size by the form of the model's law"""


def channel_scale(state: State) -> np.ndarray:
    """One over the floor of each channel, (channels, 1, 1)."""
    return np.array([1.0 / max(f.floor, 1e-12) for f in state.floors])[:, None, None]


def relative_spread(state: State, fit: Fit, own: Sequence[int], direction: np.ndarray) -> float:
    """Half width of the 90 % interval relative to the size, for the plain fit.

    Sandwich: what the scores of runs and of conditions really do, and at least the noise model.
    """
    runs = state.runs
    weight = channel_scale(state)
    flat = (fit.jacobian[list(own)] * weight).reshape(len(own), -1)
    f = (direction * weight).reshape(-1)
    gram = flat @ flat.T
    mix = solve(gram, flat @ f)[0]
    f = (f - mix @ flat).reshape(direction.shape)
    e = fit.residual(runs.measured) * weight
    info = float(np.sum(f * f))
    if info <= 1e-30:
        return np.inf
    within = runs.contrast(f)
    between_repeats = float(np.sum(within**2)) > 0.5 * info
    if between_repeats:
        # what differs between repeats is measured by their differences: the form of the law,
        # which is the same in all of them, is no part of its error
        e = runs.contrast(e)
        f, info = within, float(np.sum(within**2))
    score = np.sum(f * e, axis=(0, 2))
    groups = [score[g].sum() for g in runs.groups]
    count = len(groups)
    spare = runs.runs - (count if between_repeats else len(own) / 3.0)
    variance = float(np.sum(score**2)) * runs.runs / max(spare, 1.0)
    if not between_repeats:
        by_condition = float(np.sum(np.square(groups))) * count / max(count - 2.0, 1.0)
        variance = max(variance, by_condition, _noise_variance(state, f, weight))
    share = np.array([np.sum(f[:, g] ** 2) for g in runs.groups]) / info
    freedom = max(1.0 / float(np.sum(share**2)) - 1.0, 2.0)
    variance /= info**2
    # the form of the law is not the tire's: that is no noise, and no repeat shows it
    return float(student.ppf(0.95, freedom + 2.0) * np.sqrt(variance + FORM**2))


def _noise_variance(state: State, f: np.ndarray, weight: np.ndarray) -> float:
    """Variance of sum(f e) by the noise model, from the cleaned contrasts of the repeats."""
    sizes = np.array([len(state.runs.groups[c]) for c in state.runs.condition])
    grow = sizes / np.maximum(sizes - 1.0, 1.0)
    score = np.sum(f * state.contrasts * weight, axis=(0, 2))
    return float(np.sum(score**2 * grow))
