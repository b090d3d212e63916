# SPDX-License-Identifier: Apache-2.0
"""Campaigns of the second tire: true parameters of tire and machine, and the sensors."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.signal import lfilter

from flatplank_sim.sealed.conditions import LOAD, PRESSURE, STEP, Columns, Run
from flatplank_validation.blind.second_kernel import AT, NAMES, OUT, SAMPLE, run_one

RADIUS, ROAD_CELLS = 0.3108, 2150
SAMPLES = 2760
WHEEL_COUNT, PLANK_COUNT = 2.0 * math.pi / 20000, 2.0 * math.pi * 0.05 / 20000


@dataclass(frozen=True)
class SecondTire:
    """True parameters of the tire at 3700 N and 2.5 bar."""

    tread_x: float = 9.6e6
    """[N/m2]: slip stiffness 2 tread half^2"""
    tread_y: float = 6.4e6
    half: float = 0.0705
    grip: float = 1.07
    grip_lost: float = 0.06
    grip_speed: float = 2e-3
    carcass_x: float = 2.45e5
    carcass_y: float = 1.3e5
    rolling: float = 28.0
    """rolling resistance [N]"""
    offset: float = -6e-4
    """slip offset of the rolling radius [-]"""
    circle: float = 0.0
    """1: one friction limit for both directions, cell by cell"""
    lean: float = 1e-3
    """zero error of the steering that a protractor does not show [rad]"""

    def drawn(self, random: np.random.Generator) -> SecondTire:
        """A random tire of the same kind."""
        names = ("tread_x", "tread_y", "half", "grip", "carcass_x", "carcass_y")
        change = {n: getattr(self, n) * random.uniform(0.94, 1.06) for n in names}
        return replace(
            self,
            **change,
            rolling=random.uniform(15.0, 45.0),
            offset=random.uniform(-1.2e-3, 0.0),
            grip_lost=random.uniform(0.02, 0.10),
        )


@dataclass(frozen=True)
class SecondMachine:
    """Faults of the machine: parameters of the kernel by name, and faults of the sensors."""

    kernel: Mapping[str, float] = field(default_factory=dict)
    load_stiff: float = 0.0
    """relative change of the carcass stiffness per relative change of load"""
    pressure_stiff: float = 0.0
    wear: float = 0.0
    """grip lost from the first to the last run"""
    patches: Sequence[tuple[float, float, float]] = ()
    """(from [m], to [m], loss of grip)"""
    parasitic: tuple[float, float] = (0.0, 0.0)
    """parasitic force in Fx and Fz [N]"""
    uneven: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """non-uniformity in Fx while the tire rolls, orders 1 to 3 of the wheel angle [N]"""
    mix: Mapping[tuple[str, str], float] = field(default_factory=dict)
    """(source, target) -> crosstalk"""
    drift: float = 0.0
    """drift of Fx in every run [N/s]"""
    drift_runs: float = 0.0
    """change of Fx from the first to the last run [N]"""
    lag: float = 0.0
    skew: float = 0.0
    rolling_share: float = 0.0
    """rolling resistance per load, in addition to the constant"""
    cone: float = 0.0
    """lateral force per load"""
    camber_share: float = 0.0
    steer_zero: float | None = None
    """zero error of the steering [rad]; None: the tire's `lean`"""
    load_waves: float = 0.0
    """additional load undulation over the plank, which the hub measures [N]"""


def numbers_of(
    tire: SecondTire, machine: SecondMachine, run: Run, gain: float, delay: float
) -> np.ndarray:
    """Parameters of a run for the kernel, shape (len(NAMES),)."""
    s = run.setting
    load, over = s.fz / LOAD, s.pressure / PRESSURE - 1.0
    p = np.zeros(len(NAMES))

    def put(**values: float) -> None:
        for name, value in values.items():
            p[AT[name]] = value

    soft = (1.0 + machine.load_stiff * (load - 1.0)) * (1.0 + machine.pressure_stiff * over)
    put(
        tread_x=tire.tread_x * gain * math.sqrt(load),
        tread_y=tire.tread_y * gain * math.sqrt(load),
        half=tire.half * math.sqrt(load), grip=tire.grip * gain, grip_lost=tire.grip_lost,
        grip_speed=tire.grip_speed, carcass_x=tire.carcass_x * soft,
        carcass_y=tire.carcass_y * soft, nominal=s.fz, speed=0.03092,
        wheel_speed=0.0309 * (1.0 + tire.offset), delay=delay, step=STEP, kappa=s.kappa,
        circle=tire.circle, radius=RADIUS, start=math.radians(120.0 * (run.start - 1)),
        alpha=math.radians(s.alpha_deg)
        + (tire.lean if machine.steer_zero is None else machine.steer_zero),
        camber_slip=-machine.camber_share * math.sin(math.radians(s.gamma_deg)),
        ripple_period=0.05, wave_period=0.7, creep_time=8.0, play_hold=12.0,
    )  # fmt: skip
    put(**machine.kernel)
    return p


