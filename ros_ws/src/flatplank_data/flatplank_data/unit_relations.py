# SPDX-License-Identifier: Apache-2.0
"""What is known of a run several times: quotients of columns that are 1 in SI."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

COARSE = 0.5 * math.log(1000.0)
"""half of a factor of 1000: what is known only by its order of magnitude is this uncertain"""


@dataclass(frozen=True)
class Relation:
    """A quotient of columns that is 1 in SI."""

    text: str
    """what the quotient compares, with both values"""
    off: float
    """natural logarithm of the quotient"""
    powers: Mapping[str, int]
    """column -> its exponent in the quotient"""
    below: float = 0.0
    """logarithm by which the quotient may be too small without another unit"""
    above: float = 0.0
    """the same for a quotient that is too large"""

    def rest(self, column: str = "", factor: float = 1.0) -> float:
        """What is left of the logarithm when a column is multiplied by a factor."""
        off = self.off + self.powers.get(column, 0) * math.log(factor)
        return max(-off - self.below, off - self.above, 0.0)


def relation(
    name: str, one: float, other: float, unit: str, powers: Mapping[str, int],
    below: float = 0.0, above: float = 0.0,
) -> Iterator[Relation]:  # fmt: skip
    """`one` over `other`, when both are numbers other than zero."""
    quotient = abs(one / other) if other else math.nan
    if math.isfinite(quotient) and quotient > 0.0:
        text = name.format(f"{abs(one):.3g} {unit}", f"{abs(other):.3g} {unit}")
        yield Relation(text, math.log(quotient), powers, below, above)
