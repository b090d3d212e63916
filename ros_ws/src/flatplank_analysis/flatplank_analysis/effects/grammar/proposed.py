# SPDX-License-Identifier: Apache-2.0
"""Base classes of the effects that a sentence of the grammar makes."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.effects.base import TireEffect
from flatplank_analysis.effects.sweep_base import SweepEffect


class _Proposed(Effect):
    """What `flatplank propose` writes, until the cause is known."""

    source = "flatplank propose"
    removes = "Removing its cause; until then this file in the model."
    interval: ClassVar[tuple[float, float]]
    """90 % interval of the size in the search [SI], for comparison with new runs"""

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        first = cls.what.partition(",")[0].rstrip(".")
        cls.title = vars(cls).get("title") or f"Proposed: {first[:1].lower()}{first[1:]}"

    @classmethod
    def size(cls, values: dict[str, float]) -> float:
        """Value of the main parameter; amplitude of a wave."""
        if "cos" in values:
            return float(np.hypot(values["cos"], values["sin"]))
        return super().size(values)


class Proposed(_Proposed, TireEffect):
    """A proposed effect of the flat plank."""


class ProposedInSweeps(_Proposed, SweepEffect):
    """A proposed effect in sweeps."""
