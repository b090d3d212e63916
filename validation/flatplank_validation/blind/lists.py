# SPDX-License-Identifier: Apache-2.0
"""The list of blind campaigns.

The list depends on the seed: another seed gives other noise and scatter for every effect, and
another order. So a list can be held out, like a tire.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache

import numpy as np

from flatplank_sim.sealed.menu import OUTSIDE
from flatplank_validation.blind.cases import Case
from flatplank_validation.blind.menu import MENU, PAIRS
from flatplank_validation.blind.noise import NOISES
from flatplank_validation.blind.third_world import HIDES
from flatplank_validation.blind.worlds import COMBINED, WORLDS

SCATTERS = (0.0, 0.01, 0.02, 0.03)
"""scatter of grip and tread stiffness from run to run, in every class of campaign [-]"""
PLAIN = tuple(world for world in WORLDS if world not in COMBINED)
WIDE = ("combined", "wide_loads")
"""designs with side slip, and with loads from 0.5 to 1.5 of nominal"""
USUAL = ("usual", "quiet", "coloured", "trending", "loud", "measured")
"""noises of campaigns with a hidden effect"""
NULLS, TIMES = 6, (("x", 1.0, 2), ("x", 2.0, 2), ("x", 4.0, 1), ("c", 1.5, 1), ("c", 3.0, 1))
"""number of null campaigns per noise and world; sizes of hidden effects: (base, factor, number)"""


def full(seed: int, small: bool = False) -> list[Case]:
    """All cases of a seed, in mixed order, so that any first part is a representative sample."""
    if small:
        return list(_small())
    draw = np.random.default_rng((seed, 0))
    groups = (_none(draw), _singles(draw), _pairs(draw), _outside(draw), _combined(draw))
    lists = [list(group) for group in groups]
    for cases in lists:
        draw.shuffle(cases)
    # spread each list evenly over the whole
    places = [(i + 0.5) / len(cases) for cases in lists for i in range(len(cases))]
    everything = [c for cases in lists for c in cases]
    return [everything[i] for i in np.argsort(places, kind="stable")]


def five_slips(seed: int) -> list[Case]:
    """The straight-ahead campaigns of the list at one load, each with the runs of five slips:
    half of the time."""
    return [replace(case, design="small") for case in full(seed) if case.design == "plain"]


def _small() -> Iterator[Case]:
    yield Case("none", "second", design="small")
    yield Case("none", "plant", design="small", scatter=0.03, noise="coloured")
    for world, name in (("second", "drive_backlash"), ("plant", "parasitic_force")):
        yield Case("single", world, (name,), 3.0, design="small", rung="c")
    yield Case("outside", "second", ("bump",), 3.0, design="small", rung="c")


def _none(draw: np.random.Generator) -> Iterator[Case]:
    for world in PLAIN:
        for kind in NOISES:
            for number in range(NULLS):
                scatter = SCATTERS[number % len(SCATTERS)]
                yield Case("none", world, (), 1.0, kind, scatter, number=number)
    for world in COMBINED:
        for design in WIDE:
            for number in range(NULLS):
                kind, scatter = _circumstances(draw)
                yield Case("none", world, (), 1.0, kind, scatter, design, number)


def _singles(draw: np.random.Generator) -> Iterator[Case]:
    for name, item in MENU.items():
        for world in _worlds(name):
            # effects that are present or absent have one size only
            for rung, factor, count in TIMES if item.least < item.most else TIMES[1:2]:
                for number in range(count):
                    kind, scatter = _circumstances(draw)
                    yield Case(
                        "single", world, (name,), factor, kind, scatter, item.design, number, rung
                    )


def _pairs(draw: np.random.Generator) -> Iterator[Case]:
    for pair in PAIRS:
        for world in _worlds(*pair):
            for number in range(2):
                kind, scatter = _circumstances(draw)
                yield Case("pair", world, pair, 3.0, kind, scatter, number=number)


def _outside(draw: np.random.Generator) -> Iterator[Case]:
    for name in OUTSIDE:
        for world in PLAIN:
            for rung, factor, count in TIMES:
                for number in range(count):
                    kind, scatter = _circumstances(draw)
                    yield Case(
                        "outside", world, (name,), factor, kind, scatter, number=number, rung=rung
                    )


def _combined(draw: np.random.Generator) -> Iterator[Case]:
    for world in COMBINED:
        for name in HIDES:
            for design in WIDE:
                for rung, factor, count in TIMES[1:]:
                    for number in range(count):
                        kind, scatter = _circumstances(draw)
                        yield Case(
                            "combined", world, (name,), factor, kind, scatter, design, number, rung
                        )


def _worlds(*names: str) -> list[str]:
    return [w for w in PLAIN if all(_has(w, n) for n in names)]


@lru_cache(maxsize=1024)
def _has(world: str, name: str) -> bool:
    return WORLDS[world](None).has(name)


def _circumstances(draw: np.random.Generator) -> tuple[str, float]:
    return str(draw.choice(USUAL)), float(draw.choice(SCATTERS))
