# SPDX-License-Identifier: Apache-2.0
"""Sweeps of a discrete brush on a belt, with rubber whose friction depends on its temperature.

Shares no code with the tire models and with the search. Bristles of the contact stick until the
friction of their own pressure is spent (parabolic pressure; Pacejka, Tire and Vehicle Dynamics,
2012, section 3.2); sliding heats the tread, which cools to the air and to the belt. SAE numbers of
a file: degrees, newtons, kilopascals, kilometres per hour; axes ISO W.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

BASE = Path(__file__).with_name("brush.tir")
"""tire file that `sweeps --fit` made of sweeps of this brush with nothing hidden, noise 0.5 N"""
BRISTLES = 60
AIR = 25.0
"""temperature of the air [deg C]"""
RATE = 50.0
"""samples per second"""


@dataclass(frozen=True)
class Brush:
    """The tire, the bench, and what is hidden in them; each hidden size is zero in a null."""

    friction: float = 1.15
    """at the nominal load and at the best temperature [-]"""
    by_load: float = 0.12
    """fall of friction with load over the nominal load [-]"""
    best: float = 45.0
    """tread temperature at the best friction [deg C]"""
    half_length: float = 0.055
    """of the contact at the nominal load [m]"""
    longer: float = 0.5
    """exponent of its length over the load [-]"""
    fuller: float = 1.0
    """exponent of the parabola of the pressure over the length: less is flatter [-]"""
    bristle: float = 1.6e7
    """side stiffness of the bristles per length [N/m2]"""
    nominal: float = 3000.0
    """load [N]"""
    over_temperature: float = 0.0
    """fall of friction per kelvin above the temperature of the air [1/K]"""
    over_pressure: float = 0.0
    """change of friction with pressure over 200 kPa [-]"""
    over_distance: float = 0.0
    """fall of friction per kilometre [1/km]"""
    crosstalk: float = 0.0
    """share of the load in the shown side force, beyond the nominal load [-]"""
    turned: float = 0.0
    """shown slip angle less the true one [deg]"""
    zero_by_temperature: float = 0.0
    """offset of the shown side force per kelvin above the temperature of the air [N/K]"""
    pull_by_pressure: float = 0.0
    """offset of the shown side force per 20 kPa above 200 kPa [N]"""
    late: float = 0.0
    """share by which the shown side force is larger in the second half of the series [-]"""
    angle_by_distance: float = 0.0
    """growth of the true slip angle less the shown one per kilometre [deg/km]"""
    noise: float = 10.0
    """standard deviation of the shown side force [N]"""
    moment_noise: float = 0.3
    """standard deviation of the shown aligning moment [Nm]"""


@dataclass(frozen=True)
class Plan:
    """Levels of a series; every condition is visited `visits` times, in another order each."""

    loads: tuple[float, ...] = (1500.0, 3000.0, 4500.0)
    pressures: tuple[float, ...] = (180.0, 220.0)
    visits: int = 2
    most: float = 12.0
    """slip angle [deg]"""
    seconds: float = 12.0
    """of one sweep, up and down"""
    speed: float = 40.0
    """[km/h]"""


def sweeps(brush: Brush, plan: Plan, seed: int) -> dict[str, np.ndarray]:
    """Columns of a file: ET [s], V [km/h], SA, IA [deg], FZ, FY [N], MZ [Nm], P [kPa],
    TSTC [deg C]."""
    random = np.random.default_rng(seed)
    levels = [(fz, p) for fz in plan.loads for p in plan.pressures]
    order = np.concatenate([random.permutation(len(levels)) for _ in range(plan.visits)])
    one = _triangle(plan)
    alpha = np.tile(one, len(order))
    fz = np.repeat([levels[k][0] for k in order], len(one))
    pressure = np.repeat([levels[k][1] for k in order], len(one))
    time = np.arange(len(alpha)) / RATE
    fz = fz * (1.0 + 0.004 * random.standard_normal(len(fz)))
    way = time * plan.speed / 3.6
    true = np.radians(alpha + brush.angle_by_distance * 1e-3 * way)
    fy, mz, warm = _roll(brush, true, fz, pressure, plan.speed / 3.6)
    shown = fy + brush.crosstalk * (fz - brush.nominal)
    shown = shown * (1.0 + brush.late * (time > 0.5 * time[-1]))
    shown = shown + brush.zero_by_temperature * (warm - AIR)
    shown = shown + brush.pull_by_pressure * (pressure - 200.0) / 20.0
    shown = shown + brush.noise * random.standard_normal(len(fy))
    moment = mz + brush.moment_noise * random.standard_normal(len(mz))
    return {
        "ET": time, "V": np.full(len(time), plan.speed), "SA": alpha + brush.turned,
        "IA": np.zeros(len(time)), "FZ": fz, "FY": shown, "MZ": moment, "P": pressure,
        "TSTC": warm,
    }  # fmt: skip


def text_of(columns: Mapping[str, np.ndarray]) -> str:
    """The columns as a text file with a line of names and a line of units."""
    units = {
        "ET": "s",
        "V": "km/h",
        "SA": "deg",
        "IA": "deg",
        "MZ": "Nm",
        "P": "kPa",
        "TSTC": "deg C",
    }
    head = [",".join(columns), ",".join(units.get(name, "N") for name in columns)]
    rows = np.column_stack(list(columns.values()))
    return "\n".join([*head, *(",".join(f"{v:.6g}" for v in row) for row in rows), ""])


def _triangle(plan: Plan) -> np.ndarray:
    """0, up, down through zero, and back to 0."""
    share = np.arange(int(plan.seconds * RATE)) / (plan.seconds * RATE)
    return plan.most * np.interp(share, [0.0, 0.25, 0.75, 1.0], [0.0, 1.0, -1.0, 0.0])


def _roll(
    brush: Brush, alpha, fz, pressure, speed: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Side force [N], its moment about the middle of the contact [Nm] and tread temperature
    [deg C], sample by sample."""
    place = (np.arange(BRISTLES) + 0.5) / BRISTLES
    shape = (place * (1.0 - place)) ** brush.fuller
    shape /= shape.mean()  # pressure over the length, mean 1
    capacity, cooling = 900.0, 60.0  # J/K, W/K
    warm, way = AIR, 0.0
    fy, mz, temperature = np.empty((3, len(alpha)))
    for k, (angle, load, bar) in enumerate(zip(alpha, fz, pressure, strict=True)):
        mu = brush.friction * (1.0 - brush.by_load * (load / brush.nominal - 1.0))
        mu *= 1.0 - brush.over_temperature * (warm - AIR)
        mu *= 1.0 + brush.over_pressure * (bar / 200.0 - 1.0)
        mu *= 1.0 - brush.over_distance * 1e-3 * way
        length = 2.0 * brush.half_length * (load / brush.nominal) ** brush.longer
        stuck = brush.bristle * np.tan(angle) * place * length * (length / BRISTLES)
        most = mu * load * shape / BRISTLES
        each = -np.clip(stuck, -most, most)
        fy[k], mz[k] = each.sum(), each @ (length * (0.5 - place))
        temperature[k] = warm
        heat = abs(fy[k] * speed * np.sin(angle)) * 0.5
        warm += (heat - cooling * (warm - AIR)) / capacity / RATE
        way += speed / RATE
    return fy, mz, temperature
