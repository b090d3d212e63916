# SPDX-License-Identifier: Apache-2.0
"""Interface of a model: predictions of all runs for many parameter sets at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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
class Form:
    """Error of a model on systems of another form, as shares of the largest signal, measured
    separately, because no floor shows it. A model that has it calls it `form`."""

    mean: float = 0.0
    """root mean square of the mean residual"""
    stretch: float = 0.0
    """the same within 5 cm of a place"""
    bump: float = 0.0
    """largest bump in it, of a twentieth of a place or longer; see `patterns`"""
    wave: float = 0.0
    """largest wave over a place"""
    side: float = 0.0
    """`mean` for the other channels"""

    def share(self, channel: int) -> float:
        """Form error of a channel's mean residual, as a share of the largest signal."""
        return self.side if channel else self.mean


def form_of(model: Model) -> Form:
    """The form error of a model."""
    return getattr(model, "form", Form())


def usual_scatter(model: Model) -> Sequence[float]:
    """Standard deviations of the `stiff` directions from run to run, used where no repeat shows
    them. A model that knows them calls them `usual_scatter`."""
    return getattr(model, "usual_scatter", ())


def starts_of(model: Model) -> Sequence[Mapping[str, float]]:
    """Further start values of the base, by name, for a fit that fails from the nulls. A model that
    has them calls them `starts`."""
    return getattr(model, "starts", ())


class Model(Protocol):
    """Anything that predicts the measured channels."""

    parameters: tuple[Parameter, ...]
    """base parameters"""
    runs: RunSet

    def predict(self, sets: Sequence[ParameterSet]) -> np.ndarray:
        """Predicted channels, shape (sets, channels, runs, samples)."""
        ...

    def stiff(self, base: np.ndarray) -> tuple[dict[str, float], ...]:
        """Directions that scatter from run to run (a gain, an offset): changes by parameter."""
        ...
