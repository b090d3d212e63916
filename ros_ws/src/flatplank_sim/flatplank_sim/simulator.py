# SPDX-License-Identifier: Apache-2.0
"""Implements the interface to the simulated bench, flatplank_control/bench/simulator.py."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from flatplank_control.bench.results import read_samples
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.calibration.fits import amplitudes_under_load
from flatplank_control.calibration.parasitic import UnloadedTurns, turn_of
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.plans import plan_of
from flatplank_data.errors import FlatplankError
from flatplank_data.machine import GEAR_RATIO
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_hw.cia402 import TORQUE_UNIT
from flatplank_sim.plant import PlantConfig, presets, tires
from flatplank_sim.sealed.generate import make_challenge
from flatplank_sim.twin.campaign import run_on_twin
from flatplank_sim.twin.log import TableLog
from flatplank_sim.twin.twin import Cycle, Twin
from flatplank_sim.twin.twin_bench import TwinBench

MOTOR_SPEEDS = (5.0, 20.0, 60.0, 100.0, 142.0, 180.0, 220.0)
"""speeds of the motor at which friction is measured, 142 in free rolling [rad/s]"""

__all__ = [
    "check", "filter_on_twin", "free_radius", "make_challenge", "presets", "run_on_twin",
    "speeds_on_twin", "tires", "turn_on_twin",
]  # fmt: skip


def free_radius(tire: str) -> float:
    """r_0 of a simulated tire [m]."""
    return PlantConfig.load(tire).tire.free_radius


def check(tire: str, preset: str) -> None:
    """Raise ValueError or OSError when the plant has no such tire or preset."""
    PlantConfig.load(tire, preset=preset or None)


class RawLog:
    """Keeps the bridge volts of a run on the twin."""

    def __init__(self) -> None:
        self._rows: list[tuple[int, tuple[float, ...]]] = []

    def start(self, record: RunRecord, stamp_ns: int, at_once: bool = False) -> None:
        self._rows = []

    def add(self, cycle: Cycle) -> None:
        self._rows += [(i.wheel_counts, i.bridge_volts) for i in cycle.batch]

    def stop(self, status: str, notes: str) -> Path:
        return Path("raw")

    @property
    def turn(self) -> UnloadedTurns:
        """Raw samples of the recorded turns."""
        return turn_of([r[0] for r in self._rows], [r[1] for r in self._rows])


def turn_on_twin(setup: BenchSetup) -> UnloadedTurns:
    """Turn the unloaded wheel on the twin."""
    log = RawLog()
    TwinBench(Twin(setup), log).perform(plan_of(Measurement(measurement="unloaded_turn")))
    return log.turn


def speeds_on_twin(setup: BenchSetup, seconds: float = 3.0) -> MeasurementTable:
    """Turn the unloaded wheel on the twin at several constant speeds, each for `seconds` [s]."""
    twin = Twin(setup)
    twin.cycle()  # the drive takes no command before its first answer
    rows = []
    for speed in MOTOR_SPEEDS:
        for done in (
            twin.drive.set_operation_mode("velocity", speed / GEAR_RATIO),
            twin.drive.enable(),
        ):
            if not done.accepted:
                raise FlatplankError(done.reason, "wheel_drive", "unload the wheel")
        for _ in range(round(seconds * twin.rate_hz)):
            cycle = twin.cycle()
            axis = cycle.batch[-1].axes[0]
            rows.append(
                (1e-9 * cycle.encoders.stamp_ns, cycle.encoders.motor_velocity,
                 axis.torque * TORQUE_UNIT)
            )  # fmt: skip
    names = ("time", "motor_velocity", "motor_torque")
    columns = dict(zip(names, np.array(rows).T, strict=True))
    return MeasurementTable(columns, RunRecord(file="speeds", measurement="unloaded_turn"))


def filter_on_twin(
    setup: BenchSetup, fit: Path, kappa: float, last: float = 4.0
) -> dict[str, tuple[float, float]]:
    """Measure the once-per-turn amplitude of fx and fz [N] without and with the parasitic filter
    `fit`, in two runs under load at slip `kappa`; last: plank position at the end [m]."""
    columns = []
    for on in (False, True):
        hub = {"parasitic_fit": str(fit), "filter_on": on}
        own = replace(setup, parameters={**setup.parameters, "measurement_hub": hub})
        m = Measurement(kappa=kappa, step_position=0.3, end_position=last)
        with tempfile.TemporaryDirectory() as folder:
            bench = TwinBench(Twin(own), TableLog(Path(folder)))
            bench.perform(plan_of(m))
            columns.append(read_samples(bench.kept[0]).columns)
    return amplitudes_under_load(columns[0], columns[1], last - 2.4, last)
