# SPDX-License-Identifier: Apache-2.0
"""The nonlinear simulation of thesis 5.5: equations (5.15)-(5.21) with the controller in a
continuous loop.

It reproduces the check of the controller in the thesis, independent of the simulated bench: linear
transient tire, one gap, constant efficiency, no delay. Its settling distance follows from the
friction torque near 142 rad/s: 1.41 m with 1.13 N m (figure 5.14), and the measured 1.54 m with
0.75 N m (figure 5.18), whatever the table is at other speeds.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from flatplank_control.free_rolling.params import THESIS_LEAD_ALPHA, FreeRollingParameters
from flatplank_data.machine import FRICTION_SPEED, FRICTION_TORQUE
from flatplank_validation.free_rolling.linear import Actuator

Table = tuple[tuple[float, float], ...]

FREE_ROLLING = 142.0
"""motor speed of free rolling [rad/s]"""
FIGURE_5_11 = 1.13
"""friction torque of the first simulation at FREE_ROLLING, before it was scaled to the measured
one [N m]"""


def friction_table(at_free_rolling: float | None = None) -> Table:
    """M_F over motor speed [rad/s, N m] of the machine, or scaled to a value at FREE_ROLLING."""
    measured = float(np.interp(FREE_ROLLING, FRICTION_SPEED, FRICTION_TORQUE))
    scale = 1.0 if at_free_rolling is None else at_free_rolling / measured
    return tuple((v, scale * m) for v, m in zip(FRICTION_SPEED, FRICTION_TORQUE, strict=True))


@dataclass(frozen=True)
class Nonlinear:
    """Parameters of (5.15)-(5.21) beside Table 5.1."""

    actuator: Actuator = field(default_factory=Actuator)
    stiffness: float = 2000.0
    """k_eq [N m/rad]"""
    gap: float = math.radians(15.0)
    """alpha_BL, half of the gap at the motor [rad]"""
    damping: float = 0.05
    """d, small and artificial [N m s/rad]"""
    acceleration: float = 0.206
    """acceleration of the road [m/s^2]"""
    start: float = 0.1
    """start time of the road [s]"""
    friction: Table = field(default_factory=friction_table)


@dataclass(frozen=True)
class Run:
    """Results as arrays of shape (n,)."""

    time: NDArray[np.float64]
    """[s]"""
    position: NDArray[np.float64]
    """position of the road [m]"""
    force: NDArray[np.float64]
    """Fx [N]"""
    gear_angle: NDArray[np.float64]
    """theta_D [rad]"""
    torque: NDArray[np.float64]
    """M_M [N m]"""


def simulate(
    n: Nonlinear,
    p: FreeRollingParameters,
    alpha: float = THESIS_LEAD_ALPHA,
    distance: float = 4.2,
    step: float = 5e-4,
    keep: int = 20,
    speed: Callable[[float], float] | None = None,
) -> Run:
    """Simulate until the road has moved `distance` [m]; every `keep`-th step is kept.

    `speed`: road speed [m/s] over its position [m], for example as measured; by default constant.
    ValueError where the road would stand: it would never move `distance`.
    """
    a, friction = n.actuator, _table(n.friction)
    gear, lost = a.gear, a.efficiency * a.gear
    stiffness = a.slip_stiffness * a.vertical_force
    position = road = motor = wheel = angle = force = 0.0
    integral = lead = torque = 0.0
    smooth = step / (alpha * p.lead_time + step)
    rows = []
    k = 0
    while position < distance:
        t = k * step
        if t >= n.start:
            wanted = speed(position) if speed is not None else a.speed
            if not wanted > 0.0:
                raise ValueError(f"the road stands at {position:.3f} m: its speed is {wanted:g}")
            road = min(road + n.acceleration * step, wanted)
            position += road * step
            error = p.reference - force
            integral += p.integral_gain * error * step
            pi = p.proportional_gain * error + integral
            # lead (5.11): y = x / alpha - (1 / alpha - 1) times x filtered with the pole
            lead += smooth * (pi - lead)
            torque = lead + (pi - lead) / alpha + p.start_torque
        dry = friction(abs(motor))
        held = math.copysign(dry, motor) if motor else min(max(torque, -dry), dry)
        push = (torque - held) / a.j_m
        pull = a.loaded_radius * force / a.j_tw
        coupling = _coupling(n, motor - gear * wheel, angle, push + gear * pull, step)
        before, motor = motor, motor + (push - coupling / a.j_m) * step
        if motor * before < 0.0:
            motor = 0.0  # dry friction does not turn the motion round
        wheel += (lost * coupling / a.j_tw - pull) * step
        angle += (motor - gear * wheel) * step
        # (5.7) over time: sigma dF/dt + |V| F = C (r_e omega - V)
        slip_speed = a.effective_radius * wheel - road
        force += (stiffness * slip_speed - road * force) / a.relaxation_length * step
        if k % keep == 0:
            rows.append((t, position, force, angle, torque))
        k += 1
    return Run(*np.array(rows).T)


def _coupling(n: Nonlinear, speed: float, angle: float, push: float, h: float) -> float:
    """M_RED of (5.16, 5.19) at the end of a step of h [s], backward Euler in theta_D.

    The wheel seen from the motor is so light that the engaged gears swing at 10 krad/s.
    """
    a = n.actuator
    give = 1.0 / a.j_m + a.gear**2 * a.efficiency / a.j_tw
    free = (speed + h * push) / (1.0 + h * give * n.damping)
    after = angle + h * free
    if abs(after) <= n.gap:
        return n.damping * free
    beyond = angle - math.copysign(n.gap, after)
    k, d = n.stiffness, n.damping
    new = (speed + h * (push - give * k * beyond)) / (1.0 + h * give * (d + k * h))
    return k * (beyond + h * new) + d * new


def settling_distance(
    position: NDArray[np.float64],
    force: NDArray[np.float64],
    reference: float = 50.0,
    band: float = 0.05,
    start: float = 0.1,
) -> float:
    """Appendix E: fit p1 exp(-p2 x) + p3 from `start` [m] on; returns the distance after which it
    stays within the band [m].

    NaN when it does not reach the band on the measured road.
    """
    keep = position >= start
    x, y = position[keep], force[keep]

    def fit(rate: float) -> tuple[float, float, float]:
        decay = np.exp(-rate * x)
        basis = np.column_stack([decay, np.ones_like(x)])
        (p1, p3), *_ = np.linalg.lstsq(basis, y, rcond=None)
        return float(np.sum((p1 * decay + p3 - y) ** 2)), float(p1), float(p3)

    rate = _best(lambda r: fit(r)[0])
    _, p1, p3 = fit(rate)
    grid = np.linspace(0.0, float(x[-1]), 20_001)
    outside = np.flatnonzero(np.abs(p1 * np.exp(-rate * grid) + p3 - reference) > band * reference)
    if not outside.size:
        return 0.0
    last = int(outside[-1]) + 1
    return float(grid[last]) if last < grid.size else math.nan


def _best(cost: Callable[[float], float]) -> float:
    """Rate [1/m] with the smallest cost, by a grid search with successive refinement."""
    rates = np.geomspace(0.05, 100.0, 60)
    for _ in range(6):
        k = int(np.argmin([cost(r) for r in rates]))
        rates = np.linspace(rates[max(k - 1, 0)], rates[min(k + 1, rates.size - 1)], 15)
    return float(rates[7])


def _table(points: Table) -> Callable[[float], float]:
    """Linear interpolation for floats, constant beyond the end."""

    def value(v: float) -> float:
        for (x0, y0), (x1, y1) in pairwise(points):
            if v < x1:
                return y0 + (v - x0) / (x1 - x0) * (y1 - y0)
        return points[-1][1]

    return value