def measure(
    tire: SecondTire,
    machine: SecondMachine,
    run: Run,
    count: int,
    gain: float,
    delay: float,
    bumps: np.ndarray,
) -> Columns:
    """Make one run without noise; the campaign has `count` runs."""
    share = run.index / max(count - 1, 1)
    friction = np.full(ROAD_CELLS, 1.0 - machine.wear * share)
    x = np.arange(ROAD_CELLS) / 500.0
    reach = 2.0 * tire.half
    for start, end, loss in machine.patches:
        # the part of the contact patch that lies on it
        cover = np.clip(np.minimum(end, x + tire.half) - np.maximum(start, x - tire.half), 0, None)
        friction *= 1.0 - loss * np.minimum(cover / reach, 1.0)
    numbers = numbers_of(tire, machine, run, gain, delay)
    out = np.zeros((len(OUT), SAMPLES))
    waves = np.array([machine.load_waves, 0.0, 0.5 * machine.load_waves, 0.0])
    size = run_one(numbers, friction, bumps + waves, out)
    pinion, wheel, fx, fy, felt, shown = out[:, :size]
    columns = {
        "time": np.arange(size) * SAMPLE, "plank_position": pinion, "wheel_angle": wheel,
        "fx": fx.copy(), "fy": fy.copy(), "fz": shown.copy(), "felt": felt.copy(),
    }  # fmt: skip
    _sensors(columns, tire, machine, run, share)
    return columns


def _sensors(c: Columns, tire: SecondTire, machine: SecondMachine, run: Run, share: float) -> None:
    s = run.setting
    rolls = c["plank_position"] > 5e-4
    angle = c["wheel_angle"] + math.radians(120.0 * (run.start - 1))
    own_fx, own_fy = c["fx"].copy(), c["fy"].copy()
    c["fx"] -= (tire.rolling + machine.rolling_share * (s.fz - LOAD)) * rolls
    c["fy"] += machine.cone * c["felt"] * rolls
    for order, size in enumerate(machine.uneven, 1):
        c["fx"] += size * s.fz / LOAD * np.cos(order * angle - 0.3 * order) * rolls
    c["fx"] += machine.parasitic[0] * np.cos(angle - 1.1)
    c["fz"] += machine.parasitic[1] * np.cos(angle + 0.4)
    c["mx"] = 0.05 * own_fy + 6.0 * np.sin(c["plank_position"] / 0.25)
    c["mz"] = -0.02 * own_fy + 0.004 * own_fx + 4.0 * np.cos(c["plank_position"] / 0.31)
    true = {k: c[k].copy() for k in ("fx", "fy", "fz", "mx", "mz")}
    for (source, goal), amount in machine.mix.items():
        c[goal] = c[goal] + amount * true[source]
    c["fx"] += machine.drift * c["time"] + machine.drift_runs * (share - 0.5)
    c["fx"] = late(c["fx"], machine.lag)
    if machine.skew:
        for name in ("fx", "fy", "fz", "mx", "mz"):
            c[name] = np.interp(c["time"] - machine.skew, c["time"], c[name])


def late(values: np.ndarray, time: float) -> np.ndarray:
    """Values after a first-order lag `time` [s], exact for values linear between samples."""
    if time <= 0.0:
        return values
    keep, ratio = math.exp(-SAMPLE / time), SAMPLE / time
    middle = (1.0 - keep) / ratio
    steps = (middle - keep) * values[:-1] + (1.0 - middle) * values[1:]
    return np.append(values[0], lfilter([1.0], [1.0, -keep], steps, zi=[keep * values[0]])[0])


def counted(columns: Columns) -> Columns:
    """The columns with quantised encoders."""
    out = dict(columns)
    for name, step in (("plank_position", PLANK_COUNT), ("wheel_angle", WHEEL_COUNT)):
        out[name] = np.floor(columns[name] / step) * step
    return out
