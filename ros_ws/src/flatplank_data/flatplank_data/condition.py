# SPDX-License-Identifier: Apache-2.0
"""Test condition: what a tire test holds constant, and by which repeats are grouped."""

from __future__ import annotations

import math
from typing import Any, NamedTuple


def is_nan(value: Any) -> bool:
    """True for a float NaN, an unknown value; false for texts and None."""
    return isinstance(value, float) and math.isnan(value)


class Condition(NamedTuple):
    """What a tire test holds constant; runs with the same condition are repeats."""

    tire: str
    measurement: str
    fz: float
    """nominal load [N]"""
    pressure: float
    """[bar]"""
    alpha_deg: float
    gamma_deg: float
    kappa: float
    """desired slip [-]; NaN in an operating point"""

    def __reduce__(self) -> tuple:
        # tuples with NaN are equal only if it is the same object: use that of this process
        return condition_of, tuple(self)

    @property
    def operating_point(self) -> Condition:
        """The condition without the slip level; one carcass stiffness is fitted to its runs."""
        return self._replace(kappa=math.nan)

    @property
    def sort_key(self) -> tuple:
        """Key for sorting; NaN comes first."""
        return tuple(-math.inf if is_nan(value) else value for value in self)

    def label(self) -> str:
        """Short text for tables and figures."""
        bar = f"{self.pressure:g} bar" if self.pressure > 0.0 else "pressure not stated"
        text = f"Fz {self.fz:g} N, {bar}"
        if self.alpha_deg and not math.isnan(self.alpha_deg):
            text += f", α {self.alpha_deg:g}°"
        if self.gamma_deg:
            text += f", γ {self.gamma_deg:g}°"
        if not math.isnan(self.kappa):
            text = f"κ {100.0 * self.kappa:+g} %, " + text
        return text


def condition_of(tire: str, measurement: str, *numbers: float) -> Condition:
    """A condition whose unknown values are one shared NaN object, so that it works as dictionary
    key."""
    return Condition(tire, measurement, *(math.nan if is_nan(v) else v for v in numbers))
