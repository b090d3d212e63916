# SPDX-License-Identifier: Apache-2.0
"""The free-rolling loop for the library `control`: transfer functions, margins, figures of H and
S, settling, pictures."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

import control
from flatplank_control.free_rolling.design import Gains, Machine

SETTLED = 0.005
"""band of the settling time of the thesis, 32.7 s [-]"""
LONGEST = 120.0
"""longest step response [s]"""


class Loop(NamedTuple):
    """Figures of a loop. Margins are those at the last crossover."""

    phase_margin: float
    """[deg]"""
    crossover: float
    """[Hz]"""
    gain_margin: float
    """[-]"""
    bandwidth: float
    """-3 dB of H [Hz]"""
    peak: float
    """peak of H [dB]"""
    peak_at: float
    """[Hz]"""
    dip_at: float
    """smallest S left of the crossover [Hz]"""


def plant_of(
    stiffness: float, relaxation: float, machine: Machine | None = None
) -> control.TransferFunction:
    """P(s) = Fx / M_M of (5.9c) [N / (N m)] for C_x [N/m] and sigma [m]."""
    m = machine or Machine()
    turn = stiffness * m.effective_radius
    return control.tf(
        [m.gear * m.efficiency * turn],
        [m.inertia, m.inertia * m.speed / relaxation, turn * m.loaded_radius],
    )


def controller_of(gains: Gains) -> control.TransferFunction:
    """C(s) of (5.12) [N m / N]."""
    pi = control.tf([gains.proportional, gains.integral], [1.0, 0.0])
    lead = control.tf([gains.lead_time, 1.0], [gains.lead_alpha * gains.lead_time, 1.0])
    return pi * lead


def loop_of(
    gains: Gains, stiffness: float, relaxation: float, delay: float
) -> control.TransferFunction:
    """C(s) P(s) with the delay [s] as a Pade approximation of order 5."""
    loop = controller_of(gains) * plant_of(stiffness, relaxation)
    return loop * control.tf(*control.pade(delay, 5)) if delay > 0.0 else loop


def margins(loop: control.LTI) -> tuple[float, float, float]:
    """Phase margin [deg] and crossover [rad/s] of the last crossover, gain margin [-]."""
    # the crossovers of a discrete loop lie on the unit circle, where polynomials lose digits
    if loop.dt:
        omega = np.geomspace(0.1, 0.99 * np.pi / loop.dt, 4000)
        loop = control.frd(loop(np.exp(1j * omega * loop.dt)), omega, smooth=True)
    gains, phases, _, _, crossovers, _ = control.stability_margins(loop, returnall=True)
    last = int(np.argmax(crossovers))
    rising = [g for g in gains if g > 1.0]
    return float(phases[last]), float(crossovers[last]), float(min(rising, default=math.inf))


def phase_margin(gains: Gains, stiffness: float, relaxation: float, delay: float) -> float:
    """Smallest phase margin over all crossovers [deg]; the delay [s] includes the hold."""
    omega = np.geomspace(0.01, 1000.0, 4000)
    machine = Machine()
    s = 1j * omega
    response = controller_of(gains)(s) * np.exp(-s * delay)
    response *= [machine.response(w, stiffness, relaxation) for w in omega]
    frequency = control.frd(response, omega, smooth=True)
    return float(min(control.stability_margins(frequency, returnall=True)[1]))


def figures(loop: control.TransferFunction) -> Loop:
    """Margins, bandwidth, peak of H and dip of S."""
    phase, crossover, gain = margins(loop)
    top = 0.999 * np.pi / loop.dt if loop.dt else 1e3
    omega = np.geomspace(0.01, top, 20_001)
    h, s = control.feedback(loop, 1), control.feedback(1, loop)
    closed, open_ = (control.frequency_response(x, omega).magnitude for x in (h, s))
    peak = int(np.argmax(closed))
    # S falls again towards zero frequency: the dip is the local minimum next to the crossover
    low = np.flatnonzero((open_[1:-1] < open_[:-2]) & (open_[1:-1] < open_[2:])) + 1
    dips = low[omega[low] < crossover]
    turn = 2.0 * np.pi
    return Loop(
        phase_margin=phase,
        crossover=crossover / turn,
        gain_margin=gain,
        bandwidth=float(omega[np.flatnonzero(closed > control.db2mag(-3.0))[-1]]) / turn,
        peak=float(control.mag2db(closed[peak])),
        peak_at=float(omega[peak]) / turn,
        dip_at=float(omega[dips[-1]]) / turn if dips.size else math.nan,
    )


def settling_time(loop: control.TransferFunction, band: float = SETTLED) -> float:
    """Time after which the step response of H stays within `band` of its final value [s]."""
    t = np.arange(0.0, LONGEST, 0.002)
    info = control.step_info(control.feedback(loop, 1), T=t, SettlingTimeThreshold=band)
    return float(info["SettlingTime"])


def draw(path: Path, loops: Mapping[str, control.TransferFunction]) -> None:
    """Plot loop, step response to the end of its settling, and poles and zeros of H."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 12.0), layout="constrained")
    size, phase, step, poles = figure.subplots(4, 1)
    omega = np.geomspace(0.1, 300.0, 2000)
    for name, loop in loops.items():
        response = control.frequency_response(loop, omega)
        size.loglog(omega / (2.0 * np.pi), response.magnitude, label=name)
        degrees = np.degrees(np.unwrap(response.phase))
        phase.semilogx(omega / (2.0 * np.pi), degrees)
        closed = control.feedback(loop, 1)
        if np.all(closed.poles().real < 0.0):
            end = settling_time(loop)
            t, y = control.step_response(closed, np.arange(0.0, 1.1 * end, 0.005))
            (line,) = step.plot(t, y, label=name)
            step.axvline(end, color=line.get_color(), linestyle=":")
        for points, mark in ((closed.poles(), "x"), (closed.zeros(), "o")):
            near = points[np.abs(points) < 200.0]
            poles.plot(near.real, near.imag, mark, fillstyle="none", label=f"{name} {mark}")
    size.axhline(1.0, color="0.7")
    phase.axhline(-180.0, color="0.7")
    size.set(xlabel="frequency [Hz]", ylabel="|L|")
    phase.set(xlabel="frequency [Hz]", ylabel="phase of L [deg]")
    step.set(xlabel="time [s], dotted: settled to 0.5 %", ylabel="Fx over its reference")
    poles.set(xlabel="poles (x) and zeros (o) of H, real part [rad/s]", ylabel="imaginary [rad/s]")
    size.legend()
    step.legend()
    figure.savefig(path)
