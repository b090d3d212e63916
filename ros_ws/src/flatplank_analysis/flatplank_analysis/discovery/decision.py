# SPDX-License-Identifier: Apache-2.0
"""Outcome of the tests of one effect: its size with interval, and why it was refused."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.fit import Term

OTHER = 0.4
"""permitted `Decision.unevenness` of a fault of another form than the effect, when no residual of
consequence remains"""
CLEAR = 1.57
"""half-widths of its 90 % interval by which a size must differ from zero: with these the interval
would be one of 99 %. A size that the base mostly imitates is known no better than its law"""
NEGLIGIBLE = "present, negligible"
"""reason that applies to a size of no consequence"""
FLAT = "the error does not fall with it"
"""reason that applies to an effect that only the whitened residuals show"""
IMITATED = "these runs cannot tell it from the base"
"""reason that applies to an effect that the base imitates wholly (`Effect.separable`)"""
UNEVEN = ("not the same size along the run", "not the same size in every condition")
"""reasons that apply to a false effect, and to a fault of another form than the effect"""


@dataclass(frozen=True)
class Decision:
    """Outcome of all tests of one effect in one refit."""

    term: Term
    drop: float
    """drop of the whitened chi2 by the effect"""
    parameters: int
    dispersion: float
    """dispersion of the scores among repeats over that of the noise model"""
    dispersion_conditions: float
    p_repeats: float
    p_conditions: float
    level: float
    """required p-value: `FAMILY` divided by the number of columns tested"""
    matters: float
    """smallest size of consequence"""
    stretch_q: float
    stretch_limit: float
    """gain of chi2 with one size per stretch of the run (`stretch_q`), and its limit"""
    condition_q: float
    condition_limit: float
    """sum of squares of the size over the conditions (`condition_q`), and its limit"""
    interval: tuple[float, float]
    """90 % interval of the size"""
    held_out_gain: float
    """share of the squared error in left-out conditions that the effect removes"""
    reasons: tuple[str, ...]
    """why it was refused; empty when accepted"""
    law_error: float = 0.0
    """standard deviation of the size by the error of the force law (`FormError.law`)"""
    signals: tuple[float, ...] = (1.0,)
    """share of each channel in what shows the effect"""

    @property
    def accepted(self) -> bool:
        return not self.reasons

    @property
    def covers_zero(self) -> bool:
        """True when the 99 % interval of a size contains zero (`CLEAR`); a free form has no such
        size."""
        low, high = self.interval
        return abs(low + high) <= CLEAR * (high - low) and not self.term.effect.generic

    @property
    def unevenness(self) -> float:
        """Share of the drop by which the size differs along the run or between conditions."""
        return max(self.stretch_q, self.condition_q) / max(self.drop, 1e-30)

    @property
    def misshapen(self) -> bool:
        """True when only its form is wrong, within the permitted limit."""
        uneven = bool(self.reasons) and set(self.reasons) <= set(UNEVEN)
        return uneven and not self.term.effect.generic and self.unevenness < OTHER

    @property
    def slight(self) -> bool:
        """True when only its size is below what matters."""
        return self.reasons == (NEGLIGIBLE,)

    @property
    def present(self) -> bool:
        """True when something like it is in the data, but of no consequence: its size is below
        what matters, and nothing else is wrong but its form."""
        return NEGLIGIBLE in self.reasons and set(self.reasons) <= {NEGLIGIBLE, *UNEVEN}

    @property
    def residue(self) -> float:
        """Part of the drop that its wrong form leaves."""
        return self.unevenness * self.drop if self.misshapen else 0.0

    @property
    def p_value(self) -> float:
        return max(self.p_repeats, self.p_conditions)

    def explained_by(self, others: Iterable[Decision]) -> float:
        """Drop by other effects in the signals in which this one shows."""
        weights = np.divide(self.signals, max(*self.signals, 1e-30))
        return sum(d.drop * float(np.dot(weights, d.signals)) for d in others)
