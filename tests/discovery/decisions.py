# SPDX-License-Identifier: Apache-2.0
"""Decisions, rivals and screened effects with chosen numbers."""

from __future__ import annotations

import numpy as np
from shapes import CONDITIONS, LONG, REPEATS, shape

from flatplank_analysis.discovery.decision import UNEVEN, Decision
from flatplank_analysis.discovery.fit import Term
from flatplank_analysis.discovery.rivals import Rival
from flatplank_analysis.discovery.screen import ScreenResult
from flatplank_analysis.discovery.state import Candidate

RUNS = CONDITIONS * REPEATS


def decision(effect=LONG, size: float = 0.1, **changes) -> Decision:
    """One that every test accepts."""
    facts = dict(
        term=Term(effect, np.array([size])), drop=1000.0, parameters=1, dispersion=1.0,
        dispersion_conditions=1.0, p_repeats=1e-9, p_conditions=1e-9, level=0.01, matters=0.01,
        stretch_q=1.0, stretch_limit=30.0, condition_q=2.0, condition_limit=30.0,
        interval=(0.5 * size, 1.5 * size), held_out_gain=0.5, reasons=(),
    )  # fmt: skip
    return Decision(**{**facts, **changes})


def odd(effect=LONG, share: float = 0.2, **changes):
    """Refused for its form alone."""
    drop = changes.setdefault("drop", 1000.0)
    return decision(effect, reasons=UNEVEN[:1], stretch_q=share * drop, **changes)


def rival(name: str, excluded: bool, near: bool) -> Rival:
    return Rival(Term(shape(name, LONG.form), np.array([1.0])), 0.0, near, excluded)


def screened(effect, sizes, gain=1000.0, visible=0.5, setting=None) -> ScreenResult:
    size = np.atleast_1d(np.array(sizes, float))
    candidate = Candidate(effect, setting or {}, np.zeros((len(size), 1, 1, 1)))
    return ScreenResult(candidate, size, gain, visible, np.eye(len(size)), np.eye(9)[0])
