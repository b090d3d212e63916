# SPDX-License-Identifier: Apache-2.0
"""Tires of other forms with nothing hidden: what the law of a fitted tire file leaves of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import flatplank_analysis as fp
from flatplank_validation.sweep_sets.brush import Brush, Plan, sweeps, text_of

FOUR = (1000.0, 2200.0, 3400.0, 4600.0)
TIRES: dict[str, tuple[Brush, Plan]] = {
    "as in the series": (Brush(), Plan()),
    "soft": (Brush(bristle=8e6), Plan()),
    "stiff": (Brush(bristle=3.2e7), Plan()),
    "friction falls with load": (Brush(by_load=0.3), Plan()),
    "length as the load": (Brush(longer=1.0), Plan()),
    "length of few loads": (Brush(longer=0.3), Plan()),
    "flat pressure": (Brush(fuller=0.5), Plan()),
    "pointed pressure": (Brush(fuller=2.0), Plan()),
    "small slip": (Brush(), Plan(most=5.0)),
    "four loads": (Brush(longer=0.8, by_load=0.2), Plan(loads=FOUR, pressures=(200.0,))),
}
"""name -> tire and plan, nothing hidden"""


@dataclass(frozen=True)
class FormOf:
    """A tire file on another series of the tire to which it was fitted."""

    tire: str
    error: float
    """of the base of the search, mean curves, root mean square [N]"""
    free: float
    """the same of free B, C, D, E [N]"""
    verdict: str
    named: tuple[str, ...]


def forms(folder: Path, seed: int, noise: float = 2.0) -> Iterator[FormOf]:
    """Each tire of `TIRES`, nothing hidden; noise: of a sample [N]."""
    for number, (name, (brush, plan)) in enumerate(TIRES.items()):
        made = []
        for k in (0, 1):
            path = folder / f"{number}_{k}.csv"
            columns = sweeps(replace(brush, noise=noise), plan, seed + 2 * number + k)
            path.write_text(text_of(columns), encoding="utf-8")
            made.append(fp.sweeps(path))
        made[0].fit().save(folder / f"{number}.tir")
        found = made[1].diagnose(folder / f"{number}.tir")
        search = found.result.drawable(name)
        runs = search.model.runs
        left = runs.mean(search.steps[0].state.residual[0])
        free = [f.rms for f in made[1].studies[0].formulas if f]
        named = tuple(e["name"] for e in found.to_dict()["effects"])
        error, least = runs.rmse(left), float(np.sqrt(np.mean(np.square(free))))
        yield FormOf(name, error, least, found.verdict, named)
