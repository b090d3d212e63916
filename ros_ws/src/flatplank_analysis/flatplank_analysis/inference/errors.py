# SPDX-License-Identifier: Apache-2.0
"""Errors of the model that no repeat shows, as random columns: law, transient, form of an effect.

Their sizes are shares: of the signal, of the effect, of a contact (`FormError.reach`); the
transient error is a length of the model (`FormError.shift`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.fit import Fit, effect_contribution
from flatplank_analysis.discovery.gram import Metric
from flatplank_analysis.discovery.model import Model, form_error_of, same_law
from flatplank_analysis.discovery.noise import SLOW
from flatplank_analysis.discovery.state import State
from flatplank_analysis.inference.evidence import SMALLEST

FORMS = (0.03, 0.15)
"""standard deviations of the relative difference of an effect's size between conditions, and
between stretches of a run, equally probable: a fault of the form of the library, whose size the
law of the model imitates by about this share, and one of another form"""
STRETCHES = 5
"""stretches of a run, of equal share of what is divided"""
WORSE = (1.0, 2.0, 4.0, 8.0, 16.0)
"""factors of the errors of law and transient that a tire may have, each a quarter as probable as
the one before: the tail of Student with 2 degrees of freedom, as for the sizes of effects"""

SHARED = (1.0, 16.0)
"""factors of the transient error that all runs share, relative to the other errors of a tire,
equally probable: a tire whose law is that of the base may enter it along another transient"""

STEEP = 40
"""numerical: most nodes with an error of their own"""


class WithLawErrors(Metric):
    """Metric in which errors of law and transient are down-weighted, beside noise and scatter.

    They are the same in all runs of one law, so that repeats do not average them out. How large
    they are for a tire is known within factors only (`WORSE`).
    """

    def __init__(self, plain: Metric, groups: Sequence[np.ndarray], loose: np.ndarray) -> None:
        """groups: rows of the runs of one law; loose (k, channels, runs, samples): columns of the
        errors, each with its standard deviation. `factor` is how much larger they are here."""
        self.groups, self.factor = groups, WORSE[0]
        self._loose = plain.white(loose)
        self._take(plain)

    def _take(self, plain: Metric) -> None:
        self.whitener, self.scatter, self.plain = plain.whitener, plain.scatter, plain
        loose = plain.beside_scatter(self._loose.copy())
        self.parts = [_principal(loose[:, rows]) for rows in self.groups]

    def __call__(self, values: np.ndarray) -> np.ndarray:
        """Values (n, channels, runs, samples) in units of the noise: (n, runs, m)."""
        return self.down_weighted(self.plain(values), self.factor)

    def larger(self, factor: float) -> WithLawErrors:
        """The metric in which the errors are larger by a factor."""
        other = copy(self)
        other.factor = factor
        return other

    def along(self, directions: np.ndarray) -> WithLawErrors:
        """The same errors, and scatter along the directions that the tire has at another fit."""
        other = copy(self)
        other._take(self.plain.along(directions))
        return other

    def by_runs(self, runs: int) -> Iterator[tuple[slice, Metric]]:
        """All at once: the errors are the same in all runs of one law."""
        yield slice(0, runs), self

    def down_weighted(self, white: np.ndarray, factor: float) -> np.ndarray:
        """Values (n, runs, m) in units of noise and scatter, in which model errors that are larger
        by a factor are down-weighted."""
        out = np.empty_like(white)
        for rows, (sizes, directions) in zip(self.groups, self.parts, strict=True):
            flat = white[:, rows].reshape(len(white), -1)
            # (1 + L'L)^(-1/2) for errors L in units of the noise
            share = 1.0 - 1.0 / np.sqrt(1.0 + (factor * sizes) ** 2)
            left = flat - ((flat @ directions.T) * share) @ directions
            out[:, rows] = left.reshape(white[:, rows].shape)
        return out

    def volume_with(self, factor: float) -> float:
        """Logarithm of the volume that scatter, and model errors larger by a factor, take from the
        data."""
        return self.plain.volume - 0.5 * sum(
            float(np.sum(np.log1p((factor * s) ** 2))) for s, _ in self.parts
        )


def _principal(loose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sizes (k,) and orthonormal directions (k, m) of errors (k, ...) in units of the noise."""
    flat = loose.reshape(len(loose), -1)
    values, vectors = np.linalg.eigh(flat @ flat.T)
    keep = values > SMALLEST * max(float(values[-1]), 1e-300)
    sizes = np.sqrt(values[keep])
    return sizes, (vectors[:, keep] / sizes).T @ flat


