# SPDX-License-Identifier: Apache-2.0
"""What `propose` makes of causes that are in no library, and of series with nothing hidden."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from flatplank_analysis.effects.grammar.sentence import Sentence
from flatplank_analysis.proposal.propose import propose
from flatplank_analysis.slip_sweeps.session import SweepSession
from flatplank_validation.sweep_sets.brush import BASE, Plan, sweeps, text_of
from flatplank_validation.sweep_sets.sets import NULLS, OUTSIDE, cases, cases_outside

MORE = 2000
"""numerical: between the seeds of two lists"""


@dataclass(frozen=True)
class ProposalOf:
    """The proposal for one series."""

    noise: float
    """[N]"""
    hidden: str
    """field of `Brush`; empty: nothing"""
    proposed: str
    """the sentence; empty: nothing"""
    right: bool
    before: float
    """error [N]; 0 without a proposal"""
    after: float


def proposals(folder: Path, seed: int) -> Iterator[ProposalOf]:
    """Twenty series with a cause of no library, then the twenty of this seed with none."""
    for case in [*cases_outside(seed), *islice(cases(seed), NULLS)]:
        path = folder / f"{case.hidden or 'nothing'}_{case.number}.csv"
        columns = sweeps(case.brush, Plan(), seed=MORE * seed + case.number)
        path.write_text(text_of(columns), encoding="utf-8")
        made = propose(SweepSession.of_file(str(path), str(BASE)))
        numbers = made.numbers or {"rmse_before": 0.0, "rmse": 0.0}
        words = made.sentence.words() if made.sentence else ""
        right = is_right(made.sentence, case.hidden)
        errors = float(numbers["rmse_before"]), float(numbers["rmse"])
        yield ProposalOf(case.brush.noise, case.hidden, words, right, *errors)


def is_right(sentence: Sentence | None, hidden: str) -> bool:
    """Whether a sentence has family and coordinate of what is hidden; none for nothing."""
    if sentence is None or not hidden:
        return sentence is None and not hidden
    family, coordinates, _ = OUTSIDE[hidden]
    site = sentence.site
    over = {site.coordinate.name, *site.coordinate.alias}
    return site.hook.family == family and bool(over & set(coordinates))


def proposal_rows(found: Iterable[ProposalOf]) -> list[tuple[str, ...]]:
    """A line per series, after the header."""
    header: tuple[str, ...] = (
        "noise [N]", "hidden", "right", "before [N]", "after [N]", "proposed",
    )  # fmt: skip
    return [header] + [
        (
            f"{p.noise:.1f}", p.hidden or "-", "yes" if p.right else "no", f"{p.before:.1f}",
            f"{p.after:.1f}", p.proposed or "-",
        )
        for p in found
    ]  # fmt: skip
