# SPDX-License-Identifier: Apache-2.0
"""What was decided about one effect: size with interval, probability, why it was refused."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.fit import Term

NEGLIGIBLE = "present, negligible"
"""reason that applies to a size of no consequence"""
FLAT = "the error does not fall with it"
"""reason that applies to an effect that only the whitened residuals show"""
IMITATED = "these runs cannot tell it from the base"
"""reason that applies to an effect that the base imitates wholly (`Effect.separable`)"""


@dataclass(frozen=True)
class Decision:
    """What was decided about one effect beside the others of a model."""

    term: Term
    """at its most probable size"""
    drop: float
    """drop of the whitened chi2 by the effect"""
    probability: float
    """that the effect, or another one of its class, is present at a size of consequence"""
    interval: tuple[float, float]
    """90 % interval of the size"""
    dispersion: float = 1.0
    """typical scatter of sizes among repeats, relative to the noise model"""
    held_out_gain: float = float("nan")
    """share of the squared error in left-out conditions that the effect removes"""
    reasons: tuple[str, ...] = ()
    """why it was refused; empty when accepted"""
    place: int = -1
    """number of the effect in the set that was weighed"""

    @property
    def accepted(self) -> bool:
        return not self.reasons

    @property
    def slight(self) -> bool:
        """True when only its size is below what matters."""
        return self.reasons == (NEGLIGIBLE,)
