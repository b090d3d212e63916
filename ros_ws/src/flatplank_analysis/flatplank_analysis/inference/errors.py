# SPDX-License-Identifier: Apache-2.0
"""Errors of the model that no repeat shows, as random columns: law, transient, form of an effect.

Their sizes are shares: of the signal, of the effect; the transient error is a length of the model
(`FormError.shift`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flatplank_analysis.discovery.fit import Fit, effect_contribution
from flatplank_analysis.discovery.gram import Metric
from flatplank_analysis.discovery.model import form_error_of, same_law
from flatplank_analysis.discovery.noise import SLOW
from flatplank_analysis.discovery.size_errors import shifted_later, single_channels
from flatplank_analysis.discovery.state import State

FORMS = (0.03, 0.15)
"""standard deviations of the relative difference of an effect's size between conditions, and
between stretches of a run, equally probable: a fault of the form of the library, whose size the
law of the model imitates by about this share, and one of another form"""
STRETCHES = 5
"""stretches of a run, of equal share of the effect"""


STEEP = 40
"""numerical: most nodes with an error of their own"""


class WithLawErrors(Metric):
    """Metric in which errors of law and transient are down-weighted, beside noise and scatter.

    They are the same in all runs of one law, so that repeats do not average them out.
    """

    def __init__(self, plain: Metric, groups: Sequence[np.ndarray], loose: np.ndarray) -> None:
        """groups: rows of the runs of one law; loose (k, channels, runs, samples): columns of the
        errors, each with its standard deviation."""
        self.whitener, self.scatter, self.plain = plain.whitener, plain.scatter, plain
        self.groups = [(rows, _square_root(plain(loose)[:, rows])) for rows in groups]

    def __call__(self, values: np.ndarray) -> np.ndarray:
        """Values (n, channels, runs, samples) in units of the noise: (n, runs, m)."""
        white = self.plain(values)
        for rows, side in self.groups:
            part = white[:, rows]
            flat = part.reshape(len(white), -1)
            white[:, rows] = (flat - (flat @ side.T) @ side).reshape(part.shape)
        return white


def _square_root(loose: np.ndarray) -> np.ndarray:
    """Rows S with (1 - S'S)^2 = (1 + L'L)^-1 for columns L (k, ...) in units of the noise."""
    flat = loose.reshape(len(loose), -1)
    values, vectors = np.linalg.eigh(flat @ flat.T)
    values = np.maximum(values, 1e-30)
    share = (1.0 - 1.0 / np.sqrt(1.0 + values)) / values
    return np.sqrt(share)[:, None] * (vectors.T @ flat)


def law_errors(state: State) -> np.ndarray:
    """Columns (n, channels, runs, samples) of the errors of law and transient, each with its
    standard deviation.

    A force rises earlier or later as a whole, and, where it rises so steeply that this is more
    than the noise of a sample (start from a locked wheel), also at each node by itself: there the
    form of the transient is no better known than its place.
    """
    signals = state.whitened.fit.predicted
    law = form_error_of(state.model).law * single_channels(signals)
    late = shifted_later(state, signals)
    noise = np.sqrt([n.weights[:SLOW].sum() for n in state.metric.whitener.noises])
    steepness = (np.sqrt(np.mean(late**2, axis=1)) / noise[:, None]).max(axis=0)
    steep = np.argsort(-steepness)[:STEEP]
    steep = steep[steepness[steep] > 1.0]
    single = [late * (np.arange(late.shape[-1]) == n) for n in steep]
    return np.concatenate([law, late[None], *(s[None] for s in single)])


def with_law_errors(state: State) -> WithLawErrors:
    """The metric of a state with the errors of law and transient of its model."""
    return WithLawErrors(state.metric, same_law(state.model), law_errors(state))


def stretches_of(fit: Fit, index: int) -> np.ndarray:
    """Contribution of an effect by stretches of the run (STRETCHES, channels, runs, samples)."""
    direction = effect_contribution(fit, index)
    energy = np.sum(direction**2, axis=(0, 1))
    along = np.cumsum(energy) / max(float(energy.sum()), 1e-30)
    even = np.linspace(0.0, 1.0, direction.shape[-1])
    place = np.minimum((0.5 * (along + even) * STRETCHES).astype(int), STRETCHES - 1)
    return np.stack([direction * (place == i) for i in range(STRETCHES)])
