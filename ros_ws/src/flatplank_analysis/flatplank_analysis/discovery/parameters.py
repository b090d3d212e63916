# SPDX-License-Identifier: Apache-2.0
"""A fitted parameter: unit, null or start value, range, and the step for its screening."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

from flatplank_analysis.word import Word


@dataclass(frozen=True)
class Parameter:
    """One parameter of a model or of an effect, with its physical range and source."""

    name: str
    unit: str = "1"
    null: float = 0.0
    """value at which an effect does nothing; start value of a base parameter"""
    lower: float = -np.inf
    upper: float = np.inf
    screen: float = 0.0
    """finite step that makes the effect visible; scale of a base parameter; 0: not screened"""
    matters: float = 0.0
    """sizes below this are of no consequence"""
    prior: float = np.inf
    """standard deviation of the prior, around `null`"""
    note: str = ""
    """sentence: what it is"""
    title: str = ""
    """name in words"""
    symbol: str = ""
    known: bool = False
    """True when the parameter is known within its narrow range: it absorbs small deviations and
    hides no effect; large deviations are left to effects"""

    @property
    def word(self) -> Word:
        """What it is, for people."""
        return Word(self.title, self.note, self.unit, self.symbol)

    def at_end(self, value: float, near: float) -> bool:
        """True when a value is within `near` of an end of the range.

        An end that is equal to `null` does not count: no effect is not a limit of a fit.
        """
        above = value - self.lower if self.lower != self.null else np.inf
        below = self.upper - value if self.upper != self.null else np.inf
        return min(above, below) < near


def param(
    null: float,
    *,
    unit: str,
    bounds: tuple[float, float],
    screen: float = 0.0,
    matters: float = 0.0,
    prior: float = np.inf,
    note: str = "",
    title: str = "",
    symbol: str = "",
) -> Any:
    """Declare a fitted dataclass field; see `Parameter`."""
    meta = {
        "parameter": dict(
            unit=unit,
            null=float(null),
            lower=float(bounds[0]),
            upper=float(bounds[1]),
            screen=float(screen),
            matters=float(matters),
            prior=float(prior),
            note=note,
            title=title,
            symbol=symbol,
        )
    }
    return dataclasses.field(default=float(null), metadata=meta)


def parameters_of(kind: type) -> tuple[Parameter, ...]:
    """The fitted fields of a dataclass, in order."""
    return tuple(
        Parameter(item.name, **item.metadata["parameter"])
        for item in dataclasses.fields(kind)
        if "parameter" in item.metadata
    )
