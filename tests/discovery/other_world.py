# SPDX-License-Identifier: Apache-2.0
"""Small campaigns without noise in which one thing is wrong, of tires that share no formula with
the library of effects: the blind kit's second tire, and the bristle plant.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flatplank_analysis.contact_patch.data import from_tables
from flatplank_analysis.contact_patch.tire_runs import TireRuns
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_sim.plant.campaign import Campaign, CampaignRun
from flatplank_sim.plant.config import PlantConfig
from flatplank_sim.sealed.conditions import LOAD, STEP, Columns, Run, Setting
from flatplank_validation.blind.second import SecondMachine, SecondTire, counted, measure

RADIUS, SPEED, WHEEL_SPEED = 0.3108, 0.03092, 0.03088
BUMPS = np.array([12.0, 0.3, 8.0, 1.1])
SHOWN = ("time", "plank_position", "wheel_angle", "fx", "fy", "fz", "mx", "mz")

Wrong = Mapping[str, Any]
"""second tire: fields of `SecondMachine`; plant: defects by name"""


@dataclass(frozen=True)
class At:
    """What is set for one run; `speed` relative to the usual one."""

    kappa: float
    fz: float = LOAD
    pressure: float = 2.5
    alpha_deg: float = 0.0
    gamma_deg: float = 0.0
    start: int = 1
    speed: float = 1.0


def _repeated(*kappas: float) -> tuple[At, ...]:
    return tuple(At(k, start=s) for k in kappas for s in (1, 2, 3))


DESIGNS: dict[str, tuple[At, ...]] = {
    "plain": tuple(At(k, start=1 + i % 3) for i, k in enumerate((-0.1, -0.02, 0.0, 0.02, 0.1))),
    # what only one run shows of a channel is taken for noise (`contact_patch/denoising.py`)
    "twice": tuple(At(k, start=s) for k in (-0.05, 0.05) for s in (1, 2) * 2),
    "loads": tuple(At(k, fz, alpha_deg=1.0) for fz in (2400.0, 5000.0) for k in (-0.05, 0.05)),
    "pressures": tuple(
        At(k, pressure=p, alpha_deg=1.0) for p in (2.0, 3.0) for k in (-0.05, 0.05)
    ),
    "angles": tuple(At(k, alpha_deg=a) for a in (-2.0, 1.0, 3.0) for k in (-0.03, 0.03)),
    "side slip": tuple(At(0.0, alpha_deg=a) for a in (-2.0, -1.0, 1.0, 2.0)),
    "angles twice": tuple(At(k, alpha_deg=a) for a in (-2.0, 2.0) for k in (-0.03, 0.03) * 2),
    "cambers": tuple(
        At(k, alpha_deg=a, gamma_deg=g)
        for a, g in ((-1.0, -3.0), (1.0, -3.0), (1.0, 3.0))
        for k in (-0.03, 0.03)
    ),
    "to 5 %": _repeated(-0.05, -0.02, -0.01, 0.01, 0.02, 0.05),
    "to 10 %": _repeated(-0.1, -0.05, -0.01, 0.01, 0.05, 0.1),
    "speeds": tuple(At(k, speed=v) for v in (1.0, 0.5) for k in (-0.1, -0.05, 0.05, 0.1)),
}


def second(design: str, wrong: Wrong) -> list[Columns]:
    """Runs of the second tire."""
    settings = DESIGNS[design]
    out = []
    for index, at in enumerate(settings):
        pace = {"speed": SPEED * at.speed, "wheel_speed": WHEEL_SPEED * at.speed}
        machine = SecondMachine(**{**wrong, "kernel": {**pace, **wrong.get("kernel", {})}})
        setting = Setting(at.kappa, at.fz, at.pressure, at.alpha_deg, at.gamma_deg)
        run = Run(setting, at.start, index)
        out.append(counted(measure(SecondTire(), machine, run, len(settings), 1.0, 0.1, BUMPS)))
    return out


def plant(design: str, wrong: Wrong) -> list[Columns]:
    """Runs of the bristle plant."""
    still = {"mains_hum": None, "sensor_noise": {"bridge": 0.0}}
    config = PlantConfig.load("toyo", overrides={"defects": still | dict(wrong)})
    bench = Campaign(config, rate_hz=20.0, tire_step=0.0125)
    out = []
    for index, at in enumerate(DESIGNS[design]):
        wanted = CampaignRun(
            kappa=at.kappa, fz=at.fz, pressure=at.pressure, alpha=math.radians(at.alpha_deg),
            gamma=math.radians(at.gamma_deg), start_angle=math.radians(120.0 * (at.start - 1)),
            run_index=index, effective_rolling_radius=RADIUS, step_position=STEP,
        )  # fmt: skip
        out.append(bench.run(wanted, np.random.default_rng(index)))
    return out


def contact_point(design: str, wrong: Wrong) -> list[Columns]:
    """A single contact point on a spring: the slip follows over a relaxation length, then a steady
    curve. The length falls as the slope of the curve; `fixed`: the share of it that does not.
    """
    stiff, peak, soft = 7e4, 3900.0, 3.5e5
    fixed = wrong.get("fixed", 0.0)
    time = np.arange(0.0, 4.0 / SPEED, 0.02)
    travel = SPEED * time
    out = []
    for at in DESIGNS[design]:
        wanted = np.where(travel >= STEP, at.kappa, 0.0)
        turned = np.cumsum((1.0 + wanted) * np.gradient(travel)) / RADIUS
        slip = np.zeros_like(travel)
        for i in range(1, len(travel)):
            over = (stiff * slip[i - 1] / peak) ** 2
            length = stiff / soft * (fixed + (1.0 - fixed) / (1.0 + over) ** 1.5)
            gone = -math.expm1(-(travel[i] - travel[i - 1]) / length)
            slip[i] = slip[i - 1] + (wanted[i] - slip[i - 1]) * gone
        still = np.zeros_like(travel)
        force = stiff * slip / np.sqrt(1.0 + (stiff * slip / peak) ** 2)
        out.append({"time": time, "plank_position": travel, "wheel_angle": turned, "fx": force,
                    "fy": still, "fz": still + at.fz, "mx": still, "mz": still})  # fmt: skip
    return out


WORLDS = {"second": second, "plant": plant, "contact point": contact_point}


def blinded(columns: Sequence[Columns], others: Sequence[Columns]) -> list[Columns]:
    """The runs with the load channel of others: what it shows there it does not show here."""
    out = []
    for c, other in zip(columns, others, strict=True):
        size = min(len(c["fz"]), len(other["fz"]))
        out.append({n: v[:size] for n, v in c.items()} | {"fz": other["fz"][:size]})
    return out


def runs_of(design: str, columns: Sequence[Columns]) -> TireRuns:
    """As the search gets them."""
    tables = []
    for index, (at, c) in enumerate(zip(DESIGNS[design], columns, strict=True)):
        info = RunRecord(
            file=f"other_{index}", tire="OTHER", kappa=at.kappa, fz=at.fz, pressure=at.pressure,
            alpha_deg=at.alpha_deg, gamma_deg=at.gamma_deg, start=at.start, run_index=index,
            effective_rolling_radius=RADIUS, step_position=STEP, speed=SPEED * at.speed,
        )  # fmt: skip
        tables.append(MeasurementTable({n: c[n] for n in SHOWN}, info))
    return from_tables(tables)
