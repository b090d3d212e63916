# SPDX-License-Identifier: Apache-2.0
"""The map of the road's travel, from runs without slip.

The runs are measured with kappa = 0 and --road follow.
"""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import numpy as np

from flatplank_control.bench.results import read_samples
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.calibration.book import ENCODERS, book_for
from flatplank_control.road_map import Run, check_wheel_followed, identify_road_map
from flatplank_data.arguments import Parser, add_json, for_programs
from flatplank_data.campaign import Campaign


def runs_of(folder: Path) -> list[Run]:
    """The runs without slip of a campaign folder; ValueError when there are none."""
    found = []
    for run in Campaign.load(folder).runs:
        if run.info.measurement == "slip" and abs(run.info.kappa) < 1e-9:
            c = read_samples(folder / run.info.file).columns
            rising = c["plank_position"] >= 0.0
            names = ("plank_position", "wheel_angle", "fx")
            samples = Run(*(np.asarray(c[n])[rising] for n in names))
            check_wheel_followed(
                samples, run.info.effective_rolling_radius, str(folder / run.info.file)
            )
            found.append(samples)
    if not found:
        raise ValueError(f"{folder}: no slip runs at kappa = 0; measure some with --road follow")
    return found


def main(argv: list[str]) -> int:
    """Write the map; exit code 0."""
    p = Parser(prog="flatplank road-map", description=__doc__)
    p.add_argument("folder", type=Path, help="campaign folder")
    p.add_argument("--cx", type=float, required=True, help="C_x of the tire [N/mm]")
    p.add_argument("--sigma", type=float, required=True, help="relaxation length [m]")
    p.add_argument("--out", type=Path, default=Path("road.yaml"), help="file of the map")
    add_json(p)
    o = p.parse_args(argv)
    nodes = BenchSetup(kind="lab", calibration=str(book_for(o.folder).path)).constants()
    radius = nodes[ENCODERS]["pinion_pitch_radius"]
    road = identify_road_map(runs_of(o.folder), 1e3 * o.cx, o.sigma, pitch_radius=radius)
    road.save(o.out)
    turn = float(np.hypot(road.mesh_turn_cos, road.mesh_turn_sin))
    tooth = float(np.hypot(road.mesh_tooth_cos, road.mesh_tooth_sin))
    with for_programs(o.json) as found:
        print(
            f"travel {road.road_scale:.5f} of the encoder's, mesh {1e6 * turn:.0f} um once per "
            f"turn, {1e6 * tooth:.0f} um per tooth; {road.force_left:.1f} N are not explained"
        )
        print(f"use it: --road {o.out} of flatplank run --sim and flatplank bench")
        found |= {"file": str(o.out), **asdict(road)}
    return 0
