# SPDX-License-Identifier: Apache-2.0
"""Cases of the start benchmark: tires with given C_x and sigma, and true slip against the road."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from flatplank_control.free_rolling.loop import phase_margin
from flatplank_control.road_map import Run, identify_road_map
from flatplank_validation.bench.start_bench import StartBench
from flatplank_validation.truth import truth_row

TOYO = 203_000.0
"""C_x of the Toyo [N/m]"""
HALF_LENGTH = 0.0708
FZ, PRESSURE, RADIUS = 3700.0, 2.5, 0.05
PINION_TURN = 2.0 * math.pi * RADIUS
ROAD_DEFECTS = {
    "road_speed_error": {"relative": 0.0013, "unseen": 0.0015},
    "speed_droop": {"per_kn": 0.0008},
    "mesh_ripple": {"tooth": 20e-6, "turn": 40e-6},
}
"""defects of the road's speed: encoder error, droop under load, mesh ripple"""


class Made(NamedTuple):
    """A tire and a loop delay."""

    share: float
    """C_x over that of the Toyo [-]"""
    sigma: float
    """relaxation length [m]"""
    rate: int
    """bus rate [Hz]"""
    cycles: int
    """delay [cycles]"""


FURTHER = (
    Made(0.5, 1.0, 250, 2), Made(0.5, 0.15, 250, 3), Made(2.0, 0.3, 250, 1),
    Made(3.0, 0.12, 500, 2), Made(5.0, 0.08, 250, 2),
)  # fmt: skip
"""further cases, with delays of 5 to 14 ms including the hold"""


def like(stiffness: float, sigma: float) -> dict[str, float]:
    """Overrides of the Toyo that give C_x [N/m] and sigma [m]: tread and carcass in series."""
    tread = stiffness * sigma / HALF_LENGTH
    return {
        "tire.tread_stiffness_x": tread / (2.0 * HALF_LENGTH),
        "tire.carcass_stiffness_x": 1.0 / (1.0 / stiffness - 1.0 / tread),
    }


def further(made: Made, controller: Mapping[str, Any]) -> dict[str, float]:
    """Phase margin with the gains estimated at the start, and variation of the true force."""
    bench = StartBench(
        "toyo",
        rate_hz=made.rate,
        overrides={**like(made.share * TOYO, made.sigma), "command_delay_cycles": made.cycles},
        controller={**controller, "delay_cycles": float(made.cycles)},
    )
    rows = bench.free_rolling(FZ, 0.8)
    truth = truth_row(bench.config, FZ, PRESSURE)
    delay = (made.cycles + 0.5) / made.rate
    tire = (truth.standstill_stiffness_x, truth.relaxation_length_x)
    return {
        "phase_margin_deg": phase_margin(bench.controller.gains, *tire, delay),
        "swing_n": float(np.ptp(rows[rows[:, 0] > 0.4, 1])),
    }


def driven(
    kappa: float, distance: float, wrong: float = 1.0, road_encoder: bool = False, **sequencer: Any
) -> tuple[Run, np.ndarray]:
    """Measured samples, and true slip against the true road, averaged over turns of the pinion."""
    fitted = {"encoders.road_encoder_fitted": True} if road_encoder else {}
    bench = StartBench(
        "toyo",
        overrides={"defects": ROAD_DEFECTS, **fitted},
        sequencer=sequencer,
        encoders={"road_encoder_fitted": True} if road_encoder else None,
    )
    radius = wrong * truth_row(bench.config, FZ, PRESSURE).effective_rolling_radius
    bench.sequencer.set_slip_step(kappa, 0.5, radius)
    bench.ready(FZ, "slip")
    bench.encoders.arm()
    bench.plant.operator.plank(1, fast=True)
    measured: list[Any] = []
    true: list[Any] = []
    while not true or true[-1][0] < distance:
        bench.cycle()
        e, t = bench.encoder_sample, bench.plant.truth
        measured.append((e.plank_position, e.wheel_angle, bench.hub_sample.contact.fx))
        true.append((t.road_position, t.wheel_angle, t.effective_rolling_radius))
    rows = np.array(true)
    first, slips = int(np.searchsorted(rows[:, 0], 1.2)), []
    while (last := int(np.searchsorted(rows[:, 0], rows[first, 0] + PINION_TURN))) < len(rows):
        turned = (rows[last, 1] - rows[first, 1]) * rows[first:last, 2].mean()
        slips.append(turned / (rows[last, 0] - rows[first, 0]) - 1.0)
        first = last
    return Run(*np.array(measured).T), np.array(slips)


def slip_errors(kappa: float) -> dict[str, float]:
    """Largest error of the mean slip over a turn of the pinion [%], by the thesis's method and
    ours."""
    truth = truth_row(StartBench("toyo").config, FZ, PRESSURE)
    run, _ = driven(0.0, 3.2, follow_until=100.0)
    road = identify_road_map([run], truth.standstill_stiffness_x, truth.relaxation_length_x)
    ways: dict[str, dict[str, Any]] = {
        "thesis": {},
        "ours": {"follow_until": 100.0, **road.parameters()},
    }
    found = {}
    for way, sequencer in ways.items():
        _, slips = driven(kappa, 2.2, **sequencer)
        found[way] = 100.0 * float(np.abs(slips - kappa).max())
    return found
