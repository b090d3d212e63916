# SPDX-License-Identifier: Apache-2.0
"""Makes a challenge: nine slips, three starts, something hidden, the answer sealed."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.signal import lfilter

from flatplank_analysis.data import MeasurementTable, RunInfo
from flatplank_analysis.data.exporters import export_campaign
from flatplank_control.runner.measurement import START_ANGLES
from flatplank_sim.plant.campaign import COLUMNS, Campaign, CampaignRun
from flatplank_sim.plant.config import PlantConfig
from flatplank_sim.sealed.conditions import LOAD, PRESSURE, STEP, Run, Setting
from flatplank_sim.sealed.menu import MENU, Defects
from flatplank_sim.sealed.outside import OUTSIDE, Force
from flatplank_sim.sealed.seal import seal
from flatplank_sim.twin.campaign import SLIPS

NAME = "TOY"
TIRE_SCATTER = 0.01
"""standard deviation of friction and stiffness from run to run [-]"""
NOISE = 15.0
"""standard deviation of the slow noise of the forces [N]; thesis 6.3 finds 24 N at no slip"""
NOISE_TIME = 0.3
"""it is correlated over so long [s]"""
OUTSIDE_SIZES = (60.0, 120.0)
"""of a force that is in no library [N]"""
Progress = Callable[[int, int, str], None]


def make_challenge(
    folder: Path,
    seed: int,
    progress: Progress = lambda _done, _all, _name: None,
    outside: str = "",
) -> Path:
    """A campaign folder with `answer.sealed`; the same seed makes the same challenge.

    outside: a force of `sealed.outside`, which no effect of the library explains, is hidden
    instead of a defect.
    """
    random = np.random.default_rng(seed)
    name = "nothing" if outside else str(random.choice(sorted(MENU)))
    hidden = MENU[name]
    size = hidden.draw(random)
    force, place = _foreign(outside, random)
    plain = PlantConfig.load("toyo")
    radius = round(Campaign(plain).true_radius(LOAD, plain.tire.vertical_stiffness), 5)
    pairs = [(kappa, start) for kappa in SLIPS for start in START_ANGLES]
    order = random.permutation(len(pairs))
    tables = []
    for index, which in enumerate(order):
        kappa, start = pairs[which]
        run = CampaignRun(
            kappa=kappa,
            fz=LOAD,
            pressure=PRESSURE,
            start_angle=math.radians(START_ANGLES[start]),
            run_index=index,
            effective_rolling_radius=radius,
            step_position=STEP,
        )
        own = np.random.default_rng((seed, index))
        columns = Campaign(_scattered(plain, hidden.defects(size), own)).run(run, own)
        _add_noise(columns, own)
        columns["fx"] = columns["fx"] + force(columns, Run(Setting(kappa), start, index))
        label = f"{NAME}_REL_LNG_{100 * kappa:g}perc_T_p25_Fz3700_{start}"
        info = RunInfo(
            file=f"{label}.parquet",
            tire=NAME,
            kappa=kappa,
            fz=LOAD,
            pressure=PRESSURE,
            start=start,
            run_index=index,
            effective_rolling_radius=radius,
            step_position=STEP,
        )
        tables.append(MeasurementTable({c: columns[c] for c in COLUMNS}, info))
        progress(index + 1, len(pairs), label)
    export_campaign(tables, folder)
    effects = []
    if hidden.names:
        first, *others = hidden.names
        effects = [{"name": first, "size": size, "unit": hidden.unit, "class": others}]
    seal({"seed": seed, "tire": "toyo", "effects": effects, "outside": place}, folder)
    return folder


def _foreign(name: str, random: np.random.Generator) -> tuple[Force, dict[str, Any] | None]:
    """A force that is in no library and its place; none without a name."""
    if not name:
        return (lambda _columns, _run: np.zeros(1)), None
    return OUTSIDE[name](float(random.uniform(*OUTSIDE_SIZES)), random)


def _scattered(plain: PlantConfig, defects: Defects, random: np.random.Generator) -> PlantConfig:
    """The bench of one run: the tire is not quite the same every time."""
    names = ("friction", "tread_stiffness_x", "carcass_stiffness_x")
    tire = {n: getattr(plain.tire, n) * (1 + TIRE_SCATTER * random.normal()) for n in names}
    return PlantConfig.load("toyo", overrides={"defects": defects, "tire": tire})


def _add_noise(columns: dict[str, np.ndarray], random: np.random.Generator) -> None:
    """Slow noise of the machine on the forces, a first-order process."""
    keep = math.exp(-float(columns["time"][1] - columns["time"][0]) / NOISE_TIME)
    for name in ("fx", "fy", "fz"):
        white = random.normal(0.0, NOISE * math.sqrt(1.0 - keep**2), len(columns[name]))
        columns[name] = columns[name] + lfilter([1.0], [1.0, -keep], white)
