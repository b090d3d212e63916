# SPDX-License-Identifier: Apache-2.0
"""Bode and step figures of a tuned loop beside the thesis's, with python-control."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import control
from flatplank_control.free_rolling.design import Gains, Machine


def loop_of(
    gains: Gains, stiffness: float, relaxation: float, delay: float
) -> control.TransferFunction:
    """C(s) P(s) with the delay [s] as a Pade approximation of order 5."""
    m = Machine()
    turn = stiffness * m.effective_radius
    plant = control.tf(
        [m.gear * m.efficiency * turn],
        [m.inertia, m.inertia * m.speed / relaxation, turn * m.loaded_radius],
    )
    pi = control.tf([gains.proportional, gains.integral], [1.0, 0.0])
    lead = control.tf([gains.lead_time, 1.0], [gains.lead_alpha * gains.lead_time, 1.0])
    late = control.tf(*control.pade(delay, 5)) if delay > 0.0 else control.tf([1.0], [1.0])
    return pi * lead * plant * late


def margins(loop: control.TransferFunction) -> tuple[float, float, float]:
    """Phase margin [deg] and crossover [rad/s] of the last crossover, gain margin [-]."""
    gain, _phase, _s, _wpc, _wgc, _ws = control.stability_margins(loop, returnall=False)
    omega = np.geomspace(0.5, 300.0, 20_000)
    response = loop(1j * omega)
    above = np.flatnonzero(np.abs(response) > 1.0)
    last = int(above[-1]) if above.size else 0
    angle = np.degrees(np.unwrap(np.angle(response)))[last]
    return float((angle + 360.0) % 360.0 - 180.0), float(omega[last]), float(gain)


def draw(path: Path, loops: dict[str, control.TransferFunction]) -> None:
    """Magnitude and phase of the loops, and their closed-loop steps."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 9.0), layout="constrained")
    size, phase, step = figure.subplots(3, 1)
    omega = np.geomspace(0.1, 300.0, 2000)
    t = np.arange(0.0, 4.0, 0.002)
    for name, loop in loops.items():
        response = loop(1j * omega)
        size.loglog(omega / (2.0 * np.pi), np.abs(response), label=name)
        degrees = np.degrees(np.unwrap(np.angle(response)))
        phase.semilogx(omega / (2.0 * np.pi), degrees)
        closed = control.feedback(loop, 1)
        if np.all(closed.poles().real < 0.0):
            _, y = control.step_response(closed, t)
            step.plot(t, y, label=name)
    size.axhline(1.0, color="0.7")
    phase.axhline(-180.0, color="0.7")
    size.set(xlabel="frequency [Hz]", ylabel="|L|")
    phase.set(xlabel="frequency [Hz]", ylabel="phase of L [deg]")
    step.set(xlabel="time [s]", ylabel="Fx over its reference")
    size.legend()
    step.legend()
    figure.savefig(path)
