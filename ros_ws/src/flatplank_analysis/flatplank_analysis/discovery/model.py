# SPDX-License-Identifier: Apache-2.0
"""Interface of a model: predictions of all runs for many parameter sets at once."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.parameters import Parameter
from flatplank_analysis.discovery.runs import RunSet


@dataclass(frozen=True)
class ParameterSet:
    """One parameter set: base parameters and the active effects."""

    base: np.ndarray
    """(parameters,)"""
    effects: tuple[tuple[type[Effect], np.ndarray], ...] = ()
    """effect and its parameter values, in the order in which they act"""


@dataclass(frozen=True)
class FormError:
    """Error of a model on systems with other equations than its own: the form error.

    Shares of the largest signal, but for `law` and `shift`. They are measured separately, because
    no floor shows this error.
    """

    mean: float = 0.0
    """root mean square of the mean residual, the mean over the repeats"""
    stretch: float = 0.0
    """`mean` within 5 cm of a place coordinate"""
    bump: float = 0.0
    """largest bump in the mean residual, at least a twentieth of the place long; see `patterns`"""
    wave: float = 0.0
    """largest wave in the mean residual over a place"""
    side: float = 0.0
    """`mean` for the other channels"""
    law: float = 0.005
    """standard deviation of a signal, as a share of it, independent in each channel and between
    runs of another law (`laws_of`); it limits the precision of effects that are proportional to
    the signals"""
    shift: float = 0.0
    """standard deviation of the place at which signals rise and fall, in the unit of the place"""
    reach: float = 0.0
    """length over which an effect acts at most at once (half of a contact), in the unit of the
    place: within it the form of an effect is not known"""

    def share(self, channel: int) -> float:
        """Form error of a channel's mean residual, as a share of the largest signal."""
        return self.side if channel else self.mean


def form_error_of(model: Model) -> FormError:
    """Form error of a model: its attribute `form`, or zeros."""
    return getattr(model, "form", FormError())


def laws_of(model: Model) -> Sequence[Hashable]:
    """Per run what says by which law its signals come: runs with the same one have the same error
    `FormError.law`. The attribute `laws` of the model, or the names of the conditions."""
    runs = model.runs
    return getattr(model, "laws", [runs.condition_names[c] for c in runs.condition])


def same_law(model: Model) -> dict[Hashable, np.ndarray]:
    """Rows of the runs of each law, see `laws_of`."""
    rows: dict[Hashable, list[int]] = {}
    for row, law in enumerate(laws_of(model)):
        rows.setdefault(law, []).append(row)
    return {law: np.array(found) for law, found in rows.items()}


def usual_scatter(model: Model) -> Sequence[float]:
    """Standard deviations from run to run along `Model.scatter_directions`, for runs without
    repeats: the attribute `usual_scatter` of the model, or ()."""
    return getattr(model, "usual_scatter", ())


def starts_of(model: Model) -> Sequence[Mapping[str, float]]:
    """Further start values of the base, by name, for a fit that fails from the nulls: the
    attribute `starts` of the model, or ()."""
    return getattr(model, "starts", ())


class Model(Protocol):
    """Anything that predicts the measured channels."""

    parameters: tuple[Parameter, ...]
    """base parameters"""
    runs: RunSet

    def predict(self, sets: Sequence[ParameterSet]) -> np.ndarray:
        """Predicted channels, shape (sets, channels, runs, samples)."""
        ...

    def scatter_directions(self, base: np.ndarray) -> tuple[dict[str, float], ...]:
        """Directions in the base that scatter from run to run (a gain, an offset), each as
        {parameter: change}."""
        ...
