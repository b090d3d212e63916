# SPDX-License-Identifier: Apache-2.0
"""Simulates and analyses one operating point with the fast plant, for several benchmarks."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from flatplank_analysis.report.analysis import PointJob, analyse_point
from flatplank_analysis.report.results import PointResult
from flatplank_data.problem import Problem
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_sim.plant.campaign import COLUMNS, Campaign, CampaignRun
from flatplank_sim.plant.config import PlantConfig

SLIPS = (-0.10, -0.05, -0.02, -0.01, 0.0, 0.01, 0.02, 0.05, 0.10)
STEP = 1.5


@dataclass(frozen=True)
class MadeRun:
    """A simulated run with the interface of a run in a campaign folder."""

    table: MeasurementTable

    @property
    def info(self) -> RunRecord:
        """The run record."""
        return self.table.info

    def read(self, columns: Sequence[str]) -> tuple[MeasurementTable, list[Problem]]:
        """The wanted columns, without remarks."""
        return self.table.select([c for c in columns if c in self.table]), []


def simulate_point(
    preset: str | None = None,
    defects: Mapping[str, Any] | None = None,
    *,
    slips: Sequence[float] = SLIPS,
    starts: Sequence[int] = (1, 2, 3),
    fz: float = 3700.0,
    radius_scale: float = 1.0,
    seed: int = 0,
) -> list[MadeRun]:
    """Slip steps of one operating point; `radius_scale` scales the rolling radius of the slip
    control."""
    config = PlantConfig.load(preset=preset, overrides={"defects": dict(defects or {})})
    plant = Campaign(config)
    radius = radius_scale * plant.true_radius(fz, config.tire.vertical_stiffness)
    facts = [
        RunRecord(
            file=f"run_{number:02d}",
            tire="TOY",
            kappa=kappa,
            fz=fz,
            pressure=config.tire.nominal_pressure_bar,
            start=start,
            run_index=number,
            effective_rolling_radius=radius,
            step_position=STEP,
        )
        for number, (kappa, start) in enumerate((k, s) for k in slips for s in starts)
    ]
    runs = [
        CampaignRun(
            kappa=info.kappa,
            fz=fz,
            start_angle=math.radians(120.0 * (info.start - 1)),
            run_index=info.run_index,
            effective_rolling_radius=radius,
            step_position=STEP,
        )
        for info in facts
    ]
    return [
        MadeRun(MeasurementTable({name: made[name] for name in COLUMNS}, info))
        for made, info in zip(plant.simulate(runs, seed), facts, strict=True)
    ]


def analyse_runs(runs: Sequence[MadeRun]) -> PointResult:
    """All models of one operating point, as in a report."""
    return analyse_point(PointJob(runs[0].info.condition.operating_point, runs))
