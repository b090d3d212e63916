# SPDX-License-Identifier: Apache-2.0
"""Identifies travel of the road that the pinion encoder does not measure, from runs without slip.

A map has the mean error of the encoder and the mesh error of the rack. Both follow from the force
of runs at kappa = 0. The mean force is Fx = C_Fk kappa. An error e of the travel x changes the
force by de/dx = -(dFx/dx + Fx/sigma)/C_x; with C_x of about 200 N/mm, 10 um give 2 N."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from flatplank_control.bench.setup import BenchSetup
from flatplank_control.sequencer import SequencerParameters
from flatplank_data.params import Params, from_mapping, param
from flatplank_data.yaml_text import dump_yaml, load_yaml

FOLLOW_TOLERANCE = 3e-4
"""largest relative error of a wheel that follows the encoder's travel; the mean error that a map
corrects is five times as large [-]"""
SETTLED = 0.6
"""road after which the start has no effect any more [m]"""
STOPPING = 0.02
"""road left out at the end of a run, where the plank stops before the wheel [m]"""


class Run(NamedTuple):
    """Samples of a run without slip, shape (n,)."""

    position: np.ndarray
    """plank position by its encoder [m]"""
    wheel_angle: np.ndarray
    """[rad]"""
    fx: np.ndarray
    """[N]"""


_SEQUENCER = {f.name: f for f in fields(SequencerParameters)}


def _of_the_sequencer(name: str) -> Any:
    """A field with default, unit and range of this parameter of the slip sequencer."""
    return param(_SEQUENCER[name].default, **_SEQUENCER[name].metadata)


@dataclass(frozen=True)
class RoadMap(Params):
    """Travel of the road as a function of the encoder's travel."""

    road_scale: float = _of_the_sequencer("road_scale")
    mesh_turn_cos: float = _of_the_sequencer("mesh_turn_cos")
    mesh_turn_sin: float = _of_the_sequencer("mesh_turn_sin")
    mesh_tooth_cos: float = _of_the_sequencer("mesh_tooth_cos")
    mesh_tooth_sin: float = _of_the_sequencer("mesh_tooth_sin")
    tooth_pitch: float = _of_the_sequencer("tooth_pitch")
    force_left: float = param(
        0.0, "rms of Fx that the map does not explain", unit="N", bounds=(0.0, 1e5)
    )

    def parameters(self) -> dict[str, float]:
        """Parameters that let the slip sequencer follow the road's travel by this map."""
        values = asdict(self)
        del values["force_left"]
        return values

    def save(self, path: Path) -> None:
        path.write_text(dump_yaml(asdict(self)), encoding="utf-8")

    @staticmethod
    def load(path: Path) -> RoadMap:
        """Read a map; ValueError names what is wrong with the file."""
        try:
            data = load_yaml(path.read_bytes(), path)
        except OSError as error:
            raise ValueError(
                f"{path}: cannot be read ({error.strerror}); flatplank road-map makes one"
            ) from None
        found = data if isinstance(data, dict) else {}
        missing = set(RoadMap.__dataclass_fields__).difference(found)
        if missing:
            raise ValueError(
                f"{path}: no road map, it has no {sorted(missing)[0]}; "
                "flatplank road-map makes one"
            )
        return from_mapping(RoadMap, found, str(path))


def identify_road_map(
    runs: Sequence[Run], stiffness: float, relaxation: float, *, pitch_radius: float = 0.05
) -> RoadMap:
    """Identify the map from runs in which the wheel followed the encoder.

    stiffness: C_x [N/m]; relaxation: sigma [m]; pitch_radius: of the pinion [m]. ValueError
    without runs, or when C_x or sigma is not above 0.
    """
    if not runs or not (stiffness > 0.0 and relaxation > 0.0):
        raise ValueError("road map: give kappa = 0 runs and a tire with C_x and sigma above 0")
    tooth = RoadMap.tooth_pitch
    waves = (1.0 / pitch_radius, 2.0 * math.pi / tooth)
    rows, forces = [], []
    for run in runs:
        x, angle, fx = _rolling(run, "road map")
        # an error e cos(w x) gives a force with in-phase and quadrature parts (first-order tire)
        columns = [np.ones_like(x)]
        for w in waves:
            answer = -stiffness * 1j * w / (1j * w + 1.0 / relaxation)
            e = np.exp(1j * w * x) * answer
            columns += [e.real, e.imag]
        # a component with the period of the wheel is no error of the road
        columns += [np.cos(angle), np.sin(angle)]
        rows.append(np.column_stack(columns))
        forces.append(fx)
    a, f = np.vstack(rows), np.concatenate(forces)
    p = np.linalg.lstsq(a, f, rcond=None)[0]
    slip = float(p[0]) / (stiffness * relaxation)
    left = float(np.sqrt(np.mean((f - a @ p) ** 2)))
    turn_cos, turn_sin, tooth_cos, tooth_sin = (float(v) for v in p[1:5])
    return RoadMap(
        float(1.0 / (1.0 + slip)), turn_cos, turn_sin, tooth_cos, tooth_sin, tooth, left
    )


def _rolling(run: Run, where: str) -> Run:
    """Samples between start and stop; ValueError when the run is too short."""
    end = float(run.position.max())
    if end < 1.0:
        raise ValueError(f"{where}: a run ends at {end:.2f} m; 1 m is needed")
    keep = (run.position > SETTLED) & (run.position < end - STOPPING)
    return Run(*(column[keep] for column in run))


def check_wheel_followed(run: Run, radius: float, where: str) -> None:
    """Raise ValueError when the wheel did not follow the encoder: its slip then changes the force.

    radius: effective rolling radius of the slip control [m].
    """
    x, angle, _ = _rolling(run, where)
    part = float(radius * (angle[-1] - angle[0]) / (x[-1] - x[0]))
    if not abs(part - 1.0) < FOLLOW_TOLERANCE:
        raise ValueError(
            f"{where}: the wheel rolled {part:.4f} of the encoder's travel; "
            "a road map needs runs that were made with --road follow"
        )


FOLLOW_ENCODER = "follow"
WHOLE_RUN = 100.0
"""road longer than any run [m]"""
NODE = "slip_sequencer"


def with_road(setup: BenchSetup, road: str) -> BenchSetup:
    """Bench set-up for `road`: empty for constant speed, `follow` for the encoder's travel, else
    the file of a map."""
    if not road:
        return setup
    values: dict[str, Any] = {"follow_until": WHOLE_RUN}
    if road != FOLLOW_ENCODER:
        values |= RoadMap.load(Path(road)).parameters()
    own = {**setup.parameters.get(NODE, {}), **values}
    return replace(setup, parameters={**setup.parameters, NODE: own})
