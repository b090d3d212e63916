# SPDX-License-Identifier: Apache-2.0
"""All of Table 6.2 in a minute: the fast plant with the machine of the thesis writes one campaign
folder. `flatplank report FOLDER` then makes the tables and figures of chapters 6 and 7.

    python validation/benchmarks/thesis_campaign.py FOLDER [--quiet]
"""

from __future__ import annotations

import argparse
import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from flatplank_data.exporters import export_campaign
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_sim.plant.campaign import COLUMNS, Campaign, CampaignRun
from flatplank_sim.plant.config import PlantConfig
from flatplank_sim.plant.drivetrain import friction_torque
from flatplank_validation.truth import truth_row
from plant_points import SLIPS, STEP

LOADS = (1850.0, 3700.0, 5550.0)
PRESSURES = (2.0, 2.5)
ANGLES = (0.0, 1.0, 5.0, 10.0)
CAMBERS = (0.0, 5.0)
STARTS = (1, 2, 3)
HEIGHTS = (0.32, 0.28)
"""range of the loaded radius in a vertical stiffness run, from and to [m]"""


def conditions() -> list[tuple[float, float, float, float]]:
    """Conditions of the slip steps: load, pressure, side slip, camber."""
    straight = [(fz, p, 0.0, 0.0) for p in PRESSURES for fz in LOADS]
    turned = [(3700.0, 2.5, a, g) for g in CAMBERS for a in ANGLES]
    return list(dict.fromkeys(straight + turned))


def facts() -> Iterator[RunRecord]:
    """Run records: slip steps, repeats of four conditions, runs with the flexplates off."""
    number = itertools.count()
    for fz, p, a, g in conditions():
        for kappa, start in itertools.product(SLIPS, STARTS):
            yield _info(next(number), fz, p, a, g, kappa, start)
        for start in STARTS:
            free = _info(next(number), fz, p, a, g, 0.0, start)
            yield replace(
                free, measurement="free_rolling", r_e_source="flexplates_off",
                step_position=math.nan, file=f"{free.file}_FREE",
            )  # fmt: skip
    for kappa, repeat in itertools.product((-0.05, -0.01, 0.01, 0.05), range(2, 11)):
        info = _info(next(number), 3700.0, 2.5, 0.0, 0.0, kappa, 1)
        yield replace(info, repeat=repeat, file=f"{info.file}_r{repeat:02d}")


def _info(
    number: int, fz: float, p: float, a: float, g: float, kappa: float, start: int
) -> RunRecord:
    name = f"TOY_REL_{100 * kappa:g}perc_p{10 * p:g}_Fz{fz:g}_a{a:g}_g{g:g}_{start}"
    return RunRecord(
        file=name, tire="TOY", kappa=kappa, fz=fz, pressure=p, alpha_deg=a, gamma_deg=g,
        start=start, run_index=number, step_position=STEP,
    )  # fmt: skip


def rolling(config: PlantConfig) -> Iterator[MeasurementTable]:
    """Make all rolling runs."""
    plant = Campaign(config)
    for info in facts():
        run, radius = _run(plant, info)
        made = plant.run(run, np.random.default_rng((1, info.run_index)))
        columns = {name: made[name] for name in COLUMNS}
        yield MeasurementTable(columns, info).with_info(effective_rolling_radius=radius)


def _run(plant: Campaign, info: RunRecord) -> tuple[CampaignRun, float]:
    tire = plant.config.tire
    scale = info.pressure / tire.nominal_pressure_bar
    stiffness = tire.vertical_stiffness * scale**tire.vertical_stiffness_pressure
    radius = plant.true_radius(info.fz, stiffness)
    run = CampaignRun(
        kappa=info.kappa,
        fz=info.fz,
        pressure=info.pressure,
        alpha=math.radians(info.alpha_deg),
        gamma=math.radians(info.gamma_deg),
        start_angle=math.radians(120.0 * (info.start - 1)),
        run_index=info.run_index,
        effective_rolling_radius=radius,
        step_position=STEP,
        free=info.r_e_source == "flexplates_off",
    )
    return run, radius


def at_rest(config: PlantConfig) -> Iterator[MeasurementTable]:
    """Make vertical stiffness, footprints and an unloaded turn from the plant's truth."""
    down = np.linspace(*HEIGHTS, 400)
    height = np.concatenate([down, down[::-1]])
    rows = {p: [truth_row(config, fz, p) for fz in LOADS] for p in PRESSURES}
    random = np.random.default_rng(2)
    for p, found in rows.items():
        force = found[1].vertical_stiffness * np.maximum(config.tire.free_radius - height, 0.0)
        columns = {"loaded_radius": height, "fz": force + 5.0 * random.standard_normal(800)}
        name = f"TOY_STF_p{10 * p:g}"
        info = RunRecord(file=name, tire="TOY", measurement="stiffness", pressure=p)
        yield MeasurementTable(columns, info)
        prints = {
            "fz": np.array([r.fz for r in found]),
            "half_length": np.array([r.contact_half_length for r in found]),
        }
        extra = {"free_radius": config.tire.free_radius}
        info = RunRecord(file=f"TOY_PRINT_p{10 * p:g}", tire="TOY", measurement="footprint",
                       pressure=p, extra=extra)  # fmt: skip
        yield MeasurementTable(prints, info)
    w = config.wheel_drive
    curve = np.array([w.friction_speed, w.friction_torque]).T.copy()
    speed = np.repeat(np.linspace(5.0, 180.0, 36), 100)
    torque = np.array([friction_torque(curve, v) for v in speed])
    torque = torque + 0.02 * random.standard_normal(len(speed))
    info = RunRecord(file="TOY_TURN", tire="TOY", measurement="unloaded_turn")
    yield MeasurementTable({"motor_velocity": speed, "motor_torque": torque}, info)


def main(argv: Sequence[str] | None = None) -> None:
    """Write the folder."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder")
    parser.add_argument("--quiet", action="store_true", help="a machine without defects")
    chosen = parser.parse_args(argv)
    config = PlantConfig.load(preset=None if chosen.quiet else "thesis2023")
    tables = itertools.chain(rolling(config), at_rest(config))
    print(export_campaign(tables, chosen.folder))


if __name__ == "__main__":
    main()
