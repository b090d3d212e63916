# SPDX-License-Identifier: Apache-2.0
"""Simulates thousands of runs with the same kernels for road, tire and bridges, without bus and
drive loop."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

from flatplank_sim.plant.bridges import past_of_bridges
from flatplank_sim.plant.config import PlantConfig
from flatplank_sim.plant.records import build_records, initial_state
from flatplank_sim.plant.rolling import roll
from flatplank_sim.plant.scatter import draw_run, scatters

COLUMNS = [
    "time", "plank_position", "plank_velocity", "wheel_angle", "wheel_velocity",
    "motor_velocity", "motor_torque", "fx", "fy", "fz", "mx", "my", "mz", "loaded_radius",
    "motion_trigger",
]  # fmt: skip
"""columns of the measurement table"""
TRUTHS = ("fx_true", "road_position")
"""further columns: true fx and true road position"""
BUS_RATE = 250.0


@dataclass(frozen=True)
class CampaignRun:
    """One run: slip step at a plank position, or any slip over position."""

    kappa: float = 0.0
    """slip after the step [-]"""
    fz: float = 3700.0
    """nominal load at standstill [N]; the axle height is set for it"""
    pressure: float = 0.0
    """[bar]; 0: the tire's nominal pressure"""
    alpha: float = 0.0
    """steering angle [rad]"""
    gamma: float = 0.0
    """camber of the hub [rad]"""
    start_angle: float = 0.0
    """wheel angle at the start [rad]"""
    run_index: int = 0
    effective_rolling_radius: float = 0.0
    """radius of the slip control [m]; 0: the true one at this load"""
    step_position: float = 1.5
    """plank position of the slip step, since the trigger [m]"""
    length: float = 4.15
    """plank travel for which the table has rows; the run ends with the road at the latest [m]"""
    start_delay: float = 0.08
    """delay of the wheel after the plank's switch [s]: encoder, detection, two cycles, servo"""
    profile: tuple[tuple[float, float], ...] = field(default=())
    """(position [m], slip) instead of the step"""
    free: bool = False
    """true: flexplates disconnected"""
    fast: bool = True
    """false: the slow speed of the plank"""


class Campaign:
    """Campaign on one configuration of the simulated bench; `simulate` yields a table per run."""

    def __init__(
        self, config: PlantConfig, rate_hz: float = 62.5, tire_step: float = 0.008
    ) -> None:
        self.config = config
        self.dt = 1.0 / rate_hz
        self.steps = max(round(self.dt / tire_step), 1)
        self.records = build_records(config, self.dt)
        # white noise with the same spectral density as at the bus rate
        share = np.sqrt(min(rate_hz / BUS_RATE, 1.0))
        for name in ("noise_bridge", "noise_lvdt", "noise_torque"):
            self.records.machine[name] *= share
        if rate_hz < BUS_RATE:
            self.records.machine["hum"] = 0.0

    def simulate(
        self, runs: Iterable[CampaignRun], seed: int = 0
    ) -> Iterator[dict[str, np.ndarray]]:
        """Measurement table of each run as columns [SI], with `fx_true` and `road_position`."""
        for number, run in enumerate(runs):
            yield self.run(run, np.random.default_rng((seed, number)))

    def run(self, run: CampaignRun, random: np.random.Generator) -> dict[str, np.ndarray]:
        """Simulate one run from standstill under load."""
        r, c = self.records, self.config
        m = r.machine
        state = initial_state(c, r)
        s, op = state["state"], state["operator"]
        pressure = run.pressure or c.tire.nominal_pressure_bar
        s["pressure"] = op["pressure"] = pressure
        stiffness = c.tire.vertical_stiffness * (
            (pressure / c.tire.nominal_pressure_bar) ** c.tire.vertical_stiffness_pressure
        )
        s["height"] = op["height"] = c.tire.free_radius - run.fz / stiffness
        s["steer"] = run.alpha
        s["alpha"] = run.alpha + m["steer_error"]
        s["gamma"] = s["wheel_camber"] = run.gamma
        s["theta"], s["run"] = run.start_angle, run.run_index
        s["joined"] = 0.0 if run.free else 1.0
        op["direction"], op["fast"] = 1, int(run.fast)
        radius = run.effective_rolling_radius or self.true_radius(run.fz, stiffness)
        profile = np.array(run.profile or self._step(run), float)
        speed = c.plank.fast_speed if run.fast else c.plank.slow_speed
        rows = int((run.length + 0.1) / speed / self.dt)
        out = np.empty((rows, len(COLUMNS) + len(TRUTHS)))
        noise = random.standard_normal((rows, 8))
        history = past_of_bridges(float(m["skew"][0]), self.dt)
        if scatters(r):
            draw_run(r, s, random)
        delay = run.start_delay + float(r.drives["start_delay"][0])
        n = roll(
            m, s, r.tire, state["tire_state"], state["bristles"], op, r.curve, r.road_map, r.mix,
            r.drift, history, np.zeros(17), noise, profile, radius, delay, self.steps, out,
        )  # fmt: skip
        if self.records.machine["noise_torque"][0] > 0.0:
            out[:n, 6] += m["noise_torque"] * random.standard_normal(n)
        return dict(zip((*COLUMNS, *TRUTHS), out[:n].T.copy(), strict=True))

    @staticmethod
    def _step(run: CampaignRun) -> tuple[tuple[float, float], ...]:
        x = run.step_position
        return ((x, 0.0), (x, run.kappa)) if run.kappa else ((0.0, 0.0), (1.0, 0.0))

    def true_radius(self, fz: float, stiffness: float) -> float:
        """Effective rolling radius of the plant's tire at a load [m]."""
        t = self.config.tire
        rho = fz / stiffness
        return t.free_radius - t.rolling_radius_drop * rho / (
            rho + t.rolling_radius_half_deflection
        )
