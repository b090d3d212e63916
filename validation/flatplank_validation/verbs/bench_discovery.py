# SPDX-License-Identifier: Apache-2.0
"""Speed and memory of the search and of a proposal."""

from __future__ import annotations

import json
import resource
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from flatplank_analysis.contact_patch.data import from_tables
from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery.model import ParameterSet
from flatplank_analysis.discovery.state import start_base
from flatplank_analysis.effects.registry import library
from flatplank_analysis.parallel import worker_pool
from flatplank_analysis.proposal.propose import propose
from flatplank_data.arguments import Parser, add_json
from flatplank_data.campaign import Campaign
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_sim.sealed.conditions import STEP
from flatplank_validation.blind.noise import NOISES, RELATIVE, noise
from flatplank_validation.blind.nulls import lines_of_form, lines_of_nulls, lines_of_unrepeated
from flatplank_validation.blind.plan import runs_of
from flatplank_validation.blind.worlds import Scatter, SecondWorld
from flatplank_validation.proposed.cases import Case, make

SIZES = {"drive_backlash": 8e-4, "parasitic_force": 80.0, "wear": 0.2}
"""hidden effect -> size, in this order, in the second tire of the blind kit; far above the
detectable sizes"""
WANTED = {0: 6.0, 1: 15.0, 2: None, 3: 40.0}
"""number of hidden effects -> limit of the total time [s]"""
RANKING, SCREENING, MEMORY = 5.0, 3.0, 1024.0
"""limits: time until the first ranking [s]; screening of all effects, over the time of a base fit;
memory [MiB]"""
PROPOSAL, PROPOSAL_MEMORY = 60.0, 1536.0
"""limits of a proposal, with the diagnosis that comes first: time [s]; memory [MiB]"""
SEED, SCATTER = 5, 0.01


def tables_of(count: int, design: str = "plain") -> list[MeasurementTable]:
    """Make a campaign with the first `count` effects hidden."""
    random = np.random.default_rng(SEED)
    world = SecondWorld.drawn(random)
    runs = runs_of(design, random)
    scatter = Scatter.drawn(len(runs), SCATTER, random)
    columns = world.run(runs, dict(list(SIZES.items())[:count]), random, scatter)
    out = []
    for c, run in zip(columns, runs, strict=True):
        dt = float(c["time"][1] - c["time"][0])
        shown = {n: c[n] for n in ("time", "plank_position", "wheel_angle")}
        for name, share in RELATIVE.items():
            shown[name] = c[name] + noise(NOISES["usual"], len(c["time"]), dt, random, share)
        info = RunRecord(
            file=f"bench_{run.index:02d}.parquet", tire="BENCH", kappa=run.setting.kappa,
            fz=run.setting.fz, pressure=run.setting.pressure, start=run.start,
            run_index=run.index, effective_rolling_radius=world.radius, step_position=STEP,
        )  # fmt: skip
        out.append(MeasurementTable(shown, info))
    return out


def diagnose(count: int, design: str = "plain") -> dict[str, Any]:
    """Times [s] and peak memory [MiB] of one search, with kernels compiled before."""
    data = from_tables(tables_of(count, design))
    model = TireModel(data)
    model.predict([ParameterSet(start_base(model))])
    result = Session(Campaign("bench", []), data, model, library()).diagnose()
    search = result.drawable("bench")
    return {
        "runs": data.runs.runs,
        "first_ranking": search.first_ranking,
        "screening": search.first_ranking / search.base_fit - 1.0,
        "seconds": result.seconds,
        "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
        "verdict": result.verdict,
        "named": [f.decision.term.effect.identifier for f in result.found],
    }


def proposal() -> dict[str, Any]:
    """Time [s] and peak memory [MiB] of a proposal for a force that is in no library, with kernels
    compiled before."""
    made = make(Case("force", "second", "bump", design="plain"), SEED)
    assert made is not None  # these runs show a bump
    tables, _ = made
    session = Session.of_tables(tables, library())
    session.model.predict([ParameterSet(start_base(session.model))])
    began = time.perf_counter()
    found = propose(session)
    return {
        "runs": len(tables),
        "seconds": time.perf_counter() - began,
        "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
        "verdict": found.verdict,
    }


def measure(work: Callable[..., dict[str, Any]], *given: Any) -> dict[str, Any]:
    """Measure in a separate process, for its memory alone."""
    with worker_pool(1) as pool:
        return pool.submit(work, *given).result()


def line_of(count: int, found: dict[str, Any]) -> str:
    """One row of the table, each number with its limit."""
    limit = WANTED[count]
    whole = f"{found['seconds']:5.1f} s ({f'<= {limit:.0f}' if limit else 'no limit'})"
    return (
        f"{count} hidden, {found['runs']} runs: first ranking {found['first_ranking']:4.1f} s "
        f"(<= {RANKING:.0f}), screening {found['screening']:.1f} base fits (<= {SCREENING:.0f}), "
        f"all {whole}, memory {found['memory']:4.0f} MiB (<= {MEMORY:.0f}); "
        f"{found['verdict']}: {', '.join(found['named']) or '-'}"
    )


def line_of_proposal(found: dict[str, Any]) -> str:
    """The last row, each number with its limit."""
    return (
        f"propose, {found['runs']} runs: {found['seconds']:4.1f} s (<= {PROPOSAL:.0f}), "
        f"memory {found['memory']:4.0f} MiB (<= {PROPOSAL_MEMORY:.0f}); {found['verdict']}"
    )


def kept(count: int, found: dict[str, Any]) -> bool:
    """True when every number is within its limit."""
    limit = WANTED[count]
    return (
        found["first_ranking"] <= RANKING
        and found["screening"] <= SCREENING
        and found["memory"] <= MEMORY
        and (limit is None or found["seconds"] <= limit)
    )


def main(argv: list[str]) -> int:
    """Exit code 0: all numbers are within their limits; 1: not."""
    p = Parser(prog="flatplank bench-discovery", description=__doc__)
    add_json(p)
    p.add_argument(
        "--nulls",
        type=int,
        metavar="N",
        help="instead: N campaigns of the plant with nothing "
        "hidden at each of five noise levels, how many are at the floor",
    )
    p.add_argument(
        "--unrepeated",
        type=int,
        metavar="N",
        help="instead: N campaigns without repeats at each noise level, tires of the blind kit, "
        "nothing hidden: how often an effect is named",
    )
    p.add_argument(
        "--form",
        type=int,
        metavar="N",
        help="instead: how far the base is off N tires of every "
        "world, the form band of the decision",
    )
    o = p.parse_args(argv)
    printed = ((o.nulls, lines_of_nulls), (o.unrepeated, lines_of_unrepeated),
               (o.form, lines_of_form))  # fmt: skip
    for count, lines in printed:
        if count:
            for line in lines(count):
                print(line, flush=True)
            return 0
    found = {}
    for count in WANTED:
        found[count] = measure(diagnose, count)
        if not o.json:
            print(line_of(count, found[count]), flush=True)
    last = measure(proposal)
    if o.json:
        every = {"hidden": found, "proposal": last}
        print(json.dumps({"format": "flatplank-bench-discovery/1"} | every, indent=1))
    else:
        print(line_of_proposal(last))
    within = last["seconds"] <= PROPOSAL and last["memory"] <= PROPOSAL_MEMORY
    return 0 if within and all(kept(count, one) for count, one in found.items()) else 1
