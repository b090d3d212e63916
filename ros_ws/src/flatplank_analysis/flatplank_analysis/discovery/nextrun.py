# SPDX-License-Identifier: Apache-2.0
"""The planned run that best separates two effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from flatplank_analysis.discovery.fit import Fit, Term, scale_of
from flatplank_analysis.discovery.gram import solve
from flatplank_analysis.discovery.model import Model, ParameterSet
from flatplank_analysis.discovery.state import State, channel_weights
from flatplank_analysis.discovery.steps import Search

NEEDED = 12.0
"""separation (see `Pair.separation`) at which two effects count as distinguished"""


class PlannedRun(Protocol):
    """A run that the bench can make."""

    @property
    def text(self) -> str: ...

    @property
    def settings(self) -> dict[str, Any]: ...

    @property
    def model(self) -> Model: ...


def next_run(search: Search, plans: Sequence[PlannedRun]) -> dict[str, Any]:
    """The planned run that most increases the least separation of all indistinguishable pairs, as
    the JSON of a diagnosis has it; {} without such pairs."""
    last = search.last
    pairs = [(i, r) for i, f in enumerate(last.found) for r in f.rivals if not r.excluded]
    if not pairs or not plans:
        return {}
    each = [Pair.of(search, i, rival.term) for i, rival in pairs]
    scores = [min(pair.gain(plan.model) for pair in each) for plan in plans]
    best = int(np.argmax(scores))
    gain = float(scores[best])
    names = sorted({last.found[i].decision.term.effect.identifier for i, _ in pairs})
    others = sorted({rival.name for _, rival in pairs})
    out = {"separates": [names, others], "separation_per_run": float(f"{gain:.3g}")}
    if gain < 0.5:
        return out | {"what": "no run of the bench tells these apart; check on the machine"}
    repeats = int(np.clip(np.ceil(NEEDED / gain), 1, 30))
    return out | {"what": plans[best].text, "settings": plans[best].settings, "repeats": repeats}


class Pair:
    """An effect of a fit and its alternative: a rival in its place, or the model without it."""

    def __init__(
        self, model: Model, fit: Fit, place: int, rival: Term | None, weight: np.ndarray
    ) -> None:
        """weight (channels, 1, 1): weight of each channel."""
        self.fit, self.place, self.term, self.weight = fit, place, rival, weight
        self.old = self.products(model)

    @classmethod
    def of(cls, search: Search, index: int, rival: Term | None) -> Pair:
        """Effect `index` of those that were found, at the end of a search."""
        last = search.last
        fit = last.state.fit
        place = len(fit.terms) - len(last.found) + index
        return cls(last.state.model, fit, place, rival, weight_of(last.state))

    def products(self, model: Model) -> np.ndarray:
        """Products of the columns of base and rival, the effect last, for the model's runs."""
        return products_of(_columns(model, self.fit, self.place, self.term) * self.weight)

    def separation(self, *more: np.ndarray) -> float:
        """Weighted sum of squares of the effect's contribution that its alternative and the base
        cannot imitate, in the runs of the fit and in more runs, given as products."""
        return _separation(self.old + sum(more))

    def gain(self, planned: Model) -> float:
        """Increase of the separation by a planned run."""
        return self.separation(self.products(planned)) - self.separation()


def weight_of(state: State) -> np.ndarray:
    """Weight of every channel by its floor (channels, 1, 1)."""
    return channel_weights(state.model, [f.floor for f in state.floors])


def _contributions(
    model: Model, fit: Fit, place: int, tries: Sequence[Term]
) -> tuple[np.ndarray, np.ndarray]:
    """Contribution of the effect to the prediction, and that of each rival in its place."""
    own = fit.parameter_set()
    effect, _ = own.effects[place]

    def parameter_set(which, values) -> ParameterSet:
        changed = list(own.effects)
        changed[place] = (which, values)
        return ParameterSet(own.base, tuple(changed))

    sets = [own, parameter_set(effect, effect.null_values())]
    out = model.predict(sets + [parameter_set(t.effect, t.values) for t in tries])
    return out[0] - out[1], out[2:] - out[1]


def moved_bases(model: Model, own: ParameterSet) -> list[ParameterSet]:
    """One set per base parameter, with that parameter moved by a thousandth of its scale."""
    out = []
    for i, p in enumerate(model.parameters):
        if p.screen:
            moved = own.base.copy()
            moved[i] += 1e-3 * p.screen
            out.append(ParameterSet(moved, own.effects))
    return out


def _columns(model: Model, fit: Fit, place: int, term: Term | None) -> np.ndarray:
    """Base columns, the rival's contribution, the changes by its parameters (new runs would change
    them), and last the effect's contribution; all predicted for this model's runs."""
    own = fit.parameter_set()
    out = model.predict([own, *moved_bases(model, own)])
    mine, rivals = _contributions(model, fit, place, [term, *_moved(term)] if term else [])
    rivals[1:] -= rivals[:1]
    return np.concatenate([(out[1:] - out[0]) * 1e3, rivals, mine[None]])


def _moved(term: Term) -> list[Term]:
    """One term per fitted parameter, with that parameter moved by a tenth of its scale."""
    named = term.named()
    out = []
    for p in term.effect.parameters():
        if p.name not in term.fixed:
            step = 0.1 * scale_of(p)
            step = -step if named[p.name] + step > p.upper else step
            values = term.effect.vector(named | {p.name: named[p.name] + step})
            out.append(replace(term, values=values))
    return out


def products_of(columns: np.ndarray) -> np.ndarray:
    """Products of weighted columns (n, channels, runs, samples) over all samples."""
    flat = columns.reshape(len(columns), -1)
    # neighbouring nodes are not independent: the factor counts a tenth of them
    return 0.1 * flat @ flat.T


def _separation(products: np.ndarray) -> float:
    """The product of the last column with itself, with all other columns projected out."""
    cross = products[:-1, -1]
    return float(products[-1, -1] - cross @ solve(products[:-1, :-1], cross)[0])
