# SPDX-License-Identifier: Apache-2.0
"""Computes gains of the free-rolling controller for a tire, from C_x or C_Fk and sigma."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import numpy as np

import control
from flatplank_control.free_rolling.design import Gains, Machine, design_gains
from flatplank_control.free_rolling.params import THESIS_LEAD_ALPHA, FreeRollingParameters
from flatplank_data.arguments import Parser
from flatplank_data.yaml_text import dump_yaml


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
    """Plot magnitude and phase of the loops, and their closed-loop step responses."""
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


THESIS = Gains(5.0e-3, 5.0e-4, 0.1105, THESIS_LEAD_ALPHA)


def parser() -> argparse.ArgumentParser:
    p = Parser(prog="flatplank tune", description=__doc__)
    how = p.add_mutually_exclusive_group(required=True)
    how.add_argument("--cx", type=float, help="tire stiffness C_x = C_Fk / sigma [N/mm]")
    how.add_argument("--cfk", type=float, help="slip stiffness C_Fk [kN]")
    p.add_argument("--sigma", type=float, default=0.45, help="relaxation length [m]")
    p.add_argument("--rate", type=float, default=250.0, help="bus rate [Hz]")
    p.add_argument("--delay-cycles", type=float, default=2.0, help="sample to effect")
    p.add_argument("--figure", type=Path, help="Bode and step figure, for instance tune.png")
    p.add_argument("--out", type=Path, help="parameter file for the controller")
    return p


def main(argv: list[str]) -> int:
    """Exit code 0: the phase margin is at least 30 deg; 1: it is not."""
    o = parser().parse_args(argv)
    for name in ("cx", "cfk", "sigma", "rate", "delay_cycles"):
        value = getattr(o, name)
        if value is not None and not 0.0 < value < math.inf:
            raise ValueError(f"--{name.replace('_', '-')} is {value:g}, must be above 0")
    stiffness = o.cx * 1e3 if o.cx is not None else o.cfk * 1e3 / o.sigma
    delay = (o.delay_cycles + 0.5) / o.rate
    gains = design_gains(stiffness, o.sigma, delay)
    loops = {
        name: loop_of(g, stiffness, o.sigma, delay) for name, g in
        {"tuned": gains, "thesis": THESIS}.items()
    }  # fmt: skip
    print(f"C_x {stiffness / 1e3:.0f} N/mm, sigma {o.sigma:g} m, delay {1e3 * delay:.1f} ms")
    found = {}
    for name, loop in loops.items():
        found[name], omega, gain = margins(loop)
        print(
            f"{name:7} phase margin {found[name]:6.1f} deg at {omega / 6.2832:.2f} Hz, "
            f"gain margin {gain:.2f}"
        )
    values = {
        "rate_hz": o.rate,
        "proportional_gain": float(f"{gains.proportional:.4g}"),
        "integral_gain": float(f"{gains.integral:.4g}"),
        "lead_time": float(f"{gains.lead_time:.4g}"),
        "lead_alpha": float(f"{gains.lead_alpha:.4g}"),
    }
    FreeRollingParameters(**values)
    text = dump_yaml({"/**": {"ros__parameters": values}})
    print(text, end="")
    if o.out:
        o.out.write_text(text, encoding="utf-8")
    if o.figure:
        draw(o.figure, loops)
    return 0 if found["tuned"] >= 30.0 else 1
