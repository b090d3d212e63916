# SPDX-License-Identifier: Apache-2.0
"""Choice of the next runs: the candidate with the largest expected answer per minute.

Independent of runs and models: questions give the expected answer of a candidate, a price its
cost. To stop is a choice, too.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from flatplank_analysis.investigation.settings import Candidate, Setting

TIE = 0.02
"""relative difference of two rates that counts as equal"""
NOTHING = 1e-3
"""share of an answer per candidate that counts as none"""
DECIDED, SPENT, NOTHING_LEFT = "decided", "budget spent", "nothing left to learn"


@dataclass(frozen=True)
class Question:
    """An open question, in units of expected log likelihood ratio."""

    text: str
    """continues a sentence: `to separate a from b`"""
    have: float
    needed: float
    """answer so far, and answer that closes the question"""
    gain: Callable[[tuple[Setting, ...]], float]
    """expected increase by runs"""

    @property
    def open(self) -> float:
        """Missing part of the answer."""
        return max(self.needed - self.have, 0.0)


class Price(NamedTuple):
    """Cost of a candidate."""

    minutes: float
    """minutes including set-up changes"""
    changes: int
    """number of set-up changes"""


FREE = Price(0.0, 0)


@dataclass(frozen=True)
class Choice:
    """The next candidate, or the reason to stop."""

    candidate: Candidate | None
    reason: str
    price: Price = FREE
    expected: float = 0.0
    """expected log likelihood ratio"""
    stop: str = ""
    """reason to stop: decided, budget spent, nothing left to learn"""


def choose(
    questions: Sequence[Question],
    candidates: Sequence[Candidate],
    price: Callable[[Candidate], Price],
    minutes_left: float,
) -> Choice:
    """The candidate with the largest expected answer per minute; ties by fewer set-up changes."""
    asked = [q for q in questions if q.open > 0.0]
    if not asked:
        return Choice(None, "every question is answered", stop=DECIDED)
    prices = {c: price(c) for c in candidates}
    possible = [c for c in candidates if prices[c].minutes <= minutes_left]
    if not possible:
        why = f"{minutes_left:.0f} minutes are left, and no run takes less"
        return Choice(None, why, stop=SPENT)
    gains = {c: [q.gain(c.settings) for q in asked] for c in possible}
    useful = [i for i in range(len(asked)) if _within_reach(i, asked, gains, prices, minutes_left)]
    if not useful:
        return _no_use(asked, gains, prices, minutes_left)

    def worth(c: Candidate) -> float:
        return sum(min(gains[c][i], asked[i].open) for i in useful)

    best = max(worth(c) / prices[c].minutes for c in possible)
    near = [c for c in possible if worth(c) / prices[c].minutes >= (1.0 - TIE) * best]
    taken = min(near, key=lambda c: (prices[c].changes, -worth(c) / prices[c].minutes))
    main = max(useful, key=lambda i: min(gains[taken][i], asked[i].open))
    return Choice(taken, asked[main].text, prices[taken], worth(taken))


def _within_reach(i, asked, gains, prices, minutes_left) -> bool:
    """Whether a question can be answered in the remaining minutes."""
    best = max(gains[c][i] / prices[c].minutes for c in gains)
    most = max(gains[c][i] for c in gains)
    return most > NOTHING and best * minutes_left >= asked[i].open


def _no_use(asked, gains, prices, minutes_left) -> Choice:
    """The choice to stop: more time is needed, or no run of the bench would help."""
    most = [max(gains[c][i] for c in gains) for i in range(len(asked))]
    i = max(range(len(asked)), key=lambda k: most[k] / asked[k].open)
    if most[i] <= NOTHING:
        why = f"no run of the bench would help {asked[i].text}"
        return Choice(None, why, stop=NOTHING_LEFT)
    best = max(gains[c][i] / prices[c].minutes for c in gains)
    why = (
        f"{asked[i].open / best:.0f} minutes would be needed {asked[i].text}, "
        f"{minutes_left:.0f} are left"
    )
    return Choice(None, why, stop=NOTHING_LEFT)
