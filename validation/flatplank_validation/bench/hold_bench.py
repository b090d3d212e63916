# SPDX-License-Identifier: Apache-2.0
"""Compares load and steering angle with and without their controllers on the same plant."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from flatplank_control.bench.setup import AXIS_NODES, BenchSetup
from flatplank_sim.twin.twin import TwinAxis, make_axis
from flatplank_validation.bench.start_bench import StartBench
from flatplank_validation.truth import truth_row

UNDULATION = {
    "support_bearings": {
        "positions": [0.6, 1.0, 1.4, 1.8], "heights": [1.2e-4, -1.5e-4, 2.0e-4, -2.5e-4]
    },
    "load_change": {"brake": 0.0097, "drive": 0.0040},
    "run_out": {"amplitude": 1.0e-4},
}  # fmt: skip
"""defects that change the load: support bearings of the plank, load change with Fx, run-out"""
PLAY: dict[str, dict[str, float]] = {"steering_play": {}}
FZ, PRESSURE = 3700.0, 2.5


class HoldBench(StartBench):
    """Bench with one more driven axis and its controller, which may be off."""

    def __init__(
        self,
        axis: str,
        on: bool,
        defects: Mapping[str, Any],
        controller: Mapping[str, Any] | None = None,
        overrides: Mapping[str, Any] | None = None,
        tire: str = "toyo",
    ) -> None:
        plant = {"driven_axes": ["wheel", axis], "defects": dict(defects), **(overrides or {})}
        super().__init__(tire, overrides=plant, sequencer={"follow_until": 0.25})
        name = AXIS_NODES[axis].controller.name
        setup = BenchSetup(axes=(axis,), parameters={name: dict(controller or {})})
        self.axis: TwinAxis = make_axis(setup, axis)
        self.on = on

    def more(self, inputs, encoders, hub) -> tuple:
        return (self.axis.step(inputs, encoders, hub),)

    def take(self) -> None:
        """Give the axis to its controller, if that is on."""
        if self.on:
            self.axis.follow(True)
            self.until(lambda: self.axis.enabled, 2.0)


def load_over_the_road(on: bool, kappa: float, distance: float = 2.2) -> dict[str, float]:
    """Largest error of the true Fz over bearings and while braking, and error of its mean [%]."""
    bench = HoldBench("vertical", on, UNDULATION)
    radius = truth_row(bench.config, FZ, PRESSURE).effective_rolling_radius
    bench.sequencer.set_slip_step(kappa, 0.5, radius)
    bench.ready(FZ, "slip")
    bench.axis.controller.set_load(FZ)
    bench.take()
    bench.plant.operator.plank(1, fast=True)
    fz: list[float] = []
    while bench.plant.truth.plank_position < distance:
        bench.cycle()
        fz.append(bench.plant.truth.fz)
    errors = 100.0 * (np.array(fz) / FZ - 1.0)
    return {"worst_percent": float(np.abs(errors).max()), "mean_percent": float(errors.mean())}


def load_step(first: float, second: float, tire: str = "toyo") -> dict[str, float]:
    """Overshoot and final error [%] after a new set-point [N], with the tire at rest."""
    bench = HoldBench("vertical", True, {}, tire=tire)
    operator = bench.plant.operator
    operator.load_to(first)
    bench.until(lambda: operator.view.load_reached)
    bench.axis.controller.set_load(first)
    bench.take()
    bench.axis.controller.set_load(second)
    fz = []
    for _ in range(6 * bench.rate_hz):
        bench.cycle()
        fz.append(bench.plant.truth.fz)
    sense = math.copysign(1.0, second - first)
    beyond = max(sense * (np.array(fz) - second))
    return {
        "overshoot_percent": 100.0 * max(beyond, 0.0) / second,
        "end_percent": 100.0 * (fz[-1] / second - 1.0),
    }


def steering(way: str, alpha_deg: float = 5.0, distance: float = 1.5) -> dict[str, float]:
    """Error of the true slip angle [deg] while the tire moves the hub through its play."""
    on = way != "free"
    controller = {"play": math.radians(0.2)} if way == "by_moment" else {}
    overrides = {"encoders.steer_on_hub": True} if way == "by_hub_encoder" else {}
    bench = HoldBench("steer", on, PLAY, controller, overrides)
    operator = bench.plant.operator
    alpha = math.radians(alpha_deg)
    operator.steer(alpha)
    bench.until(lambda: operator.view.at_target)
    radius = truth_row(bench.config, FZ, PRESSURE).effective_rolling_radius
    bench.sequencer.set_slip_step(0.0, 0.5, radius)
    bench.ready(FZ, "slip")
    bench.take()
    bench.axis.controller.hold(alpha)
    operator.plank(1, fast=True)
    errors = []
    while bench.plant.truth.plank_position < distance:
        bench.cycle()
        t = bench.plant.truth
        if t.plank_position > 0.3:
            errors.append(math.degrees(t.alpha - alpha))
    return {"mean_deg": float(np.mean(errors)), "worst_deg": float(np.abs(errors).max())}
