# SPDX-License-Identifier: Apache-2.0
"""Other tires from which the base is fitted again where it fits nowhere from its usual start."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from flatplank_analysis.discovery.parameters import Parameter

TIRES: tuple[Mapping[str, float], ...] = (
    {"stiff": 0.5, "peak": 0.75, "carcass": 0.5, "stiff_y": 0.5, "carcass_y": 0.6},
    {"stiff": 1.9, "peak": 1.35, "carcass": 2.5, "stiff_y": 1.9, "carcass_y": 2.5},
    {"stiff": 1.0, "peak": 1.0, "carcass": 4.0, "half": 1.5, "stiff_y": 1.0, "carcass_y": 4.0},
)
"""factors on the usual start values: a soft, a stiff one, and one that is all tread"""


def other_starts(parameters: Sequence[Parameter]) -> tuple[dict[str, float], ...]:
    """Start values by name, each inside its range."""
    return tuple(
        {
            p.name: min(max(p.null * tire[p.name], p.lower), p.upper)
            for p in parameters
            if p.name in tire
        }
        for tire in TIRES
    )
