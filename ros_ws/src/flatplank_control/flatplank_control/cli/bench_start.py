# SPDX-License-Identifier: Apache-2.0
"""Benchmark of controller and start: the thesis's way and ours side by side on the same plant."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from flatplank_control.bench.driven_plank import DrivenPlank
from flatplank_control.bench.start_bench import StartBench
from flatplank_control.bench.start_cases import FURTHER, FZ, Made, further, slip_errors
from flatplank_control.free_rolling.design import phase_margin
from flatplank_control.free_rolling.params import THESIS_LEAD_ALPHA
from flatplank_hw.plant.truth import truth_row

CONTROLLERS: dict[str, Mapping[str, Any]] = {
    "thesis": {"lead_alpha": THESIS_LEAD_ALPHA},
    "ours": {"automatic": True},
}
SEQUENCERS: dict[str, Mapping[str, Any]] = {"thesis": {}, "ours": {"follow_until": 0.25}}
CASES = (
    ("toyo", 1000.0), ("toyo", 3700.0), ("toyo", 8000.0), ("continental", 3250.0),
    ("michelin", 2400.0), ("racing", 3700.0),
)  # fmt: skip
SLIPS = (0.05, 0.1)
DRIVEN = ("toyo", "racing")
WINDOW = 160
"""cycles over which a force is averaged: 20 mm"""


def settled(rows: np.ndarray) -> float:
    """Road [m] behind which Fx stays within 5 % of 50 N."""
    smooth = np.convolve(rows[:, 1], np.ones(WINDOW) / WINDOW, "valid")
    outside = np.flatnonzero(np.abs(smooth - 50.0) > 2.5)
    if outside.size and outside[-1] == smooth.size - 1:
        return float("nan")
    return float(rows[outside[-1] + WINDOW // 2, 0]) if outside.size else 0.0


def free_rolling(tire: str, fz: float, way: str, preset: str | None) -> dict[str, float]:
    """Figures of a controller run."""
    bench = StartBench(tire, preset=preset, controller=CONTROLLERS[way])
    rows = bench.free_rolling(fz, 2.5)
    late = rows[rows[:, 0] > 1.8, 1]
    config = bench.config
    truth = truth_row(config, fz, config.tire.nominal_pressure_bar)
    c = bench.controller
    margin = phase_margin(
        c.gains, truth.standstill_stiffness_x, truth.relaxation_length_x, c.parameters.loop_delay
    )
    return {
        "phase_margin_deg": margin,
        "settled_m": settled(rows),
        "steady_error_percent": 100.0 * (float(late.mean()) / 50.0 - 1.0),
        "swing_n": float(np.ptp(late)),
        "start_force_n": float(rows[:, 1].min()),
    }


def driven(tire: str, fz: float, way: str) -> dict[str, float]:
    """The same start with a driven plank: free rolling, and slip with a step at 0.3 m."""
    rolled = DrivenPlank(tire, controller=CONTROLLERS[way]).free_rolling(fz, 2.5)
    rows = DrivenPlank(tire, sequencer=SEQUENCERS[way]).slip(fz, 0.0, at=0.28, distance=0.32)
    before = rows[(rows[:, 0] > 0.28) & (rows[:, 0] < 0.3), 1]
    return {
        "settled_m": settled(rolled),
        "force_before_step_at_0_3_m_n": float(before.mean()),
        "slip_start_force_n": float(rows[:, 1].min()),
    }


def slip(tire: str, fz: float, way: str, preset: str | None) -> dict[str, float]:
    """Force before a slip step at 0.3 m."""
    bench = StartBench(tire, preset=preset, sequencer=SEQUENCERS[way])
    rows = bench.slip(fz, 0.0, at=0.28, distance=0.32)
    before = rows[(rows[:, 0] > 0.28) & (rows[:, 0] < 0.3), 1]
    return {"force_before_step_at_0_3_m_n": float(before.mean())}


def main(argv: list[str]) -> int:
    """Print the table; 0."""
    p = argparse.ArgumentParser(prog="flatplank bench-start", description=__doc__)
    p.add_argument("--preset", help="defects of the machine: thesis2023")
    p.add_argument("--json", action="store_true", help="for programs")
    p.add_argument("--tire", help="only this one")
    o = p.parse_args(argv)
    found = []
    for tire, fz in CASES:
        if o.tire in (None, tire):
            both = {
                way: {**free_rolling(tire, fz, way, o.preset), **slip(tire, fz, way, o.preset)}
                for way in CONTROLLERS
            }
            found.append({"tire": tire, "fz": fz, **both})
    more = o.tire is None
    made = [
        {"made": m._asdict(), **{way: further(m, c) for way, c in CONTROLLERS.items()}}
        for m in (FURTHER if more else ())
    ]
    plank = {t: {w: driven(t, FZ, w) for w in CONTROLLERS} for t in (DRIVEN if more else ())}
    slips = {f"{100 * k:+g} %": slip_errors(k) for k in (SLIPS if more else ())}
    if o.json:
        print(
            json.dumps(
                {"tires": found, "further": made, "driven_plank": plank, "slip": slips}, indent=1
            )
        )
        return 0
    print(f"{'':36}{'thesis':>10}{'ours':>10}")
    for case in found:
        print(f"{case['tire']} at {case['fz']:.0f} N")
        for name in case["ours"]:
            print(f"  {name:34}{case['thesis'][name]:10.2f}{case['ours'][name]:10.2f}")
    for case in made:
        m = Made(**case["made"])
        delay = 1e3 * (m.cycles + 0.5) / m.rate
        print(f"C_x of {m.share:g} x the Toyo's, sigma {m.sigma:g} m, delay {delay:.0f} ms")
        for name in case["ours"]:
            print(f"  {name:34}{case['thesis'][name]:10.2f}{case['ours'][name]:10.2f}")
    for tire, both in plank.items():
        print(f"{tire} at {FZ:.0f} N, plank driven too")
        for name in both["ours"]:
            print(f"  {name:34}{both['thesis'][name]:10.2f}{both['ours'][name]:10.2f}")
    for kappa, error in slips.items():
        print(
            f"  slip {kappa:7} worst over a turn [%]{error['thesis']:13.3f}{error['ours']:10.4f}"
        )
    return 0
