# SPDX-License-Identifier: Apache-2.0
"""What an effect of the flat plank can touch: four hooks that do nothing by default.

Arrays have the shape (lanes, runs, samples), parameters of the effect broadcast against them.
Change arrays in place or assign new ones; what is assigned replaces the old.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from flatplank_analysis.discovery.effect import Effect

if TYPE_CHECKING:
    from flatplank_analysis.contact_patch.data import TireRuns


class Motion:
    """What the machine really does between two nodes; starts as what the encoders saw."""

    def __init__(self, data: TireRuns, travel, rolled, lateral) -> None:
        self.data = data
        self.travel = travel
        """increments of plank travel [m]"""
        self.rolled = rolled
        """increments of the rolled distance, wheel angle times rolling radius [m]"""
        self.lateral = lateral
        """increments of lateral slip travel [m]"""


class Tire:
    """Load, friction and the tire's own numbers."""

    def __init__(self, data: TireRuns, load, friction, x: Block, y: Block) -> None:
        self.data = data
        self.load = load
        """vertical load on the tire [N]"""
        self.friction = friction
        """factor on the friction"""
        self.x = x
        self.y = y


class Block:
    """The tire's numbers in one direction by name, each (lanes, runs); see `kernel.NAMES`."""

    def __init__(self, values: np.ndarray, names: tuple[str, ...]) -> None:
        object.__setattr__(self, "_values", values)
        object.__setattr__(self, "_at", {name: i for i, name in enumerate(names)})

    def __getattr__(self, name: str) -> np.ndarray:
        try:
            return self._values[..., self._at[name]]
        except KeyError:
            raise AttributeError(f"the tire has no number '{name}'") from None

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in self._at:
            raise AttributeError(f"the tire has no number '{name}'")
        self._values[..., self._at[name]] = value


class Node:
    """One node while it is computed; arrays (lanes, runs)."""

    def __init__(self, data: TireRuns) -> None:
        self.data = data
        self.index = 0
        self.memory: dict[str, np.ndarray] = {}
        """what the effect wants to remember from node to node"""
        self.force_x: np.ndarray
        self.force_y: np.ndarray
        self.travel: np.ndarray
        self.slip: np.ndarray
        """increment of longitudinal slip travel [m]"""
        self.lateral: np.ndarray
        self.load: np.ndarray
        self.friction: np.ndarray


class Signal:
    """What the sensors say; starts as the force of the tire."""

    def __init__(self, data: TireRuns, fx, fy, fz, true_fx, true_fy) -> None:
        self.data = data
        self.fx = fx
        self.fy = fy
        self.fz = fz
        """what the load channel shows beside the load that is fed to the tire [N]"""
        self.true_fx = true_fx
        """force of the tire itself [N]"""
        self.true_fy = true_fy


@dataclass(frozen=True)
class TireEffect(Effect):
    """Base of all effects on the flat plank. Override the hooks that the physics needs."""

    ranges: ClassVar[Mapping[str, tuple[float, float]]] = {}
    """by coordinate the range in which the effect was seen; columns of a table need it"""

    def motion(self, motion: Motion) -> None:
        """Change what plank and wheel really do; `motion.travel`, `.rolled`, `.lateral`."""

    def tire(self, tire: Tire) -> None:
        """Change load, friction or the numbers of the tire."""

    def node(self, node: Node) -> None:
        """Change one node knowing the forces of the last one (slower: a Python loop)."""

    def signal(self, signal: Signal) -> None:
        """Change what the sensors show."""

    @classmethod
    def overrides(cls, hook: str) -> bool:
        """True when the effect uses a hook."""
        return getattr(cls, hook) is not getattr(TireEffect, hook)
