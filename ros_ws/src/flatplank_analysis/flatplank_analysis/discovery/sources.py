# SPDX-License-Identifier: Apache-2.0
"""Ranked sources of the noise floor, each with the strongest verdict that it permits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from flatplank_analysis.discovery.model import Model
from flatplank_analysis.discovery.recurring import (
    PieceModel,
    Pieces,
    lap_pieces,
    level_pieces,
    up_and_down_pieces,
)
from flatplank_analysis.discovery.runs import RunSet

FOUND, PARTLY, UNDECIDED = "found", "partly", "not decidable"
AT_FLOOR, GROUP = "at floor", "found group"
LAW, NONE = "tire law only", "none of these"
CLAIMS = (FOUND, GROUP, LAW)
"""verdicts that claim that everything is explained"""


@dataclass(frozen=True)
class Source:
    """Something that can give a floor."""

    identifier: str
    title: str
    """text after 'floor by'"""
    at_most: str
    """strongest permitted verdict"""
    offered: Callable[[RunSet], bool | Pieces | None]
    """whether the runs have this source; pieces where their records must be cut for it"""
    lower_bound: bool = False
    """True when the real scatter may be larger"""
    systematic: bool = False
    """True when its repeats differ systematically, so that an effect may be part of the floor"""

    def words(self) -> str:
        return self.title + (" (lower bound)" if self.lower_bound else "")

    def to_dict(self) -> dict[str, Any]:
        """For programs: keys of the JSON of `diagnose` and `compare`."""
        return {
            "floor_from": self.words(),
            "floor_is_lower_bound": self.lower_bound,
            "verdict_at_most": self.at_most,
        }


def _repeats(runs: RunSet) -> bool:
    """A condition measured twice in one session; runs without a session belong to the same one."""
    sessions = runs.facts.get("session", np.zeros(runs.runs))
    return any(len(np.unique(sessions[g])) < len(g) for g in runs.groups)


SOURCES = (
    Source("repeats", "repeats of a condition", FOUND, _repeats),
    Source("laps", "laps of a periodic input in one record", FOUND, lap_pieces),
    Source("visits", "a level visited twice", FOUND, level_pieces),
    Source("ways", "up and down through the same values", PARTLY, up_and_down_pieces,
           systematic=True),
    Source("sessions", "the same condition in other sessions", PARTLY, lambda r: r.repeated),
    Source("rest", "noise at rest", PARTLY, lambda r: min(r.rest, default=0.0) > 0.0,
           lower_bound=True),
    Source("resolution", "resolution of what was recorded", PARTLY, lambda r: all(
        scatter_lower_bound(r, c) > 0.0 for c in range(len(r.channels))
    ), lower_bound=True),
    Source("nothing", "nothing", UNDECIDED, lambda _: True),
)  # fmt: skip
"""best first; the last one always applies"""
BY_NAME = {s.identifier: s for s in SOURCES}


def source_of(runs: RunSet) -> Source:
    """The source of the floor of these runs."""
    return BY_NAME[runs.floor_from] if runs.floor_from else _best(runs)[0]


def cut_where_needed(model: Model) -> Model:
    """The model with its runs cut into pieces where the best source needs them."""
    if model.runs.floor_from:
        return model
    source, pieces = _best(model.runs)
    return PieceModel(model, pieces, source.identifier) if pieces is not None else model


def can_show(runs: RunSet, columns: np.ndarray) -> bool:
    """False where the effect of columns (k, channels, runs, samples) is part of the floor."""
    if not source_of(runs).systematic:
        return True
    return bool(np.sum(runs.contrast(columns) ** 2) < 0.5 * np.sum(columns**2))


def scatter_lower_bound(runs: RunSet, channel: int) -> float:
    """Lower bound of the scatter of a channel, in its unit."""
    at_rest, resolution, inputs = (
        values[channel] if values else 0.0
        for values in (runs.rest, runs.resolution, runs.input_noise)
    )
    return float(np.sqrt(max(at_rest**2, resolution**2 / 12.0) + inputs**2))


def _best(runs: RunSet) -> tuple[Source, Pieces | None]:
    for source in SOURCES:
        offer = source.offered(runs)
        if offer:
            return source, offer if isinstance(offer, Pieces) else None
    raise AssertionError("the last source is always there")


def limited_by_source(source: Source, verdict: str, reason: str) -> tuple[str, str]:
    """Verdict and reason limited by the source; the reason names a source other than repeats."""
    if source.at_most == FOUND:
        return verdict, reason
    explained = f"{reason}; the floor is from {source.words()}"
    if verdict not in CLAIMS:
        return verdict, explained
    return PARTLY, f"{explained}, which allows no more than '{PARTLY}': repeat the conditions"
