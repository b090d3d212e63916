# SPDX-License-Identifier: Apache-2.0
"""Sessions on campaigns of the third tire, noise and scatter included, without files."""

from __future__ import annotations

import numpy as np

from flatplank_analysis.contact_patch.session import Session
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_sim.sealed.conditions import STEP, Run
from flatplank_validation.blind.noise import NOISES, RELATIVE, noise
from flatplank_validation.blind.third import DESIGNS
from flatplank_validation.blind.third_world import ThirdWorld
from flatplank_validation.blind.worlds import Scatter


def tables(
    design: str,
    seed: int,
    scatter: float = 0.0,
    world=ThirdWorld,
    designs=DESIGNS,
    **hidden: float,
) -> list[MeasurementTable]:
    """All runs of a campaign of a world in random order; `hidden`: sizes by name."""
    random = np.random.default_rng(seed)
    made = world.drawn(random)
    pairs = [(s, start) for s in designs[design] for start in (1, 2, 3)]
    runs = [Run(*pairs[which], i) for i, which in enumerate(random.permutation(len(pairs)))]
    columns = made.run(runs, hidden, random, Scatter.drawn(len(runs), scatter, random))
    out = []
    for c, run in zip(columns, runs, strict=True):
        for name, share in RELATIVE.items():
            c[name] = c[name] + noise(NOISES["usual"], len(c["time"]), 0.05, random, share)
        s = run.setting
        info = RunRecord(
            file=f"run_{run.index:02d}.parquet", tire="THIRD", kappa=s.kappa, fz=s.fz,
            pressure=s.pressure, alpha_deg=s.alpha_deg, gamma_deg=s.gamma_deg, start=run.start,
            run_index=run.index, effective_rolling_radius=made.radius, step_position=STEP,
        )  # fmt: skip
        shown = ("time", "plank_position", "wheel_angle", *RELATIVE)
        out.append(MeasurementTable({n: c[n] for n in shown}, info))
    return out


def session(design: str, seed: int, **given) -> Session:
    """A session on such a campaign."""
    return Session.of_tables(tables(design, seed, **given))
