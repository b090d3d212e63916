# SPDX-License-Identifier: Apache-2.0
"""The run that would tell two effects apart (DISCOVERY 12)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from flatplank_analysis.discovery.gram import solve
from flatplank_analysis.discovery.model import Lane, Model
from flatplank_analysis.discovery.screen import settings_of
from flatplank_analysis.discovery.search import Search
from flatplank_analysis.discovery.state import term_of

NEEDED = 12.0
"""separation at which two effects are told apart"""


class PlannedRun(Protocol):
    """A run that could be made."""

    text: str
    settings: dict[str, Any]
    model: Model


def next_run(search: Search, plans: Sequence[PlannedRun]) -> dict[str, Any]:
    """The planned run with the largest smallest separation of all confusable pairs."""
    last = search.last
    pairs = [(i, name) for i, f in enumerate(last.found) for name in f.alike]
    if not pairs or not plans:
        return {}
    scores = []
    for plan in plans:
        values = [_separation(search, plan, i, name) for i, name in pairs]
        scores.append(min(values))
    best = int(np.argmax(scores))
    gain = float(scores[best])
    names = sorted({last.found[i].decision.term.effect.identifier for i, _ in pairs})
    others = sorted({name for _, name in pairs})
    out = {"separates": [names, others], "separation_per_run": float(f"{gain:.3g}")}
    if gain < 0.5:
        return out | {"what": "no run of the bench tells these apart; check on the machine"}
    repeats = int(np.clip(np.ceil(NEEDED / gain), 1, 30))
    return out | {
        "what": plans[best].text,
        "settings": plans[best].settings,
        "repeats": repeats,
    }


def _separation(search: Search, plan: PlannedRun, index: int, rival: str) -> float:
    """What a planned run adds to the separation of an effect from a rival of its best size."""
    last = search.last
    state, fit = last.state, last.state.fit
    offset = len(fit.terms) - len(last.found)
    origin = search.steps[0]
    known = settings_of(origin.screen, rival)
    if not known:
        return 0.0
    term = term_of(known[0].candidate, np.ones(len(known[0].sizes)))
    own = fit.lane()
    weight = np.array([1.0 / f.floor for f in state.floors])[:, None, None]
    there = _columns(state.model, fit, own, offset + index, term)
    here = _columns(plan.model, fit, own, offset + index, term)
    old = _gram(there * weight)
    new = _gram(here * weight)
    return _lambda(old + new) - _lambda(old)


def _columns(model: Model, fit, own: Lane, index: int, term) -> np.ndarray:
    """Base columns, the effect's own amplitude, the rival's column, predicted afresh."""
    lanes = [own]
    steps = [p for p in model.parameters if p.screen]
    at = {p.name: i for i, p in enumerate(model.parameters)}
    for p in steps:
        moved = own.base.copy()
        moved[at[p.name]] += 1e-3 * p.screen
        lanes.append(Lane(moved, own.effects))
    effect, values = own.effects[index]
    named = [p.name in {q.name for q in effect.linear()} for p in effect.parameters()]
    smaller = np.where(named, effect.null_values() + 0.9 * (values - effect.null_values()), values)
    changed = list(own.effects)
    changed[index] = (effect, smaller)
    lanes.append(Lane(own.base, tuple(changed)))
    changed[index] = (effect, effect.null_values())
    nothing = Lane(own.base, tuple(changed))
    changed[index] = (term.effect, term.values)
    lanes += [nothing, Lane(own.base, tuple(changed))]
    out = model.predict(lanes)
    base = (out[1 : 1 + len(steps)] - out[0]) * 1e3
    rival = out[-1] - out[-2]
    return np.concatenate([base, 10.0 * (out[0] - out[1 + len(steps)])[None], rival[None]])


def _gram(columns: np.ndarray) -> np.ndarray:
    flat = columns.reshape(len(columns), -1)
    # neighbouring nodes are not independent: a tenth of them counts
    return 0.1 * flat @ flat.T


def _lambda(products: np.ndarray) -> float:
    """Information on the effect (size one) that the base and the rival cannot imitate."""
    rest = [*range(len(products) - 2), len(products) - 1]
    cross = products[rest, -2]
    return float(products[-2, -2] - cross @ solve(products[np.ix_(rest, rest)], cross)[0])
