# SPDX-License-Identifier: Apache-2.0
"""Faults on the twin, one, two and three at a time."""

from __future__ import annotations

import itertools
import random
from collections.abc import Iterable
from contextlib import nullcontext

from flatplank_analysis.parallel import Serial, worker_pool
from flatplank_hw.drive import DriveParameters
from flatplank_validation.trust.faults import CLOCK, FAULTS
from flatplank_validation.trust.registry import Options, Tally, row
from flatplank_validation.trust.scenario import MOTIONS, Scenario, judge, most_s

BAR = f"the wheel turns uncommanded for more than {most_s(DriveParameters()):.2f} s"
NIGHT = 20_000
"""scenarios with three faults of a night"""
APART = 25
"""cycles from one fault of a pair to the next: 0.1 s, before the slower rules notice the first"""
CHUNK = 20


def pairs(motion: str) -> list[Scenario]:
    """All pairs of different faults."""
    both = itertools.combinations(FAULTS, 2)
    return [Scenario(motion, ((a, 5), (b, APART))) for a, b in both]


def triples(count: int, seed: int) -> list[Scenario]:
    """Drawn scenarios of three faults, up to 0.5 s apart."""
    draw = random.Random(seed)
    names, motions = list(FAULTS), list(MOTIONS)
    return [
        Scenario(
            draw.choice(motions),
            tuple((name, draw.randrange(125)) for name in draw.sample(names, 3)),
        )
        for _ in range(count)
    ]


def tally(scenarios: Iterable[Scenario], o: Options) -> Tally:
    """Judge scenarios, in parallel."""
    todo = list(scenarios)
    parts = [todo[i : i + CHUNK] for i in range(0, len(todo), CHUNK)]
    out = Tally()
    pool = worker_pool(min(o.jobs, len(parts))) if o.jobs > 1 else nullcontext(Serial())
    with pool as workers:
        for found in workers.map(judge, parts):
            for text in found:
                out.add(text)
            o.progress(out.many, len(todo))
    return out


def _share(scenarios: list[Scenario], o: Options) -> list[Scenario]:
    return random.Random(o.seed).sample(scenarios, o.count(len(scenarios)))


@row("single", "single faults while slipping, rolling freely and hanging", BAR)
def single(o: Options) -> Tally:
    """Every fault in every motion."""
    return tally([Scenario(m, ((name, 5),)) for m in MOTIONS for name in FAULTS], o)


@row("pairs", "all pairs of the same faults", BAR)
def all_pairs(o: Options) -> Tally:
    """Every pair in every motion."""
    return tally(_share([s for motion in MOTIONS for s in pairs(motion)], o), o)


@row("clock", "a clock that jumps, alone and before each of the same faults", BAR)
def clock(o: Options) -> Tally:
    """Every jump in every motion."""
    alone = [Scenario(m, ((jump, 5),)) for m in MOTIONS for jump in CLOCK]
    both = itertools.product(MOTIONS, CLOCK, FAULTS)
    return tally(
        alone + _share([Scenario(m, ((j, 5), (name, APART))) for m, j, name in both], o), o
    )


@row("triples", "drawn scenarios of three faults", BAR)
def drawn_triples(o: Options) -> Tally:
    """Drawn by the seed."""
    return tally(triples(o.count(NIGHT), o.seed), o)
