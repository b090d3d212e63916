# SPDX-License-Identifier: Apache-2.0
"""A hand on the plant for its tests: switches a drive on, sends it set-points, records the
truth.
"""

from __future__ import annotations

import math

import numpy as np

from flatplank_hw.bus.image import AXES, AxisCommand, BusInputs
from flatplank_sim.plant import Plant, PlantConfig

QUIET = {"defects": {"sensor_noise": None, "mains_hum": None}}
TURN = 2.0 * math.pi
GEAR = 1425.04
COUNTS = 2**23


class Rig:
    """One plant with the wheel drive at hand."""

    def __init__(
        self, tire: str = "toyo", over: dict | None = None, seed: int = 0, **kwargs
    ) -> None:
        data = {**QUIET, **(over or {})}
        data["defects"] = {**QUIET["defects"], **data.get("defects", {})}
        self.config = PlantConfig.load(tire, overrides=data, preset=kwargs.pop("preset", None))
        self.plant = Plant(self.config, seed, **kwargs)
        self.inputs: BusInputs = self.plant.step()
        self.word, self.mode = {}, {}
        self.target: dict[int, tuple[int, int, int]] = {}
        self.rows: list[tuple] = []
        self.raw: list[BusInputs] = []
        self.record = False

    def command(self, axis: int) -> AxisCommand:
        position, velocity, torque = self.target.get(axis, (0, 0, 0))
        return AxisCommand(
            axis,
            self.inputs.cycle,
            self.word.get(axis, 0),
            self.mode.get(axis, 9),
            position,
            velocity,
            torque,
            0,
        )

    def run(self, seconds: float, send: bool = True) -> None:
        for _ in range(round(seconds * self.plant.rate_hz)):
            commands = [self.command(a) for a in self.word] if send else ()
            self.inputs = self.plant.step(commands)
            if self.record:
                self.rows.append(self.plant.truth)
                self.raw.append(self.inputs)

    def until(self, test, seconds: float = 400.0) -> None:
        for _ in range(round(seconds * 25)):
            self.run(10 / self.plant.rate_hz)
            if test(self.plant.truth):
                return
        raise AssertionError("the plant did not get there")

    def enable(self, axis: str = "wheel", mode: int = 9) -> None:
        a = AXES.index(axis)
        self.mode[a] = mode
        for word in (0x00, 0x06, 0x07, 0x0F):
            self.word[a] = word
            self.run(0.04)
        assert self.inputs.axes[a].status_word & 0x6F == 0x27

    def wheel_velocity(self, omega: float) -> None:
        self.mode[0] = 9
        self.target[0] = (0, round(omega * GEAR / TURN * COUNTS), 0)

    def wheel_torque(self, torque: float) -> None:
        self.mode[0] = 10
        self.target[0] = (0, 0, round(torque * 1e4))

    def load(self, fz: float = 3700.0) -> None:
        self.plant.operator.load_to(fz)
        self.until(lambda t: self.plant.operator.view.load_reached)

    def roll(self, kappa: float, distance: float, re: float | None = None) -> None:
        """Plank at its fast speed, wheel at a slip, for a distance."""
        re = re or self.plant.truth.effective_rolling_radius
        self.plant.operator.plank(1, fast=True)
        self.wheel_velocity(0.03092 * (1.0 + kappa) / re)
        self.until_position(self.plant.truth.road_position + distance)

    def until_position(self, x: float) -> None:
        while self.plant.truth.road_position < x:
            self.run(0.04)

    def column(self, name: str) -> np.ndarray:
        return np.array([getattr(r, name) for r in self.rows])


def wrap_free(counts: np.ndarray) -> np.ndarray:
    """int32 counts that wrapped, as a growing number."""
    steps = np.diff(counts)
    steps = (steps + 2**31) % 2**32 - 2**31
    return np.concatenate([[0], np.cumsum(steps)])
