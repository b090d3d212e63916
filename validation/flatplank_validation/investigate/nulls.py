# SPDX-License-Identifier: Apache-2.0
"""Evidence (e-values) when nothing is missing: bets on the most likely effect, tested on later
runs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery.screen import VISIBLE, best_per_effect
from flatplank_analysis.discovery.state import term_of
from flatplank_analysis.inference.beside import Beside
from flatplank_analysis.investigation.evidence import (
    ALPHA,
    Evidence,
    Hypothesis,
    e_value_words,
    log_e,
)
from flatplank_analysis.investigation.loop import rows_of
from flatplank_analysis.investigation.settings import Setting
from flatplank_validation.blind.points import share
from flatplank_validation.investigate.fast import FastBench

BATCHES = ((-0.02, 1.5), (0.02, 2.2), (-0.05, 1.5))
"""slip and step position of the later runs, two of each"""


def likeliest(session: Session) -> Hypothesis | None:
    """Bet on the first effect in the ranking, whatever the tests say about it."""
    step = session.fit(None)
    state = step.state
    for item in best_per_effect(step.screen):
        effect = item.candidate.effect
        if effect.generic or effect.law or item.visible < VISIBLE or not item.gain:
            continue
        beside = Beside.of(state, list(session.effects.values()))
        made = beside.with_term(term_of(item.candidate, item.sizes))
        return Hypothesis.of([beside.decide(made)], state, made.fit, state.whitened.fit)
    return None


def evidence_of(bench: FastBench, batches: Sequence[tuple[float, float]] = BATCHES) -> list[float]:
    """Logarithm of the e-value (product of the bets) after every batch."""
    files = bench.make(bench.seed().settings, 0)
    usual = bench.seed().settings[0]
    total, out = Evidence(), []
    for kappa, step in batches:
        bet = likeliest(bench.session(files))
        settings = [
            Setting(kappa, start, step, usual.fz, usual.pressure) for start in (1, 2)
        ]  # fmt: skip
        new = bench.make(settings, len(files))
        files = [*files, *new]
        if bet is not None:
            session = bench.session(files)
            total = total.with_batch(log_e(bet, session.data, rows_of(session, new)), True)
        out.append(total.log)
    return out


def lines_of_evidence(count: int, seed: int) -> Iterator[str]:
    """Lines with the e-value after every batch of loops without a hidden effect, and the share of
    loops in which it ever exceeded 1/alpha."""
    passed = []
    for number in range(count):
        product = evidence_of(FastBench(seed + number))
        passed.append(max(product) >= -math.log(ALPHA))
        yield f"{number + 1}/{count}: {', '.join(e_value_words(log) for log in product)}"
    yield f"1/alpha = {1.0 / ALPHA:g} passed at any time: {share(passed)}"
