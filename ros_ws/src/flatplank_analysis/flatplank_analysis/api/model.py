# SPDX-License-Identifier: Apache-2.0
"""A model of runs: fitted numbers, adding and removing effects, comparison with runs."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from flatplank_analysis.api.runs import campaign_of, figure_of, page, same_runs, warn
from flatplank_analysis.cli import loop
from flatplank_analysis.contact_patch import alternatives, comparison
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery import determined
from flatplank_analysis.discovery.modelfile import ModelFile, load_model, save_unchanged
from flatplank_analysis.discovery.steps import Step
from flatplank_analysis.effects import consent
from flatplank_data.wording import sized

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def fit(
    runs: pd.DataFrame,
    model: str | os.PathLike[str] | None = None,
    effects: Sequence[str | os.PathLike[str]] = (),
    trust: Sequence[str | os.PathLike[str]] = (),
) -> Model:
    """Fit the tire to a table of runs; `flatplank compare` does the same.

    model: a model file to start from, with its effects; effects: your own effect files; trust:
    Python effect files that may run as they are now (`flatplank_analysis.effects.consent`).
    """
    consent.give(trust)
    file = load_model(model) if model is not None else None
    own = [e.file for e in file.effects if e.file] if file else []
    session = open_session(runs, [*(os.fspath(e) for e in (*effects, *trust)), *own])
    made = Model(session, file)
    _ = made.step
    return made


def open_session(runs: pd.DataFrame, files: Sequence[str] = ()) -> Session:
    """The session of a table of runs, as the verbs open it; its problems become warnings."""
    campaign = campaign_of(runs)
    session = Session.of(campaign, files)
    warn(campaign.problems)
    return session


class Model:
    """A tire with the added effects. It is immutable: `add` returns another model."""

    def __init__(
        self,
        session: Session,
        start: ModelFile | None,
        before: Model | None = None,
        numbers: Mapping[str, Any] | None = None,
    ) -> None:
        self.session = session
        self.start = start
        """the model file that the fit starts from; None: the tire without effects"""
        self.before = before
        """the model before the last `add` or `remove`"""
        self.numbers: Mapping[str, Any] = numbers or {}
        """result of the last step as in `flatplank add --json`: size, interval, error, doubts"""

    @cached_property
    def step(self) -> Step:
        """The fit, with its floor."""
        loop.progress("fit", 0.3)
        step = self.session.fit(self.start)
        loop.progress_done()
        return step

    @property
    def file(self) -> ModelFile:
        """Content of `save`: the numbers of the fit, and their history."""
        if self.start is not None and self.start.history:
            return self.start
        start = self.start or ModelFile()
        return self.session.begun(self.session.file_of(start, self.step.state.fit), self.step)

    @property
    def effects(self) -> list[str]:
        """Identifiers of the effects in the model."""
        return [e.name for e in self.file.effects]

    @cached_property
    def parameters(self) -> pd.DataFrame:
        """Every fitted number: value, 90 % interval, and which runs determine it."""
        return pd.DataFrame(
            {
                "of": n.owner or "tire",
                "parameter": n.name,
                "value": n.value,
                "unit": n.unit,
                "low": n.interval[0],
                "high": n.interval[1],
                "determined by": n.words(),
                "remark": "at an end of its range" if n.at_bound else "",
            }
            for n in determined.numbers_of(self.step.state)
        )

    @property
    def history(self) -> pd.DataFrame:
        """Error, floor and held-out error [N] after every step."""
        kept = ("action", "effect", "rmse", "floor", "held_out")
        return pd.DataFrame([{k: step.get(k) for k in kept} for step in self.file.history])

    def add(self, effect: str) -> Model:
        """The model with one more effect, refitted; `flatplank add` does the same."""
        return self._refitted(lambda: self.session.add(self._begin, effect, self.step, None))

    def remove(self, effect: str) -> Model:
        """The model without the last instance of an effect, refitted."""
        return self._refitted(lambda: self.session.remove(self._begin, effect))

    def _refitted(self, change: Callable[[], tuple[ModelFile, Any, dict[str, Any]]]) -> Model:
        loop.progress("refit of everything", 0.3)
        file, _, numbers = change()
        loop.progress_done()
        return Model(self.session, file, self, numbers)

    def undo(self) -> Model:
        """The model before the last `add` or `remove`, with exactly the same numbers."""
        return Model(self.session, self._begin.undone())

    @property
    def _begin(self) -> ModelFile:
        """The model file that the verbs would find after saving this model."""
        return self.start or ModelFile()

    def compare(self, runs: pd.DataFrame) -> Comparison:
        """Fit the model to runs, and compare its error with the floor of their repeats."""
        if not same_runs(self.session.campaign, runs):
            session = open_session(runs, self.session.files)
            return Comparison(session, [session.fit(self.start)])
        first = self
        while first.before is not None:
            first = first.before
        steps = [self.step] if first is self else [first.step, self.step]
        return Comparison(self.session, steps)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write a model file for the verbs and for `fit(runs, model=path)`; return its path.

        FlatplankError when another program changed the file.
        """
        save_unchanged(self.file, path)
        return Path(path)

    def plot(self) -> Figure:
        """Fitted and held-out error after every step."""
        from flatplank_analysis.discovery.report import figures
        from flatplank_analysis.discovery.report import page as pages

        state = self.step.state
        steps = pages.history_steps(self.file.history)
        return figures.waterfall(steps, state.floors[0].floor, state.runs)

    def __repr__(self) -> str:
        now = self.session.numbers(self.step)
        lines = [f"model: {' + '.join(['tire', *(e.words for e in self.file.effects)])}"]
        if "size" in self.numbers:
            n = self.numbers
            lines.append(f"{self.effects[-1]}: {sized(n['size'], n['interval'], n['unit'])}")
            lines += alternatives.words(n.get("class", ()))
        lines.append(f"error of Fx {now['rmse']:.1f} N, floor {now['floor']:.1f} N")
        return "\n".join(lines + [f"doubt: {d}" for d in self.numbers.get("doubts", ())])

    def _repr_html_(self) -> str:
        return page(repr(self), [self.parameters, self.history])


class Comparison:
    """Error of a model and floor, by condition and over the coordinates.

    `numbers` is the JSON of `flatplank compare`, `print` shows its text.
    """

    def __init__(self, session: Session, steps: Sequence[Step]) -> None:
        self.steps = list(steps)
        self.numbers = comparison.numbers(session, self.steps[-1])

    @property
    def conditions(self) -> pd.DataFrame:
        """Error, floor and excess over the floor [N] of every condition."""
        return pd.DataFrame(self.numbers["conditions"])

    def plot(self, what: str = "conditions") -> Figure:
        """A figure: `conditions`, `residual`, or a coordinate of `maps`."""
        from flatplank_analysis.discovery import where
        from flatplank_analysis.discovery.report import figures

        step, runs = self.steps[-1], self.steps[-1].state.runs
        drawn = {
            "conditions": lambda: figures.conditions(self.steps),
            "residual": lambda: figures.residual(step),
        }
        maps = where.make_maps(runs, step.state.residual[0], step.state.floors[0].by_condition)
        drawn |= {m.coordinate: partial(figures.map_of, m, runs) for m in maps}
        return figure_of(drawn, what)()

    @property
    def maps(self) -> list[str]:
        """Coordinates of the residual maps, the one that explains most first."""
        return [m["coordinate"] for m in self.numbers["where"]]

    def __repr__(self) -> str:
        return comparison.text_of(self.numbers)

    def _repr_html_(self) -> str:
        return page(repr(self), figures=[self.plot()])
