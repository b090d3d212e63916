# SPDX-License-Identifier: Apache-2.0
"""Quantities on which a proposed effect in sweeps may act, each in one method of `SweepEffect`.

The function of a hook applies a change: the value of the shape, in `unit`, (runs, nodes).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from flatplank_analysis.effects.grammar.hooks import ALL, NONE, Hook
from flatplank_analysis.effects.grammar.proposed import ProposedInSweeps

COORDINATES = tuple(kind for kind in ALL if kind != NONE)
"""without one, every effect of sweeps is in the library or in the base"""


def _to_grip(s: Any, change: np.ndarray) -> None:
    s.grip = s.grip * (1.0 + _in_nodes(s, change))


def _to_stiffness(s: Any, change: np.ndarray) -> None:
    s.stiffness = s.stiffness * (1.0 + _in_nodes(s, change))


def _to_angle(s: Any, change: np.ndarray) -> None:
    s.alpha = s.alpha + _in_nodes(s, change)


def _to_force(s: Any, change: np.ndarray) -> None:
    s.force = s.force + _in_nodes(s, change)


def _to_factor(s: Any, change: np.ndarray) -> None:
    s.force = s.force * (1.0 + _in_nodes(s, change))


def _in_nodes(s: Any, change: np.ndarray) -> np.ndarray:
    """A change for one set of values, (1, runs, nodes) or (runs, nodes), in the nodes."""
    return np.reshape(change, s.fz.shape)


SWEEP_HOOKS: tuple[Hook, ...] = (
    Hook("swept grip", "friction", "tire", _to_grip, "1", 0.02, 0.01, 0.5, "tire",
         "a factor on the friction", "Sweep once more at both ends of the range",
         kinds=COORDINATES, steady=True, base=ProposedInSweeps),
    Hook("swept stiffness", "stiffness", "tire", _to_stiffness, "1", 0.02, 0.01, 0.5, "tire",
         "a factor on the slip stiffness", "Sweep once more at both ends of the range",
         kinds=COORDINATES, steady=True, base=ProposedInSweeps),
    Hook("swept angle", "motion", "tire", _to_angle, "rad", 1e-3, 2e-4, 0.05, "machine",
         "a slip angle that the file does not show", "Measure the steering angle at the wheel",
         kinds=COORDINATES, needs="fy", shown=True, base=ProposedInSweeps),
    Hook("swept force", "signal", "bench", _to_force, "N", 10.0, 5.0, 2000.0, "sensor",
         "an offset of the measured force", "Look at the force of the unloaded wheel",
         kinds=COORDINATES, steady=True, base=ProposedInSweeps),
    Hook("swept factor", "gain", "bench", _to_factor, "1", 0.01, 0.005, 0.5, "sensor",
         "a factor on the measured force", "Compare the force with weights",
         kinds=COORDINATES, base=ProposedInSweeps),
)  # fmt: skip
