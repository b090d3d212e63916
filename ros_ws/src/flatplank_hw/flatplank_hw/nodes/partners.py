# SPDX-License-Identifier: Apache-2.0
"""Which of the nodes that a node waits for in a bus cycle are there."""

from __future__ import annotations

from collections.abc import Callable

LOOK_S = 0.25
"""interval at which the publishers are counted [s]"""


class Partners:
    """Counts the publishers of each kind of sample.

    A node that ends leaves the graph at once, a killed one when its lease expires (20 s with Fast
    DDS). A node that is only late, or stopped, does not leave it.
    """

    def __init__(self) -> None:
        self._counts: dict[str, Callable[[], int]] = {}
        self._before: dict[str, int] = {}
        self.silent: set[str] = set()
        """kinds of which no sample has come since a publisher left, or since the start"""

    def add(self, kind: str, count: Callable[[], int], *, each_cycle: bool = False) -> None:
        """Add a kind of sample and the function that counts its publishers. `each_cycle`: it comes
        in each cycle, so a node that has not spoken yet may not have heard the cycle."""
        self._counts[kind], self._before[kind] = count, 0
        if each_cycle:
            self.silent.add(kind)

    def look(self) -> set[str]:
        """Count the publishers; returns the kinds that have fewer than at the last look."""
        here = {kind: count() for kind, count in self._counts.items()}
        fewer = {kind for kind, count in here.items() if count < self._before[kind]}
        self._before = here
        self.silent |= fewer
        return fewer

    def heard(self, kind: str) -> bool:
        """Register a sample; True for the first one of a silent kind. A node that was started may
        have missed the inputs of the present cycle: it is there once it speaks.
        """
        if kind not in self.silent:
            return False
        self.silent.discard(kind)
        return True
