# SPDX-License-Identifier: Apache-2.0
"""The run that would tell two effects apart (DISCOVERY 12)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from flatplank_analysis.discovery.fit import Fit, Term
from flatplank_analysis.discovery.gram import solve
from flatplank_analysis.discovery.model import Lane, Model
from flatplank_analysis.discovery.screen import Screened, settings_of
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
    each = [_Pair(search, i, name) for i, name in pairs]
    scores = [min(pair.gain(plan.model) for pair in each) for plan in plans]
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


class _Pair:
    """An effect and a rival of the size that imitates it best in the runs that are there."""

    def __init__(self, search: Search, index: int, rival: str) -> None:
        last = search.last
        state = last.state
        self.fit = state.fit
        self.place = len(self.fit.terms) - len(last.found) + index
        self.weight = np.array([1.0 / f.floor for f in state.floors])[:, None, None]
        known = settings_of(search.steps[0].screen, rival)
        self.term = None
        if known:
            self.term = _best_size(state.model, self.fit, self.place, known[0], self.weight)
            self.old = _gram(_columns(state.model, self.fit, self.place, self.term) * self.weight)

    def gain(self, planned: Model) -> float:
        """What a planned run adds to the separation."""
        if self.term is None:
            return 0.0
        new = _gram(_columns(planned, self.fit, self.place, self.term) * self.weight)
        return _lambda(self.old + new) - _lambda(self.old)


def _best_size(model: Model, fit: Fit, place: int, rival: Screened, weight: np.ndarray) -> Term:
    """The rival at the size that imitates the effect best in the runs that are there."""
    best = 1.0
    step = np.ones(len(rival.sizes)) if not np.any(rival.sizes) else np.abs(rival.sizes)
    step = step * np.where(rival.sizes < 0.0, -1.0, 1.0)
    for spread in (
        np.geomspace(0.3, 6.0, 13),
        np.linspace(0.9, 1.1, 9),
        np.linspace(0.98, 1.02, 9),
    ):
        tries = [term_of(rival.candidate, step * best * s) for s in spread]
        mine, others = _contributions(model, fit, place, tries)
        miss = [float(np.sum(((mine - o) * weight) ** 2)) for o in others]
        best *= float(spread[int(np.argmin(miss))])
    return term_of(rival.candidate, step * best)


def _contributions(
    model: Model, fit: Fit, place: int, tries: Sequence[Term]
) -> tuple[np.ndarray, np.ndarray]:
    """What the effect adds to the model without it, and what each rival in its place adds."""
    own = fit.lane()
    effect, _ = own.effects[place]

    def lane(which, values) -> Lane:
        changed = list(own.effects)
        changed[place] = (which, values)
        return Lane(own.base, tuple(changed))

    lanes = [own, lane(effect, effect.null_values())]
    out = model.predict(lanes + [lane(t.effect, t.values) for t in tries])
    return out[0] - out[1], out[2:] - out[1]


def _columns(model: Model, fit: Fit, place: int, term: Term) -> np.ndarray:
    """Base columns, the effect's contribution, the rival's, predicted afresh."""
    own = fit.lane()
    lanes = [own]
    steps = [p for p in model.parameters if p.screen]
    at = {p.name: i for i, p in enumerate(model.parameters)}
    for p in steps:
        moved = own.base.copy()
        moved[at[p.name]] += 1e-3 * p.screen
        lanes.append(Lane(moved, own.effects))
    out = model.predict(lanes)
    mine, rivals = _contributions(model, fit, place, [term])
    return np.concatenate([(out[1:] - out[0]) * 1e3, mine[None], rivals])


def _gram(columns: np.ndarray) -> np.ndarray:
    flat = columns.reshape(len(columns), -1)
    # neighbouring nodes are not independent: a tenth of them counts
    return 0.1 * flat @ flat.T


def _lambda(products: np.ndarray) -> float:
    """Information on the effect (size one) that the base and the rival cannot imitate."""
    rest = [*range(len(products) - 2), len(products) - 1]
    cross = products[rest, -2]
    return float(products[-2, -2] - cross @ solve(products[np.ix_(rest, rest)], cross)[0])
