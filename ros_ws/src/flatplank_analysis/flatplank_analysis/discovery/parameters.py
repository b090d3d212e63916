# SPDX-License-Identifier: Apache-2.0
"""A fitted number: unit, null or start value, range, and the step with which it is screened."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Parameter:
    """One number of a model or of an effect, with its physical range and where it comes from."""

    name: str
    unit: str = "1"
    null: float = 0.0
    """value at which an effect does nothing; start value of a base parameter"""
    lower: float = -np.inf
    upper: float = np.inf
    screen: float = 0.0
    """a finite step that shows the effect; scale of a base parameter; 0: not screened by itself"""
    matters: float = 0.0
    """sizes below this are of no consequence"""
    prior: float = np.inf
    """standard deviation of what is known beforehand, around `null`"""
    note: str = ""
    """what it is, or the source of its value"""
    known: bool = False
    """known beforehand within its narrow range: no effect is hidden behind it, it takes what is
    small; what is large is left to effects"""


def param(
    null: float,
    *,
    unit: str,
    bounds: tuple[float, float],
    screen: float = 0.0,
    matters: float = 0.0,
    prior: float = np.inf,
    note: str = "",
) -> Any:
    """A dataclass field that is fitted; see `Parameter`."""
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
