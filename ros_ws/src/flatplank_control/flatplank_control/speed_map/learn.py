# SPDX-License-Identifier: Apache-2.0
"""A map of the rack mesh and the mean error of the encoder, from the force of kappa = 0 runs.

The tire is the sensor: Fx = C_Fk kappa in the mean, and de/dx = -(dFx/dx + Fx/sigma)/C_x for an
error e of the travel. C_x is about 200 N/mm, so 10 um is 2 N.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml

from flatplank_hw.params import nearest

SETTLED = 0.6
"""of the road until the start is forgotten [m]"""


class Run(NamedTuple):
    """Samples of a run without slip, shape (n,)."""

    position: np.ndarray
    """of the plank by its encoder [m]"""
    wheel_angle: np.ndarray
    """[rad]"""
    fx: np.ndarray
    """[N]"""


@dataclass(frozen=True)
class RoadMap:
    """Travel of the road over what the encoder says."""

    road_scale: float
    """mean; the parameter of the slip sequencer"""
    turn_cos: float
    """once per turn of the pinion [m]"""
    turn_sin: float
    tooth_cos: float
    """once per tooth [m]"""
    tooth_sin: float
    force_left: float
    """rms of Fx that the map does not explain [N]"""

    def parameters(self) -> dict[str, float]:
        """Of the slip sequencer: what follows the road's travel by this map."""
        return {
            "road_scale": self.road_scale,
            "mesh_turn_cos": self.turn_cos,
            "mesh_turn_sin": self.turn_sin,
            "mesh_tooth_cos": self.tooth_cos,
            "mesh_tooth_sin": self.tooth_sin,
        }

    def save(self, path: Path) -> None:
        path.write_text(yaml.safe_dump(asdict(self), sort_keys=False), encoding="utf-8")

    @staticmethod
    def load(path: Path) -> RoadMap:
        """ValueError names an unknown key."""
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
        known = RoadMap.__dataclass_fields__
        for key in data:
            if key not in known:
                raise ValueError(f"{path}: unknown key '{key}'{nearest(key, known)}")
        return RoadMap(**data)


def learn(
    runs: Sequence[Run],
    stiffness: float,
    relaxation: float,
    *,
    scale: float = 1.0,
    pitch_radius: float = 0.05,
    tooth: float = 0.01571,
) -> RoadMap:
    """The map from runs made with `scale`, for C_x [N/m] and sigma [m]; tooth and radius in m."""
    if not runs or not (stiffness > 0.0 and relaxation > 0.0):
        raise ValueError("speed map: give kappa = 0 runs and a tire with C_x and sigma above 0")
    waves = (1.0 / pitch_radius, 2.0 * math.pi / tooth)
    rows, forces = [], []
    for run in runs:
        keep = run.position > SETTLED
        x, angle = run.position[keep], run.wheel_angle[keep]
        if x.size < 100:
            raise ValueError(f"speed map: a run ends at {run.position.max():.2f} m; 1 m is needed")
        # e cos(w x) gives a force through the first-order tire, in phase and out of phase
        columns = [np.ones_like(x)]
        for w in waves:
            answer = -stiffness * 1j * w / (1j * w + 1.0 / relaxation)
            e = np.exp(1j * w * x) * answer
            columns += [e.real, e.imag]
        # what turns with the wheel is no error of the road
        columns += [np.cos(angle), np.sin(angle)]
        rows.append(np.column_stack(columns))
        forces.append(run.fx[keep])
    a, f = np.vstack(rows), np.concatenate(forces)
    p = np.linalg.lstsq(a, f, rcond=None)[0]
    slip = float(p[0]) / (stiffness * relaxation)
    left = float(np.sqrt(np.mean((f - a @ p) ** 2)))
    turn_cos, turn_sin, tooth_cos, tooth_sin = (float(v) for v in p[1:5])
    return RoadMap(float(scale / (1.0 + slip)), turn_cos, turn_sin, tooth_cos, tooth_sin, left)
