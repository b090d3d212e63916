# SPDX-License-Identifier: Apache-2.0
"""The bench in one process for tests of the loop: plant, hub, encoders, source, drive."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flatplank_control.free_rolling import FreeRollingController, FreeRollingParameters
from flatplank_control.sequencer import SequencerParameters, SlipSequencer
from flatplank_hw.drive import AxisDrive, DriveParameters
from flatplank_hw.encoders import EncoderParameters, Encoders
from flatplank_hw.hub import HubParameters, MeasurementHub
from flatplank_sim.plant import Plant, PlantConfig

GEAR = 1425.04


class Row(NamedTuple):
    """One cycle of a run."""

    position: float
    velocity: float
    fx: float
    true_fx: float
    true_re: float
    wheel_velocity: float
    motor_velocity: float
    torque: float
    stop_reason: int


class LoopBench:
    """Steps everything once per bus cycle, in the order of the graph."""

    def __init__(
        self, tire: str = "toyo", rate_hz: int = 250, seed: int = 1, defects=None, **controller
    ) -> None:
        config = PlantConfig.load(tire, overrides={"defects": defects} if defects else None)
        self.plant = Plant(config, seed, rate_hz)
        rate = float(rate_hz)
        self.hub = MeasurementHub(HubParameters())
        self.encoders = Encoders(EncoderParameters(rate_hz=rate))
        self.controller = FreeRollingController(
            FreeRollingParameters(rate_hz=rate, **{"automatic": False, **controller})
        )
        self.sequencer = SlipSequencer(SequencerParameters(follow_until=0.0))
        self.drive = AxisDrive(DriveParameters(free_radius=config.tire.free_radius))
        self.commands: tuple = ()
        self.rows: list[Row] = []
        self.rate_hz = rate_hz

    def cycle(self) -> None:
        inputs = self.plant.step(self.commands)
        self.hub_sample = self.hub.step(inputs)
        self.encoder_sample = self.encoders.step(inputs)
        reference = None
        if self.drive.reference_source == "free_rolling":
            reference = self.controller.step(self.hub_sample, self.encoder_sample)
        elif self.drive.reference_source == "slip":
            reference = self.sequencer.step(self.encoder_sample)
        command, self.drive_sample = self.drive.step(
            inputs, self.encoder_sample, self.hub_sample, reference
        )
        self.commands = (command,)

    def run(self, seconds: float, until=None) -> None:
        """For so long, or until a condition holds (then at most so long)."""
        for _ in range(round(seconds * self.rate_hz)):
            self.cycle()
            if until is not None and until():
                return
        assert until is None, "the bench waited in vain"

    def load(self, fz: float, pressure: float | None = None) -> None:
        """Put the tire on the standing road."""
        operator = self.plant.operator
        if pressure is not None:
            operator.pressure(pressure)
        operator.load_to(fz)
        self.run(60.0, until=lambda: operator.view.load_reached)
        self.run(0.5)

    def enable(self, mode: str) -> None:
        """Drive on, in a mode; the wheel waits for the plank."""
        assert self.drive.set_operation_mode(mode).accepted
        assert self.drive.enable().accepted
        self.run(1.0, until=lambda: self.drive_sample.state == 4)

    def travel(self, distance: float) -> np.ndarray:
        """Run the plank forward over so many metres; columns are those of `Row`."""
        self.plant.operator.plank(1, fast=True)
        rows: list[Row] = []
        limit = round(distance / 0.03 * self.rate_hz * 1.2)
        for _ in range(limit):
            self.cycle()
            rows.append(self.row())
            if rows[-1].position >= distance:
                break
        return np.array(rows)

    def row(self) -> Row:
        e, h, truth = self.encoder_sample, self.hub_sample, self.plant.truth
        return Row(
            truth.plank_position, e.plank_velocity, h.contact.fx, truth.fx,
            truth.effective_rolling_radius, e.wheel_velocity, e.motor_velocity,
            self.drive_sample.torque, self.drive_sample.stop_reason,
        )  # fmt: skip
