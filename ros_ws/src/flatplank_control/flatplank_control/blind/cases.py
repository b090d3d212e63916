# SPDX-License-Identifier: Apache-2.0
"""The list of blind campaigns, and how one of them is made."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any
from zlib import crc32

import numpy as np

from flatplank_analysis.data import MeasurementTable, RunInfo
from flatplank_control.blind.detectable import detectable
from flatplank_control.blind.menu import MENU, PAIRS
from flatplank_control.blind.outside import OUTSIDE
from flatplank_control.blind.plan import NOISES, RELATIVE, STEP, Run, noise, runs_of
from flatplank_control.blind.worlds import WORLDS, Scatter

OUTSIDE_SIZES = (60.0, 120.0)
"""[N]"""


@dataclass(frozen=True)
class Case:
    """One campaign to be: a name says everything, with the seed of the kit."""

    group: str
    """none, single, pair, outside"""
    world: str
    hidden: tuple[str, ...] = ()
    factor: float = 1.0
    """times the detectable size"""
    noise: str = "usual"
    scatter: float = 0.01
    design: str = "plain"
    number: int = 0

    @property
    def key(self) -> str:
        """Its name in the journal."""
        what = "+".join(self.hidden) or "nothing"
        return (
            f"{self.group}/{self.world}/{what}/x{self.factor:g}/{self.noise}/"
            f"s{self.scatter:g}/{self.design}/{self.number}"
        )


def full(small: bool = False, repeats: int = 5) -> Iterator[Case]:
    """All cases; the order mixes the groups, so that any beginning is a fair sample."""
    if small:
        yield from _small()
        return
    lists = [list(_none()), list(_singles(repeats)), list(_pairs()), list(_outside())]
    draw = np.random.default_rng(0)
    for cases in lists:
        draw.shuffle(cases)
    # each list is spread evenly over the whole
    places = [(i + 0.5) / len(cases) for cases in lists for i in range(len(cases))]
    everything = [c for cases in lists for c in cases]
    for i in np.argsort(places, kind="stable"):
        yield everything[i]


def _small() -> Iterator[Case]:
    yield Case("none", "second", design="small")
    yield Case("none", "plant", design="small", scatter=0.03, noise="coloured")
    for world, name in (("second", "drive_backlash"), ("plant", "parasitic_force")):
        yield Case("single", world, (name,), 2.0, design="small")
    yield Case("outside", "second", ("bump",), design="small")


def _none() -> Iterator[Case]:
    for world in WORLDS:
        for kind in NOISES:
            for scatter in (0.0, 0.03):
                for number in range(7):
                    yield Case("none", world, (), 1.0, kind, scatter, number=number)


def _singles(repeats: int) -> Iterator[Case]:
    for name, item in MENU.items():
        for world in WORLDS:
            if not WORLDS[world](None).has(name):
                continue
            for factor in (1.0, 2.0, 4.0) if item.least < item.most else (1.0,):
                count = repeats if factor < 4.0 else max(repeats // 2, 1)
                for number in range(count):
                    yield Case("single", world, (name,), factor, design=item.design, number=number)


def _pairs() -> Iterator[Case]:
    for one, other in PAIRS:
        for number in range(2):
            for world in WORLDS:
                if WORLDS[world](None).has(one) and WORLDS[world](None).has(other):
                    yield Case("pair", world, (one, other), 3.0, number=number)


def _outside() -> Iterator[Case]:
    for name in OUTSIDE:
        for world in WORLDS:
            for number in range(5):
                yield Case("outside", world, (name,), number=number)


def sizes_of(case: Case) -> dict[str, float]:
    """Sizes of what is hidden; infinite when these runs cannot show an effect."""
    if case.group in ("none", "outside"):
        return {}
    out = {}
    for name in case.hidden:
        least = detectable(case.world, name, case.noise, case.scatter, case.design)
        fits = math.isfinite(least) and least <= MENU[name].most
        out[name] = min(case.factor * least, MENU[name].most) if fits else math.inf
    return out


def make(case: Case, seed: int) -> tuple[list[MeasurementTable], dict[str, Any]] | None:
    """Tables of a campaign and its answer; None when the runs cannot show what is hidden."""
    sizes = sizes_of(case)
    if any(not math.isfinite(s) or s > MENU[n].most for n, s in sizes.items()):
        return None
    random = np.random.default_rng((seed, crc32(case.key.encode())))
    world = WORLDS[case.world](random)
    runs = runs_of(case.design, random)
    scatter = Scatter.drawn(len(runs), case.scatter, random)
    columns = world.run(runs, sizes, random, scatter)
    answer: dict[str, Any] = {"effects": [_answer(n, s) for n, s in sizes.items()]}
    answer["outside"] = None
    if case.group == "outside":
        size = float(random.uniform(*OUTSIDE_SIZES))
        force, answer["outside"] = OUTSIDE[case.hidden[0]](size, random)
        for c, run in zip(columns, runs, strict=True):
            c["fx"] = c["fx"] + force(c, run)
    tables = []
    for c, run in zip(columns, runs, strict=True):
        dt = float(c["time"][1] - c["time"][0])
        for name, share in RELATIVE.items():
            c[name] = c[name] + noise(NOISES[case.noise], len(c["time"]), dt, random, share)
        tables.append(measured_table(c, run, world.radius))
    return tables, answer


def _answer(name: str, size: float) -> dict[str, Any]:
    item = MENU[name]
    first, *others = item.names
    return {"name": first, "size": size, "unit": item.unit, "class": others, "sized": item.sized}


def measured_table(c: dict[str, np.ndarray], run: Run, radius: float) -> MeasurementTable:
    """A run of a world as it is given to the analysis."""
    return MeasurementTable(_shown(c), _info(run, radius))


def _shown(c: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    names = ("time", "plank_position", "wheel_angle", *RELATIVE)
    return {n: c[n] for n in names}


def _info(run, radius: float) -> RunInfo:
    s = run.setting
    return RunInfo(
        file=f"blind_{run.index:02d}.parquet", tire="BLIND", kappa=s.kappa, fz=s.fz,
        pressure=s.pressure, alpha_deg=s.alpha_deg, gamma_deg=s.gamma_deg, start=run.start,
        run_index=run.index, effective_rolling_radius=round(radius, 5), step_position=STEP,
    )  # fmt: skip
