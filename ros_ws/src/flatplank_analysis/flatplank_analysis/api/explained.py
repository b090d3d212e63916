# SPDX-License-Identifier: Apache-2.0
"""Diagnosis of what a model of any machine lacks, and the model with an effect more."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import pandas as pd

from flatplank_analysis.api.diagnosis import Diagnosed
from flatplank_analysis.cli import loop
from flatplank_analysis.discovery import verdict
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.fit import Fit, Term
from flatplank_analysis.discovery.model import Model
from flatplank_analysis.discovery.opening import Options
from flatplank_analysis.discovery.screen import settings_of
from flatplank_analysis.discovery.state import term_of
from flatplank_analysis.inference.search import run_search
from flatplank_data.errors import FlatplankError
from flatplank_data.names import nearest_hint

NextRun = Callable[[verdict.Diagnosis], dict[str, Any]]
"""diagnosis -> its `next_run`"""


def explain(
    model: Model, effects: Sequence[type[Effect]], next_run: NextRun = lambda _: {}
) -> Explained:
    """Search for the effects that your own model lacks, with the floor and the verdict.

    model: a `Motion` with its records, or anything that predicts (docs/explanation/engine.md);
    next_run: what to measure next, by the diagnosis.
    """
    return _explained(model, list(effects), (), next_run)


class Explained(Diagnosed):
    """A diagnosis of any machine; `add` puts an effect into its model."""

    def __init__(
        self, result: verdict.Diagnosis, model: Model, terms: Sequence[Term], next_run: NextRun
    ) -> None:
        super().__init__(result, type(model).__name__, ())
        self._next_run = next_run
        self.model, self.added = model, tuple(terms)
        """the model without effects, and the effects that were added"""

    @property
    def parameters(self) -> pd.DataFrame:
        """Fitted numbers of the base and of the effects in the model: of, name, value, unit."""
        search = self.result.drawable(self.campaign)
        return pd.DataFrame(_rows(self.model, search.last.state.fit))

    def add(self, name: str) -> Explained:
        """The diagnosis of the model with one of the effects more, everything fitted again.

        name: identifier of an effect that `explain` was given. Raises FlatplankError for another.
        """
        search = self.result.drawable(self.campaign)
        known = {e.identifier: e for e in search.effects}
        if name not in known:
            what = f"no effect '{name}'{nearest_hint(name, known)}"
            raise FlatplankError(what, "add", f"known: {', '.join(known) or 'none'}")
        found = [
            f.decision.term for f in search.last.found if f.decision.term.effect is known[name]
        ]
        seen = [term_of(i.candidate, i.sizes) for i in settings_of(search.last.screen, name)]
        if not (found or seen):
            what = f"'{name}' cannot show in these runs, or is in the model already"
            raise FlatplankError(what, "add", "measure runs that have what it needs")
        return _explained(self.model, search.effects, (*self.added, (*found, *seen)[0]),
                          self._next_run)  # fmt: skip


def _explained(
    model: Model, effects: Sequence[type[Effect]], terms: Sequence[Term], next_run: NextRun
) -> Explained:
    options = Options(progress=loop.progress, terms=tuple(terms))
    result = verdict.diagnose(run_search(model, list(effects), options))
    loop.progress_done()
    result = replace(result, campaign=False, next_run=next_run(result))
    return Explained(result, model, terms, next_run)


def _rows(model: Model, fit: Fit) -> list[dict[str, object]]:
    base = [("base", p, v) for p, v in zip(model.parameters, fit.base, strict=True)]
    pairs = [(t, p) for t in fit.terms for p in t.effect.parameters()]
    own = [(t.effect.identifier, p, t.named()[p.name]) for t, p in pairs]
    return [
        {"of": of, "name": p.name, "value": float(value), "unit": p.unit}
        for of, p, value in (*base, *own)
    ]
