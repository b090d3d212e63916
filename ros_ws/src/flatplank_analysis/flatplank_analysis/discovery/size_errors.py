# SPDX-License-Identifier: Apache-2.0
"""Errors of an effect's size that no repeat shows: those of the model's force law, of its
transients, and what its parameters imitate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.dispersion import scores_of
from flatplank_analysis.discovery.gram import Gram, solve
from flatplank_analysis.discovery.model import form_error_of, same_law
from flatplank_analysis.discovery.state import State


@dataclass(frozen=True)
class SizeErrors:
    """Errors of the size of one effect, in units of the size that its direction has."""

    information: float
    """one over the variance of the size by the noise and scatter"""
    law: float
    """variance of the size by an error of the force law (`FormError.law`)"""
    late: float
    """change of the size when all signals come later (`FormError.shift`)"""
    energies: np.ndarray
    """(channels,) squares of what shows the effect, in units of the noise"""


def size_errors(
    state: State, gram: Gram, base: int, beside: Sequence[int], others: np.ndarray,
    direction: np.ndarray,
) -> SizeErrors:  # fmt: skip
    """Errors of the size of an effect beside a base.

    gram: sums of the base, of the effect, of any columns, and of those of `shifts_of`; base:
    number of columns of the base; beside: those of them that may imitate the effect, `others` (n,
    channels, runs, samples) their columns; direction (channels, runs, samples): the effect's own.
    """
    score = along(gram, base)
    channels = len(direction)
    shown = not_imitated(gram, beside, base, others, direction)
    energies = state.metric.energies(shown)
    information = max(float(scores_of(gram, base)[1].sum()), 1e-30)
    limits = limits_of_form(state, shown, energies, information)
    by_law = variance_of_law(state, score[:, -channels:], limits)
    late = float(score[:, -channels - 1].sum())
    return SizeErrors(information, by_law / information**2, late / information, energies)


def shifts_of(state: State, signals: np.ndarray) -> np.ndarray:
    """Columns (1 + channels, channels, runs, samples) of the errors of signals (channels, runs,
    samples): all of them later, and each alone."""
    return np.concatenate([shifted_later(state, signals)[None], single_channels(signals)])


def visible_share(gram: Gram, others: Sequence[int], column: int) -> float:
    """Share of a column that the others cannot imitate."""
    part = gram.of_columns([*others, column])
    _, info = scores_of(part, len(others))
    return float(info.sum()) / max(float(part.products[:, -1, -1].sum()), 1e-30)


def not_imitated(
    gram: Gram, others: Sequence[int], effect: int, columns: np.ndarray, direction: np.ndarray
) -> np.ndarray:
    """What other columns (n, channels, runs, samples) cannot imitate of an effect's direction
    (channels, runs, samples); others, effect: their places in the sums."""
    products = gram.total()[0]
    mix, _ = solve(products[np.ix_(others, others)], products[others, effect])
    return direction - np.tensordot(mix, columns, axes=1)


def variance_of_law(state: State, along: np.ndarray, limits: np.ndarray) -> float:
    """Variance of the score by a relative error of the law (`FormError.law`), independent in each
    channel and between runs of another law.

    along (runs, channels): score by the signals; limits (channels,) of the standard deviation.
    """
    scores = np.array([along[rows].sum(axis=0) for rows in same_law(state.model)])
    variance = form_error_of(state.model).law ** 2 * np.sum(scores**2, axis=0)
    return float(np.minimum(variance, limits**2).sum())


def limits_of_form(
    state: State, shown: np.ndarray, energies: np.ndarray, info: float
) -> np.ndarray:
    """Largest scores (channels,) of an effect by what the model leaves on systems of another form.

    shown (channels, runs, samples): what the base cannot imitate of the effect; energies
    (channels,) of that; info: its information, less than the energies where the scatter hides
    some. No error of the law leaves more in a channel than the form band.
    """
    form, largest = form_error_of(state.model), state.runs.largest
    out = np.full(len(shown), np.inf)
    size = np.sqrt(np.mean(shown**2, axis=(1, 2)))
    hidden = np.sqrt(info / max(float(energies.sum()), 1e-30))
    for c in np.flatnonzero(size):
        if form.share(c):
            out[c] = energies[c] * hidden * form.share(c) * largest[c] / size[c]
    return out


def along(gram: Gram, base: int) -> np.ndarray:
    """Score of the effect by each column (runs, columns), without what the base imitates."""
    products, scores, _ = gram.total()
    mix = solve(products[:base, :base], scores[:base])[1] @ products[:base, base]
    return gram.products[:, :, base] - gram.products[:, :, :base] @ mix


def single_channels(signals: np.ndarray) -> np.ndarray:
    """Signals (channels, runs, samples), each channel alone with the others at zero (channels,
    channels, runs, samples)."""
    return np.eye(len(signals))[:, :, None, None] * signals


def shifted_later(state: State, force: np.ndarray) -> np.ndarray:
    """Change of all signals (channels, runs, samples) when they rise and fall later over the place
    by the form error of the model; nothing where it has no such error."""
    shift = form_error_of(state.model).shift
    places = _places(state)
    if not shift or places is None:
        return np.zeros_like(force)
    step = np.maximum(np.gradient(places, axis=-1), shift)
    return -shift * np.gradient(force, axis=-1) / step


def later(state: State, change: np.ndarray, length: float) -> np.ndarray:
    """Difference of a change of the signals (channels, runs, samples) when it comes later over the
    place by a length; nothing where no place is recorded."""
    places = _places(state)
    if not length or places is None:
        return np.zeros_like(change)
    out = -change
    for c, r in np.ndindex(change.shape[:2]):
        if np.any(change[c, r]):
            out[c, r] += np.interp(places[r] - length, places[r], change[c, r])
    return out


def _places(state: State) -> np.ndarray | None:
    """The place (runs, samples) of the first local coordinate, None where there is none."""
    places = [c.values for c in state.runs.coordinates.values() if c.local]
    return places[0] if places else None
