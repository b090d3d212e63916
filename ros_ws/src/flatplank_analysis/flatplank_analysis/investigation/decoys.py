# SPDX-License-Identifier: Apache-2.0
"""Decoys: effects of the library in permuted conditions, for the false alarm rate.

A decoy is the column of an effect with its conditions permuted. No machine should behave like
that, so decoys that pass the tests count as false alarms. They are tried at the end of a search,
as one more step, and do not change its verdict.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any, ClassVar, cast
from zlib import crc32

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.screen import VISIBLE, ScreenResult, best_per_effect
from flatplank_analysis.discovery.state import Candidate, term_of
from flatplank_analysis.discovery.steps import Search
from flatplank_analysis.effects.base import Signal, TireEffect
from flatplank_analysis.inference.beside import Beside

REFITS = 3
"""most decoys that are refitted, the most promising ones"""
FEWEST = 3
"""least number of conditions: with two a permutation only changes the sign"""


@dataclass(frozen=True)
class Decoys:
    """Number of decoys that were tried, and names of those that passed the tests."""

    looked_at: int = 0
    accepted: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        return asdict(self) | {"accepted": list(self.accepted)}


def decoys_of(search: Search) -> Decoys:
    """Decoys of all visible effects at the end of a search, tested like effects."""
    last = search.last
    groups = last.state.runs.groups
    if len(groups) < FEWEST:
        return Decoys()
    order = _derangement(groups, "".join(last.state.runs.names))
    kinds = [
        _decoy(item, last.state.runs.groups, order)
        for item in best_per_effect(last.screen)
        if item.visible >= VISIBLE and not item.candidate.effect.generic
    ]
    offered = [Candidate(k, {}, k.column[None]) for k in kinds]
    beside = Beside.of(replace(last.state, offered=partial(list, offered)), kinds)
    tried = best_per_effect(beside.scales.ranking)[:REFITS]
    weighed = [beside.with_term(term_of(i.candidate, i.sizes)) for i in tried]
    accepted = (w.names[-1] for w in weighed if beside.decide(w).accepted)
    return Decoys(len(kinds), tuple(accepted))


def _derangement(groups: Sequence[np.ndarray], key: str) -> np.ndarray:
    """A permutation without fixed conditions, the same for the same runs."""
    random = np.random.default_rng(crc32(key.encode()))
    while True:
        order = random.permutation(len(groups))
        if np.all(order != np.arange(len(groups))):
            return order


@dataclass(frozen=True)
class Decoy(TireEffect):
    """Base: adds a given column to every channel."""

    kind = "machine"
    column: ClassVar[np.ndarray]
    """(channels, runs, samples)"""

    times: float = param(0.0, unit="-", bounds=(-100.0, 100.0), screen=1.0, matters=1.0)

    def signal(self, signal: Signal) -> None:
        for name, column in zip(signal.data.runs.channels, self.column, strict=True):
            setattr(signal, name, getattr(signal, name) + self.times * column)


def _decoy(item: ScreenResult, groups: Sequence[np.ndarray], order: Iterable[int]) -> type[Decoy]:
    """The effect's column, of the size that matters, with the conditions permuted."""
    effect, main = item.candidate.effect, item.candidate.effect.main_parameter()
    sizes = item.sizes if np.any(item.sizes) else np.ones(len(item.sizes))
    sizes = sizes / np.abs(sizes).max() * main.matters / abs(main.screen or main.matters)
    own = np.tensordot(sizes, item.candidate.columns, axes=1)
    column = np.empty_like(own)
    for rows, other in zip(groups, order, strict=True):
        column[:, rows] = own[:, np.resize(groups[other], len(rows))]
    name = f"decoy_of_{effect.identifier}"
    facts = {"identifier": name, "coordinate": effect.coordinate, "column": column}
    return cast(type[Decoy], type(name, (Decoy,), facts))
