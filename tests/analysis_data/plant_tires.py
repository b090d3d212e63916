# SPDX-License-Identifier: Apache-2.0
"""Campaigns of every simulated tire by the fast plant: slip steps, nothing told of the tire."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from flatplank_data.exporters import export_campaign
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_sim.plant.campaign import COLUMNS, Campaign, CampaignRun
from flatplank_sim.plant.config import PlantConfig
from flatplank_validation.truth import TruthRow, truth_row

SLIPS = (-0.1, -0.05, -0.02, -0.01, 0.0, 0.01, 0.02, 0.05, 0.1)
STEP = 1.5


def plant_campaign(
    folder: Path,
    tire: str,
    slips: Sequence[float] = SLIPS,
    angles: Sequence[float] = (0.0,),
    starts: Sequence[int] = (1, 2, 3),
    defects: dict | None = None,
) -> tuple[Path, TruthRow]:
    """Slip steps at the tire's nominal load and pressure, and the plant's truth there."""
    config = PlantConfig.load(tire, overrides={"defects": defects or {}})
    t = config.tire
    truth = truth_row(config, t.nominal_load, t.nominal_pressure_bar)
    plant, tables = Campaign(config), []
    cases = [(a, k, s) for a in angles for k in slips for s in starts]
    for number, (angle, kappa, start) in enumerate(cases):
        run = CampaignRun(
            kappa=kappa, fz=t.nominal_load, alpha=math.radians(angle), run_index=number,
            start_angle=math.radians(120.0 * (start - 1)), step_position=STEP,
            effective_rolling_radius=truth.effective_rolling_radius,
        )  # fmt: skip
        made = plant.run(run, np.random.default_rng((3, number)))
        info = RunRecord(
            file=f"{t.name}_{100 * kappa:g}_a{angle:g}_{start}.parquet", tire=t.name, kappa=kappa,
            fz=t.nominal_load, pressure=t.nominal_pressure_bar, alpha_deg=angle, start=start,
            run_index=number, step_position=STEP,
            effective_rolling_radius=truth.effective_rolling_radius,
        )  # fmt: skip
        tables.append(MeasurementTable({name: made[name] for name in COLUMNS}, info))
    return export_campaign(tables, folder), truth
