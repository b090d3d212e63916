# SPDX-License-Identifier: Apache-2.0
"""Compares proposals and rival methods on the same campaigns: whose force equals the hidden one?

Inside: the runs of the campaign, slips to 5 %. Outside: new runs of the same machine at 8 %.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np

from flatplank_analysis.contact_patch.data import from_tables
from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.contact_patch.tire_runs import TireRuns, coordinates_of
from flatplank_analysis.discovery.model import ParameterSet
from flatplank_analysis.effects.grammar.modulators import BY_NAME
from flatplank_analysis.effects.grammar.shapes.base import Span
from flatplank_analysis.proposal.propose import propose_from_diagnosis
from flatplank_analysis.proposal.search import RefittedSentence
from flatplank_analysis.proposal.sites import varying_coordinates
from flatplank_data.table import MeasurementTable
from flatplank_sim.sealed.conditions import Run, Setting
from flatplank_validation.blind.journal import read
from flatplank_validation.blind.noise import NOISES
from flatplank_validation.blind.plan import runs_of
from flatplank_validation.blind.worlds import WORLDS, Scatter
from flatplank_validation.proposed import cases as kit
from flatplank_validation.proposed.forces import FORCES
from flatplank_validation.proposed.rivals import RIVALS, ROWS, SIDES, Inputs

OURS = "flatplank propose"
OUTSIDE = tuple(Setting(k) for k in (-0.08, 0.08))
AGAIN = 2
"""number of new runs per setting"""


@dataclass(frozen=True)
class MeasuredRuns:
    """Runs and the force hidden in them."""

    tables: list[MeasurementTable]
    force: list[np.ndarray]
    """force of each run, one value per sample of the table"""


def told(case: kit.Case, seed: int) -> tuple[MeasuredRuns, MeasuredRuns, dict[str, Any]]:
    """Runs of a campaign, new runs outside its slips, and the right answer."""
    random = np.random.default_rng((seed, crc32(case.key.encode())))
    world = WORLDS[case.world](random)
    inside = runs_of(case.design, random)
    scatter = Scatter.drawn(len(inside), case.scatter, random)
    settings = [(s, start) for s in OUTSIDE for start in range(1, AGAIN + 1)]
    outside = [Run(*pair, len(inside) + i) for i, pair in enumerate(settings)]
    change, truth = FORCES[case.name].make(kit.size_of(case, seed), kit._drawn(case, seed))
    out = []
    for runs, own in ((inside, scatter), (outside, Scatter.none(outside[-1].index + 1))):
        tables, forces = [], []
        for columns, run in zip(world.run(runs, {}, random, own), runs, strict=True):
            changed = dict(change(columns, run))
            forces.append(changed["fx"] - columns["fx"])
            tables.append(kit._table(changed, run, world.radius, NOISES[case.noise], random))
        out.append(MeasuredRuns(tables, forces))
    return out[0], out[1], truth.to_dict()


def inputs(data: TireRuns, spans: Mapping[str, Span]) -> Inputs:
    """Coordinates and modulators of the runs, as defined by the campaign."""
    known = coordinates_of(data)
    return Inputs(
        {n: np.ravel(known[n].values) for n in spans},
        {n: s.kind for n, s in spans.items()},
        {s: np.ravel(BY_NAME[s].values(data)) for s in SIDES},
    )


def at_nodes(data: TireRuns, told: MeasuredRuns) -> np.ndarray:
    """The hidden force (runs, samples) at the nodes of the analysis."""
    out = []
    for position, table, force in zip(data.position, told.tables, told.force, strict=True):
        x = np.maximum.accumulate(table["plank_position"] - table["plank_position"][0])
        keep = np.concatenate([[True], np.diff(x) > 0.0])
        out.append(np.interp(position, x[keep], force[keep]))
    return np.stack(out)


def ours(model: TireModel, best: RefittedSentence) -> np.ndarray:
    """The force of a proposal in the runs of a model."""
    fit = best.weighed.fit
    effects = tuple((t.effect, t.values) for t in fit.terms)
    sets = [ParameterSet(fit.base, effects), ParameterSet(fit.base, effects[:-1])]
    predicted = model.predict(sets)[:, 0]
    return predicted[0] - predicted[1]


def error(claim: np.ndarray, truth: np.ndarray) -> float:
    """Error of a claimed force over the size of the true one; a constant belongs to the base
    model."""
    level = truth - truth.mean()
    off = claim - claim.mean() - level
    size = float(np.sqrt(np.mean(level**2)))
    return float(min(np.sqrt(np.mean(off**2)) / max(size, 1e-12), 1e6))


def compare(case: kit.Case, seed: int) -> dict[str, Any]:
    """Errors and statements of all methods on one campaign."""
    inside, outside, truth = told(case, seed)
    session, new = Session.of_tables(inside.tables), from_tables(outside.tables)
    data = session.data
    began = time.process_time()
    result = session.diagnose()
    shared = time.process_time() - began
    assert result.search is not None
    rest = np.ravel(result.search.last.state.residual[0])
    forces = [at_nodes(d, t).ravel() for d, t in ((data, inside), (new, outside))]
    began = time.process_time()
    best = found.best if (found := propose_from_diagnosis(session, result).outcome) else None
    said: dict[str, Any] = {}
    if best:
        model = TireModel(new)
        model.take_references(session.model)
        claims = [ours(m, best).ravel() for m in (session.model, model)]
        site = best.sentence.site
        said[OURS] = _line(
            claims, forces, (site.coordinate.name,), best.sentence.shape.name, truth
        )
    else:
        said[OURS] = {"said": False}
    said[OURS]["seconds"] = time.process_time() - began
    spans = {p.name: p.span for p in varying_coordinates(data) if p.name}
    seen, beyond = inputs(data, spans), inputs(new, spans)
    few = _thinned(seen, rest.size)
    for name, rival in RIVALS.items():
        began = time.process_time()
        claim = rival(few, rest[:: _every(rest.size)])
        claims = [claim.force(x) for x in (seen, beyond)]
        said[name] = _line(claims, forces, claim.coordinates, claim.shape, truth)
        said[name]["seconds"] = time.process_time() - began
    return {"key": case.key, "seed": seed, "answer": truth, "diagnose": shared, "said": said}


def _every(size: int) -> int:
    return max(1, size // ROWS)


def _thinned(x: Inputs, size: int) -> Inputs:
    step = _every(size)
    return Inputs(
        {n: v[::step] for n, v in x.values.items()}, x.kinds,
        {n: v[::step] for n, v in x.sides.items()},
    )  # fmt: skip


def _line(
    claims: Sequence[np.ndarray], forces: Sequence[np.ndarray], coordinates: Sequence[str],
    shape: str, truth: Mapping[str, Any],
) -> dict[str, Any]:  # fmt: skip
    inner, outer = (error(c, f) for c, f in zip(claims, forces, strict=True))
    return {
        "said": True, "inside": inner, "outside": outer, "coordinates": list(coordinates),
        "coordinate": bool(coordinates) and set(coordinates) <= set(truth["coordinates"]),
        "shape": shape, "form": shape in truth["shapes"],
    }  # fmt: skip


def side_by_side(
    seed: int, count: int, path: Path, run: bool, progress: Callable[[int, int, str], None]
) -> list[dict[str, Any]]:
    """Compare the first forces in the list with 15 runs; uses existing entries of the journal."""
    chosen = [c for c in kit.full(seed) if c.group == "force" and c.design == "small"][:count]
    known = {e["key"]: e for e in read(path) if e["seed"] == seed}
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", encoding="utf-8") as stream:
        for i, case in enumerate(chosen):
            if case.key in known or not run:
                continue
            known[case.key] = compare(case, seed)
            stream.write(json.dumps(known[case.key]) + "\n")
            stream.flush()
            progress(i + 1, len(chosen), case.key)
    return [known[c.key] for c in chosen if c.key in known]
