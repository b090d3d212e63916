# SPDX-License-Identifier: Apache-2.0
"""Hooks of an effect of the flat plank: four methods that do nothing by default.

Arrays have the shape (sets, runs, samples), parameters of the effect broadcast against them.
Change arrays in place or assign new ones.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.runs import RunSet

if TYPE_CHECKING:
    from flatplank_analysis.contact_patch.tire_runs import TireRuns

OTHER_SPEED = 1.2
"""ratio of the plank speeds from which on what takes time can be told from what takes a way"""


@dataclass(eq=False)
class Motion:
    """Real motion of the machine between two nodes; starts as the encoders measured it."""

    data: TireRuns
    travel: np.ndarray
    """increments of plank travel [m]"""
    rolled: np.ndarray
    """increments of the rolled distance, wheel angle times rolling radius [m]"""
    lateral: np.ndarray
    """increments of lateral slip travel [m]"""


@dataclass(eq=False)
class Tire:
    """Load, friction and the tire's own parameters."""

    data: TireRuns
    load: np.ndarray
    """vertical load on the tire [N]"""
    friction: np.ndarray
    """factor on the friction"""
    x: Block
    y: Block
    """parameters along (x) and across (y) the wheel plane"""


class Block:
    """The tire's parameters in one direction by name, each (sets, runs); see `kernel.NAMES`."""

    def __init__(self, values: np.ndarray, names: tuple[str, ...]) -> None:
        object.__setattr__(self, "_values", values)
        object.__setattr__(self, "_at", {name: i for i, name in enumerate(names)})

    def __getattr__(self, name: str) -> np.ndarray:
        if name not in self._at:
            raise AttributeError(f"the tire has no parameter '{name}'")
        return self._values[..., self._at[name]]

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in self._at:
            raise AttributeError(f"the tire has no parameter '{name}'")
        self._values[..., self._at[name]] = value


class Node:
    """One node during the computation; arrays (sets, runs)."""

    force_x: np.ndarray
    force_y: np.ndarray
    """forces of the tire at the last node [N]"""
    travel: np.ndarray
    """increment of plank travel [m]"""
    slip: np.ndarray
    """increment of longitudinal slip travel [m]"""
    lateral: np.ndarray
    """increment of lateral slip travel [m]"""
    load: np.ndarray
    """vertical load on the tire [N]"""
    friction: np.ndarray
    """factor on the friction"""

    def __init__(self, data: TireRuns) -> None:
        self.data = data
        self.index = 0
        self.memory: dict[str, np.ndarray] = {}
        """values that the effect keeps from node to node"""


@dataclass(eq=False)
class Signal:
    """Readings of the sensors; starts as the force of the tire."""

    data: TireRuns
    fx: np.ndarray
    fy: np.ndarray
    fz: np.ndarray
    """change of the load reading relative to the load on the tire [N]"""
    true_fx: np.ndarray
    true_fy: np.ndarray
    """forces of the tire itself [N]"""


@dataclass(frozen=True)
class TireEffect(Effect):
    """Base of all effects on the flat plank. Override the hooks that the physics needs."""

    ranges: ClassVar[Mapping[str, tuple[float, float]]] = {}
    """by coordinate: the range in which the effect was observed; required for table columns"""

    def motion(self, motion: Motion) -> None:
        """Change the real motion of plank and wheel: `motion.travel`, `.rolled`, `.lateral`."""

    def tire(self, tire: Tire) -> None:
        """Change load, friction or the parameters of the tire."""

    def node(self, node: Node) -> None:
        """Change one node, given the forces at the last one (slow: a loop in Python)."""

    def signal(self, signal: Signal) -> None:
        """Change the readings of the sensors."""

    @classmethod
    def overrides(cls, hook: str) -> bool:
        """True when the effect uses a hook."""
        return getattr(cls, hook) is not getattr(TireEffect, hook)


@dataclass(frozen=True)
class Wave(TireEffect):
    """Base of effects with a parameter `cos` and one `sin`; the size is their amplitude."""

    @classmethod
    def size(cls, values: dict[str, float]) -> float:
        return float(np.hypot(values["cos"], values["sin"]))


@dataclass(frozen=True)
class TireProperty(TireEffect):
    """Base of effects that belong to the tire itself."""

    kind = "tire"
    removes = "Nothing: it belongs to the tire."


def several_speeds(runs: RunSet) -> bool:
    """True when the plank speeds of the runs differ (`OTHER_SPEED`)."""
    speed = runs.facts["speed"]
    return bool(speed.max() > OTHER_SPEED * speed.min())
