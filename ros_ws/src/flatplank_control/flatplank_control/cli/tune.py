# SPDX-License-Identifier: Apache-2.0
"""Gains of the free-rolling controller for a tire.

From C_x, or from C_Fk and sigma.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

from flatplank_control.free_rolling.design import Gains, design_gains
from flatplank_control.free_rolling.loop import (
    draw,
    figures,
    loop_of,
    settling_time,
)
from flatplank_control.free_rolling.params import THESIS_LEAD_ALPHA, FreeRollingParameters
from flatplank_data.arguments import Parser, add_json, for_programs
from flatplank_data.yaml_text import dump_yaml

LEAST_MARGIN_DEG = 30.0
THESIS = Gains(5.0e-3, 5.0e-4, 0.1105, THESIS_LEAD_ALPHA)


def parser() -> argparse.ArgumentParser:
    p = Parser(prog="flatplank tune", description=__doc__)
    how = p.add_mutually_exclusive_group(required=True)
    how.add_argument("--cx", type=float, help="tire stiffness C_x = C_Fk / sigma [N/mm]")
    how.add_argument("--cfk", type=float, help="slip stiffness C_Fk [kN]")
    p.add_argument("--sigma", type=float, default=0.45, help="relaxation length [m]")
    p.add_argument("--rate", type=float, default=250.0, help="bus rate [Hz]")
    p.add_argument("--delay-cycles", type=float, default=2.0, help="to effect; 0: without hold")
    p.add_argument("--figure", type=Path, help="Bode and step figure, for instance tune.png")
    p.add_argument("--out", type=Path, help="parameter file for the controller")
    add_json(p)
    return p


def main(argv: list[str]) -> int:
    """Exit code 0: the phase margin is at least 30 deg; 1: it is not."""
    o = parser().parse_args(argv)
    with for_programs(o.json) as found:
        found |= tune(o)
    return 0 if found["loops"]["tuned"]["phase_margin"] >= LEAST_MARGIN_DEG else 1


def tune(o: argparse.Namespace) -> dict[str, Any]:
    """Design, print and save the gains: {parameters, loops}."""
    for name in ("cx", "cfk", "sigma", "rate"):
        value = getattr(o, name)
        if value is not None and not 0.0 < value < math.inf:
            raise ValueError(f"--{name} is {value:g}, must be above 0")
    if not 0.0 <= o.delay_cycles < math.inf:
        raise ValueError(f"--delay-cycles is {o.delay_cycles:g}, must be 0 or more")
    stiffness = o.cx * 1e3 if o.cx is not None else o.cfk * 1e3 / o.sigma
    # without a cycle of delay it is the continuous loop of the thesis, which has no hold
    delay = (o.delay_cycles + 0.5) / o.rate if o.delay_cycles else 0.0
    gains = design_gains(stiffness, o.sigma, delay)
    loops = {
        name: loop_of(g, stiffness, o.sigma, delay) for name, g in
        {"tuned": gains, "thesis": THESIS}.items()
    }  # fmt: skip
    print(f"C_x {stiffness / 1e3:.0f} N/mm, sigma {o.sigma:g} m, delay {1e3 * delay:.1f} ms")
    found = {}
    for name, loop in loops.items():
        of = figures(loop)
        found[name] = {k: v if math.isfinite(v) else None for k, v in of._asdict().items()}
        stable = of.phase_margin > 0.0 and of.gain_margin > 1.0
        end = f"settles to 0.5 % in {settling_time(loop):.1f} s" if stable else "unstable"
        print(
            f"{name:7} phase margin {of.phase_margin:.2f} deg at {of.crossover:.2f} Hz, "
            f"gain margin {of.gain_margin:.2f}, bandwidth {of.bandwidth:.2f} Hz, "
            f"peak {of.peak:.2f} dB at {of.peak_at:.2f} Hz, {end}"
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
    return {"parameters": values, "loops": found}
