# SPDX-License-Identifier: Apache-2.0
"""What all effects that are a gap in the machine have in common."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import TireEffect


@dataclass(frozen=True)
class Gap(TireEffect):
    """Free travel in the direction of the slip."""

    coordinate = "slip travel"
    main = "gap"

    gap: float = param(
        0.0,
        unit="m",
        bounds=(0.0, 3e-3),
        screen=3e-4,
        matters=1e-4,
        note="lost motion at the road",
    )

    @classmethod
    def starts(cls) -> tuple[float, ...]:
        return (1.0, 2.5)
