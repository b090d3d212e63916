# SPDX-License-Identifier: Apache-2.0
"""Decisions, rivals and screened effects with chosen numbers."""

from __future__ import annotations

import numpy as np
from shapes import CONDITIONS, LONG, REPEATS, shape

from flatplank_analysis.discovery.decision import Decision
from flatplank_analysis.discovery.fit import Term
from flatplank_analysis.discovery.screen import ScreenResult
from flatplank_analysis.discovery.state import Candidate
from flatplank_analysis.discovery.steps import Rival

RUNS = CONDITIONS * REPEATS


def decision(effect=LONG, size: float = 0.1, **changes) -> Decision:
    """An accepted one."""
    facts = dict(
        term=Term(effect, np.array([size])), drop=1000.0, probability=0.99,
        interval=(0.5 * size, 1.5 * size), held_out_gain=0.5,
    )  # fmt: skip
    return Decision(**{**facts, **changes})


def rival(name: str, excluded: bool) -> Rival:
    return Rival(Term(shape(name, LONG.form), np.array([1.0])), 0.5, excluded)


def screened(effect, sizes, gain=1000.0, visible=0.5, setting=None) -> ScreenResult:
    size = np.atleast_1d(np.array(sizes, float))
    candidate = Candidate(effect, setting or {}, np.zeros((len(size), 1, 1, 1)))
    return ScreenResult(candidate, size, gain, visible, np.eye(len(size)), np.eye(9)[0])