@dataclass(frozen=True)
class LawErrors:
    """Errors of law and transient of a model. A force rises earlier or later as a whole and in
    each stretch of its rise, and, where it rises so steeply that this is more than the noise of a
    sample (start from a locked wheel), also at each node by itself: there the form of the
    transient is no better known than its place."""

    steep: np.ndarray
    """nodes with an error of their own"""

    @classmethod
    def of(cls, state: State) -> LawErrors:
        """The errors for the runs and the noise of a state."""
        late = shifted_later(state.model, state.whitened.fit.predicted)
        noise = np.sqrt([n.weights[:SLOW].sum() for n in state.metric.whitener.noises])
        steepness = (np.sqrt(np.mean(late**2, axis=1)) / noise[:, None]).max(axis=0)
        steep = np.argsort(-steepness)[:STEEP]
        return cls(steep[steepness[steep] > 1.0])

    def columns(self, model: Model, signals: np.ndarray) -> np.ndarray:
        """Columns (n, channels, runs, samples) of the errors of signals (channels, runs, samples)
        that runs of one law share, each with its standard deviation."""
        law = form_error_of(model).law * np.eye(len(signals))[:, :, None, None] * signals
        late = shifted_later(model, signals)
        single = (late * (np.arange(late.shape[-1]) == n) for n in self.steep)
        return np.concatenate([law, late[None], in_stretches(late), *(s[None] for s in single)])


def with_law_errors(state: State) -> WithLawErrors:
    """The metric of a state with the errors of law and transient of its model."""
    model, signals = state.model, state.whitened.fit.predicted
    columns = LawErrors.of(state).columns(model, signals)
    return WithLawErrors(state.metric, list(same_law(model).values()), columns)


def shared_errors(model: Model, signals: np.ndarray) -> np.ndarray:
    """Columns (1 + STRETCHES, channels, runs, samples) of the transient error that all runs share,
    each with its standard deviation: the forces of this tire rise later than those of the base, as
    a whole and in each stretch."""
    late = shifted_later(model, signals)
    return np.concatenate([late[None], in_stretches(late)])


def effect_errors(model: Model, fit: Fit, index: int) -> np.ndarray:
    """Columns (2 * STRETCHES, channels, runs, samples) of the form error of an effect, of one
    standard deviation each where the form is that of the largest of `FORMS`: size and place of its
    contribution differ between stretches of the run."""
    direction = effect_contribution(fit, index)
    moved = later(model, direction, FORMS[-1] * form_error_of(model).reach)
    return np.concatenate([in_stretches(direction), in_stretches(moved) / FORMS[-1]])


def in_stretches(direction: np.ndarray) -> np.ndarray:
    """A change of the prediction by stretches of the run (STRETCHES, channels, runs, samples)."""
    energy = np.sum(direction**2, axis=(0, 1))
    along = np.cumsum(energy) / max(float(energy.sum()), 1e-30)
    even = np.linspace(0.0, 1.0, direction.shape[-1])
    place = np.minimum((0.5 * (along + even) * STRETCHES).astype(int), STRETCHES - 1)
    return np.stack([direction * (place == i) for i in range(STRETCHES)])


def shifted_later(model: Model, signals: np.ndarray) -> np.ndarray:
    """Change of all signals (channels, runs, samples) when they rise and fall later over the place
    by the form error of the model; nothing where it has no such error."""
    shift = form_error_of(model).shift
    places = _places(model)
    if not shift or places is None:
        return np.zeros_like(signals)
    step = np.maximum(np.gradient(places, axis=-1), shift)
    return -shift * np.gradient(signals, axis=-1) / step


def later(model: Model, change: np.ndarray, length: float) -> np.ndarray:
    """Difference of a change of the signals (channels, runs, samples) when it comes later over the
    place by a length; nothing where no place is recorded."""
    places = _places(model)
    if not length or places is None:
        return np.zeros_like(change)
    out = -change
    for c, r in np.ndindex(change.shape[:2]):
        if np.any(change[c, r]):
            out[c, r] += np.interp(places[r] - length, places[r], change[c, r])
    return out


def _places(model: Model) -> np.ndarray | None:
    """The place (runs, samples) of the first local coordinate, None where there is none."""
    places = [c.values for c in model.runs.coordinates.values() if c.local]
    return places[0] if places else None
