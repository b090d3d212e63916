# SPDX-License-Identifier: Apache-2.0
"""Table of the true tire properties of the plant, measured by rolling its tire kernel, not taken
from a model of the analysis.

`python -m flatplank_validation.truth --tire toyo` prints it.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from flatplank_sim.plant import layout
from flatplank_sim.plant.compiling import entry
from flatplank_sim.plant.config import PlantConfig, tires
from flatplank_sim.plant.records import build_records
from flatplank_sim.plant.tire import advance, contact

SMALL = 2e-4
"""slip of the experiments for a stiffness [-], side slip [rad]"""
STEP = 2.5e-4
"""belt travel per step of the experiments [m]"""


class TruthRow(NamedTuple):
    """True tire properties at one load and pressure."""

    fz: float
    """load [N]"""
    pressure: float
    """[bar]"""
    vertical_stiffness: float
    """C_z [N/m]"""
    contact_half_length: float
    """a [m]"""
    effective_rolling_radius: float
    """r_e at fx = 0 [m]"""
    slip_stiffness: float
    """C_Fk = d fx / d kappa at 0 [N]"""
    cornering_stiffness: float
    """-d fy / d alpha at 0 [N/rad]"""
    carcass_stiffness_x: float
    """[N/m]"""
    carcass_stiffness_y: float
    """[N/m]"""
    standstill_stiffness_x: float
    """carcass and bristles in series [N/m]"""
    relaxation_length_x: float
    """slip stiffness over standstill stiffness [m]"""
    distance_63: float
    """travel to 63 % of a small slip step [m]"""
    friction: float
    """mu [-]"""
    fx_10: float
    """steady fx at kappa = 10 % [N]"""


@entry
def _roll(tire, state, bristles, fz, pressure, kappa, alpha, steps, step, out):
    """Forces of a tire that rolls at constant slip from rest: rows of travel, fx, fy."""
    p, s = tire[0], state[0]
    empty = np.ones((2, 2))
    x = 0.0
    for n in range(steps):
        dx = step
        dq = step * (1.0 + kappa)
        advance(
            p, s, bristles, fz, pressure, dq, dx, dx * alpha, 0.0, 0.0, x, 1.0, empty, False, 1.0
        )
        x += step
        out[n, 0], out[n, 1], out[n, 2] = x, s.fx, s.fy


@entry
def _contact(tire, state, fz, pressure):
    return contact(tire[0], state[0], fz, pressure)


def _experiment(
    tire: np.ndarray, fz: float, pressure: float, kappa: float, alpha: float, length: float
) -> tuple[np.ndarray, np.ndarray]:
    state = np.zeros(1, layout.TIRE_STATE)
    state["last"] = -1
    bristles = np.zeros((5, int(tire["ring"][0])))
    out = np.empty((int(length / STEP), 3))
    _roll(tire, state, bristles, fz, pressure, kappa, alpha, len(out), STEP, out)
    return out, state


def truth_row(config: PlantConfig, fz: float, pressure: float) -> TruthRow:
    """True properties of the plant's tire at one load [N] and pressure [bar]."""
    tire = build_records(config, 0.004).tire
    state = np.zeros(1, layout.TIRE_STATE)
    _, _, cx, cy = _contact(tire, state, fz, pressure)
    up, _ = _experiment(tire, fz, pressure, SMALL, 0.0, 8.0)
    down, _ = _experiment(tire, fz, pressure, -SMALL, 0.0, 8.0)
    side, _ = _experiment(tire, fz, pressure, 0.0, SMALL, 8.0)
    deep, _ = _experiment(tire, fz, pressure, 0.10, 0.0, 3.0)
    stiffness = (up[-1, 1] - down[-1, 1]) / (2.0 * SMALL)
    _, stuck = _experiment(tire, fz, pressure, 0.0, 0.0, STEP)
    at_rest = float(stuck["gx"][0])
    cz, a, re, friction = (float(state[name][0]) for name in ("cz", "a", "re", "friction"))
    distance = float(np.interp(0.632 * up[-1, 1], up[:, 1], up[:, 0]))
    return TruthRow(
        fz, pressure, cz, a, re, stiffness, -side[-1, 2] / SMALL, cx, cy, at_rest,
        stiffness / at_rest, distance, friction, deep[-1, 1],
    )  # fmt: skip


def truth_table(
    config: PlantConfig, loads: Sequence[float] = (), pressures: Sequence[float] = ()
) -> tuple[TruthRow, ...]:
    """One row per load [N] and pressure [bar]; default: 0.5, 1 and 1.5 nominal loads."""
    t = config.tire
    loads = loads or tuple(f * t.nominal_load for f in (0.5, 1.0, 1.5))
    pressures = pressures or (0.8 * t.nominal_pressure_bar, t.nominal_pressure_bar)
    return tuple(truth_row(config, fz, p) for p in pressures for fz in loads)


def as_text(rows: Sequence[TruthRow]) -> str:
    """The table for a terminal: one line per quantity."""
    lines = []
    for name in TruthRow._fields:
        values = "".join(f"{getattr(row, name):>12.5g}" for row in rows)
        lines.append(f"{name:26}{values}")
    return "\n".join(lines)


def main(args: Sequence[str] | None = None) -> int:
    """Print the table of one tire or of all."""
    parser = argparse.ArgumentParser(prog="flatplank_validation.truth", description=__doc__)
    parser.add_argument("--tire", choices=tires(), help="default: all packaged tires")
    parser.add_argument("--preset", help="defects of a packaged preset, for instance thesis2023")
    parser.add_argument("--load", type=float, nargs="*", default=(), metavar="N")
    parser.add_argument("--pressure", type=float, nargs="*", default=(), metavar="BAR")
    options = parser.parse_args(args)
    for name in (options.tire,) if options.tire else tires():
        config = PlantConfig.load(name, preset=options.preset)
        print(f"{name} ({config.tire.name}), SI units, pressure in bar")
        print(as_text(truth_table(config, options.load, options.pressure)), end="\n\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
