# SPDX-License-Identifier: Apache-2.0
"""Makes a blind campaign from its name and a seed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any
from zlib import crc32

import numpy as np

from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_sim.sealed.conditions import STEP, Columns, Run
from flatplank_sim.sealed.menu import OUTSIDE, Force
from flatplank_validation.blind.detectable import (
    consequence_of_force,
    detectable,
    detectable_force,
)
from flatplank_validation.blind.menu import KIN, MENU
from flatplank_validation.blind.noise import NOISES, RELATIVE, shown
from flatplank_validation.blind.plan import runs_of
from flatplank_validation.blind.worlds import PRESENT, WORLDS, Scatter

"""what a factor multiplies, by the letter in the name of a campaign"""
PAIR = 3.0
"""size of an effect of a pair over its detectable size, or its size of no consequence if larger"""


@dataclass(frozen=True)
class Case:
    """Definition of one campaign: with the seed of the kit, its name determines everything."""

    group: str
    """none, single, pair, outside, combined"""
    world: str
    hidden: tuple[str, ...] = ()
    factor: float = 1.0
    noise: str = "usual"
    scatter: float = 0.01
    design: str = "plain"
    number: int = 0
    rung: str = "x"
    """base of the factor: x: the detectable size, c: the size of no consequence"""

    @property
    def key(self) -> str:
        """Key in the journal."""
        what = "+".join(self.hidden) or "nothing"
        return (
            f"{self.group}/{self.world}/{what}/{self.rung}{self.factor:g}/{self.noise}/"
            f"s{self.scatter:g}/{self.design}/{self.number}"
        )


def least_of(case: Case, name: str) -> float:
    """Detectable size of an effect with the noise and scatter of this campaign."""
    return detectable(case.world, name, case.noise, case.scatter, case.design)


def size_of(case: Case, name: str) -> float:
    """Size of a hidden effect; infinite when the campaign is not scored, because the runs cannot
    show the effect, or because the size of no consequence is below the detectable one.
    """
    item, least = MENU[name], least_of(case, name)
    if not math.isfinite(least) or least > item.most:
        return math.inf
    if item.least == item.most:
        return item.most
    if case.group == "pair":
        return min(PAIR * max(least, item.least), item.most)
    if case.rung == "c" and item.least < least:
        return math.inf
    size = case.factor * (least if case.rung == "x" else item.least)
    return size if size <= item.most else math.inf


def make(case: Case, seed: int) -> tuple[list[MeasurementTable], dict[str, Any]] | None:
    """Tables of a campaign and its answer; None when it is not scored."""
    names = () if case.group in ("none", "outside") else case.hidden
    sizes = {name: size_of(case, name) for name in names}
    if not all(math.isfinite(s) for s in sizes.values()):
        return None
    random = np.random.default_rng((seed, crc32(case.key.encode())))
    world = WORLDS[case.world](random)
    runs = runs_of(case.design, random)
    scatter = Scatter.drawn(len(runs), case.scatter, random)
    columns = world.run(runs, sizes, random, scatter)
    answer: dict[str, Any] = {"effects": [_answer(case, n, s) for n, s in sizes.items()]}
    answer["outside"] = None
    # an unmeasured steering angle is enough to show combined slip, and different loads are
    # enough to show rolling resistance
    answer["present"] = list(PRESENT.get(case.world, ()))
    if case.group == "outside":
        draw = int(random.integers(2**32))
        unit, _ = OUTSIDE[case.hidden[0]](1.0, np.random.default_rng(draw))
        sizes = _sizes_of_force(case, unit)
        if not math.isfinite(sizes["size"]):
            return None
        force, place = OUTSIDE[case.hidden[0]](sizes["size"], np.random.default_rng(draw))
        answer["outside"] = place | sizes
        for c, run in zip(columns, runs, strict=True):
            c["fx"] = c["fx"] + force(c, run)
    tables = []
    for c, run in zip(columns, runs, strict=True):
        dt = float(c["time"][1] - c["time"][0])
        for name, share in RELATIVE.items():
            c[name] = shown(NOISES[case.noise], c[name], dt, random, share)
        tables.append(measured_table(c, run, world.radius))
    return tables, answer


def _sizes_of_force(case: Case, unit: Force) -> dict[str, float]:
    """Size of a force outside the library, its detectable size, and the size of no consequence;
    the size is infinite when it is not scored.
    """
    around = case.world, unit, case.noise, case.scatter, case.design
    least, slight = detectable_force(*around), consequence_of_force(*around)
    size = case.factor * (least if case.rung == "x" else slight)
    if case.rung == "c" and slight < least:
        size = math.inf
    return {"size": size, "detectable": least, "consequence": slight}


def _answer(case: Case, name: str, size: float) -> dict[str, Any]:
    item = MENU[name]
    return {
        "name": name, "size": size, "unit": item.unit, "class": list(KIN.get(name, ())),
        "sized": item.sized, "detectable": least_of(case, name), "consequence": item.least,
    }  # fmt: skip


def measured_table(c: Columns, run: Run, radius: float) -> MeasurementTable:
    """Measurement table of a run, as given to the analysis."""
    names = ("time", "plank_position", "wheel_angle", *RELATIVE)
    s = run.setting
    info = RunRecord(
        file=f"blind_{run.index:02d}.parquet", tire="BLIND", kappa=s.kappa, fz=s.fz,
        pressure=s.pressure, alpha_deg=s.alpha_deg, gamma_deg=s.gamma_deg, start=run.start,
        run_index=run.index, effective_rolling_radius=round(radius, 5), step_position=STEP,
    )  # fmt: skip
    return MeasurementTable({n: c[n] for n in names}, info)
