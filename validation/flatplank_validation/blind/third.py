# SPDX-License-Identifier: Apache-2.0
"""Campaigns of the third tire: true parameters of tire and machine, and the sensors.

It shares no formula with the simulated plant, the second tire and the models of the analysis.
third_kernel.py has the rubber, third_bench.py the machine.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from flatplank_sim.sealed.conditions import LOAD, STEP, Run, Setting
from flatplank_validation.blind import plan, third_bench, third_kernel

Columns = dict[str, np.ndarray]
RADIUS, LENGTH = 0.3121, 4.13
SAMPLES = 2780
COUNTS = 2.0 * math.pi / 32768.0
"""resolution of the wheel encoder [rad]; that of the plank has the same at its pinion"""
PINION = 0.05
DESIGNS: Mapping[str, tuple[Setting, ...]] = {
    **{name: plan.DESIGNS[name] for name in ("plain", "combined", "wide_loads")},
    "angles": tuple(Setting(k, alpha_deg=a) for a in (0.0, 2.0, 5.0) for k in plan.COARSE[::2]),
}
"""design -> conditions of a campaign; loads from 0.5 to 1.5 of the usual one"""


@dataclass(frozen=True)
class ThirdTire:
    """True parameters of the tire."""

    vertical: float = 2.1e5
    """vertical stiffness [N/m]"""
    radius: float = 0.33
    """unloaded radius [m]"""
    share: float = 0.66
    """part of the chord in contact [-]"""
    grip_x: float = 1.08
    grip_y: float = 1.03
    thin: float = 0.08
    """loss of grip per e-fold of the mean pressure"""
    width: float = 0.09
    """half width of the contact [m]"""
    thread_x: float = 9.3e6
    """stiffness per length of contact [N/m2]"""
    thread_y: float = 6.6e6
    forward: float = 0.12
    """asymmetry of the pressure towards the front [-]"""
    lost: float = 0.05
    """loss of grip of a sliding foot [-]"""
    slow: float = 2e-3
    """sliding speed at which most of it is lost [m/s]"""
    piece: float = 2.4e-3
    """distance between threads on the belt [m]"""
    carcass_x: float = 2.4e5
    carcass_y: float = 1.25e5
    damper_x: float = 2.5e3
    """damping of the carcass [N s/m]"""
    damper_y: float = 2.0e3
    rolling: float = 8e-3
    """rolling resistance per load"""
    offset: float = -5e-4
    """slip offset of the rolling radius"""

    def drawn(self, random: np.random.Generator) -> ThirdTire:
        """A random tire of the same kind."""
        names = ("share", "grip_x", "grip_y", "thread_x", "thread_y", "carcass_x", "carcass_y")
        change = {n: getattr(self, n) * random.uniform(0.94, 1.06) for n in names}
        return replace(
            self,
            **change,
            forward=random.uniform(0.0, 0.25),
            lost=random.uniform(0.0, 0.08),
            rolling=random.uniform(5e-3, 0.012),
            offset=random.uniform(-1.2e-3, 0.0),
        )

    def numbers(self, load: float, gain: float, stiffer: float) -> np.ndarray:
        """Parameters of one run for the kernel."""
        out = np.array([getattr(self, n) for n in third_kernel.NAMES])
        for name in ("thread_x", "thread_y"):
            out[third_kernel.AT[name]] *= gain
        for name in ("carcass_x", "carcass_y"):
            out[third_kernel.AT[name]] *= (load / LOAD) ** stiffer
        return out


@dataclass(frozen=True)
class ThirdMachine:
    """Faults of the machine, and one property of the tire (`carcass_load`)."""

    road_play: float = 0.0
    """[m]"""
    road_rest: float = 0.0
    """position in the play at the start of a run, -1 to 1"""
    steering_play: float = 0.0
    """half of the play [rad]"""
    loss: float = 0.0
    """loss of load per braking force"""
    patch: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """(from [m], to [m], loss of grip)"""
    parasitic: tuple[float, float] = (0.0, 0.0)
    """once-per-turn force in Fx and Fz [N]"""
    carcass_load: float = 0.0
    """exponent of the carcass stiffness over load"""


def measure(
    tire: ThirdTire, machine: ThirdMachine, run: Run, gain: float, delay: float, bumps: np.ndarray
) -> Columns:
    """Make one run without sensor noise.

    gain: factor of grip and thread stiffness; delay: of the wheel at the start [s]; bumps: load
    undulation over the plank, two pairs of size [N] and phase.
    """
    s = run.setting
    start = math.radians(120.0 * (run.start - 1))
    low, high, depth = machine.patch
    values = {
        "load": s.fz, "alpha": math.radians(s.alpha_deg), "kappa": s.kappa,
        "radius": RADIUS / (1.0 + tire.offset), "start": start, "delay": delay,
        "speed": 0.0309, "step_at": STEP, "length": LENGTH, "road_play": machine.road_play,
        "road_rest": machine.road_rest, "steering_play": machine.steering_play, "trail": 0.03,
        "loss": machine.loss, "loss_time": 0.2, "patch_from": low, "patch_to": high,
        "patch_depth": depth, "patch_edge": 0.015, "grip": gain,
    }  # fmt: skip
    out = np.zeros((len(third_bench.OUT), SAMPLES))
    numbers = np.array([values[n] for n in third_bench.NAMES])
    rubber = tire.numbers(s.fz, gain, machine.carcass_load)
    count = third_bench.run_one(numbers, rubber, bumps, out)
    plank, wheel, fx, fy, load = out[:, :count]
    return _shown(tire, machine, plank, wheel, start, fx, fy, load)


def _shown(tire, machine, plank, wheel, start, fx, fy, load) -> Columns:
    turn = wheel + start
    shaft_x, shaft_z = machine.parasitic
    rolls = 1.0 - np.exp(-plank / 0.004)
    return {
        "time": third_bench.SAMPLE * (1.0 + np.arange(len(plank))),
        "plank_position": PINION * COUNTS * np.round(plank / (PINION * COUNTS)),
        "wheel_angle": COUNTS * np.round(wheel / COUNTS),
        "fx": fx - tire.rolling * load * rolls + shaft_x * np.sin(turn + 0.8),
        "fy": fy.copy(),
        "fz": load + shaft_z * np.sin(turn - 0.5),
        "mx": 0.04 * fy + 5.0 * np.cos(plank / 0.21),
        "mz": -0.03 * fy + 0.003 * fx + 3.0 * np.sin(plank / 0.27),
    }
