# SPDX-License-Identifier: Apache-2.0
"""Bench without plans, on the cores of the twin: load, switch, roll, with the true values of the
plant."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from flatplank_control.free_rolling import FreeRollingController, FreeRollingParameters
from flatplank_control.sequencer import SequencerParameters, SlipSequencer
from flatplank_hw.bus.image import BusInputs
from flatplank_hw.cia402 import State
from flatplank_hw.drive import AxisDrive, DriveParameters
from flatplank_hw.encoders import EncoderParameters, Encoders
from flatplank_hw.hub import HubParameters, MeasurementHub
from flatplank_hw.samples import EncoderSample, HubSample
from flatplank_sim.plant import Plant, PlantConfig
from flatplank_validation.truth import truth_row


class StartBench:
    """Bench for benchmarks of the loop. Its rows are road position [m], true Fx [N], true slip
    [-], road velocity [m/s], Fx by the hub [N]."""

    def __init__(
        self,
        tire: str = "toyo",
        *,
        preset: str | None = None,
        rate_hz: int = 250,
        seed: int = 1,
        overrides: Mapping[str, Any] | None = None,
        controller: Mapping[str, Any] | None = None,
        sequencer: Mapping[str, Any] | None = None,
        encoders: Mapping[str, Any] | None = None,
    ) -> None:
        self.config = PlantConfig.load(tire, preset=preset, overrides=overrides)
        rate = float(rate_hz)
        self.rate_hz = rate_hz
        self.plant = Plant(self.config, seed, rate_hz)
        self.hub = MeasurementHub(HubParameters())
        self.encoders = Encoders(EncoderParameters(rate_hz=rate, **(encoders or {})))
        self.controller = FreeRollingController(
            FreeRollingParameters(rate_hz=rate, **{"automatic": False, **(controller or {})})
        )
        self.sequencer = SlipSequencer(
            SequencerParameters(rate_hz=rate, **{"follow_until": 0.0, **(sequencer or {})})
        )
        self.drive = AxisDrive(DriveParameters(free_radius=self.config.tire.free_radius))
        self._commands: tuple = ()

    @property
    def stop_reason(self) -> int:
        return self.sample.stop_reason

    def cycle(self) -> None:
        """Make one bus cycle in the order of the graph."""
        inputs = self.plant.step(self._commands)
        hub, encoders = self.hub.step(inputs), self.encoders.step(inputs)
        self.hub_sample, self.encoder_sample = hub, encoders
        reference = None
        if self.drive.reference_source == "free_rolling":
            reference = self.controller.step(hub, encoders)
        elif self.drive.reference_source == "slip":
            reference = self.sequencer.step(encoders)
        command, self.sample = self.drive.step(inputs, encoders, hub, reference)
        self._commands = (command, *self.more(inputs, encoders, hub))

    def more(self, inputs: BusInputs, encoders: EncoderSample, hub: HubSample) -> tuple:
        """Commands of further axes."""
        return ()

    def until(self, condition: Callable[[], bool], seconds: float = 100.0) -> None:
        """Make cycles until a condition holds; TimeoutError after `seconds`."""
        for _ in range(round(seconds * self.rate_hz)):
            self.cycle()
            if condition():
                return
        raise TimeoutError("the bench waited in vain")

    def ready(self, fz: float, mode: str) -> None:
        """Load the tire to `fz` [N] and enable the drive."""
        operator = self.plant.operator
        operator.load_to(fz)
        self.until(lambda: operator.view.load_reached)
        self.drive.set_operation_mode(mode)
        for _ in range(self.rate_hz // 2):
            self.cycle()
        self.drive.enable()
        self.until(lambda: self.sample.state == State.OPERATION_ENABLED, 2.0)

    def travel(self, distance: float) -> np.ndarray:
        """Move the plank forward by `distance` [m]; returns a row per cycle."""
        self.move_plank()
        rows: list[tuple[float, ...]] = []
        while not rows or rows[-1][0] < distance:
            self.cycle()
            t = self.plant.truth
            fx = self.hub_sample.contact.fx
            rows.append((t.plank_position, t.fx, t.kappa, t.road_velocity, fx))
        return np.array(rows)

    def move_plank(self) -> None:
        """Start the plank forward at its usual speed."""
        self.plant.operator.plank(1, fast=True)

    def free_rolling(self, fz: float, distance: float) -> np.ndarray:
        """Make a run of the free-rolling controller from rest."""
        self.ready(fz, "free_rolling")
        return self.travel(distance)

    def slip(self, fz: float, kappa: float, at: float, distance: float) -> np.ndarray:
        """Make a slip step from rest with the true r_e of the plant."""
        pressure = self.config.tire.nominal_pressure_bar
        radius = truth_row(self.config, fz, pressure).effective_rolling_radius
        self.sequencer.set_slip_step(kappa, at, radius)
        self.ready(fz, "slip")
        return self.travel(distance)
