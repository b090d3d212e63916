# SPDX-License-Identifier: Apache-2.0
"""Which of the nodes that a node waits for in a bus cycle have gone."""

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
        self._most: dict[str, int] = {}
        self.silent: set[str] = set()
        """kinds whose publisher has gone, and of which no sample has come since"""

    def add(self, kind: str, count: Callable[[], int]) -> None:
        """Add a kind of sample and the function that counts its publishers."""
        self._counts[kind], self._most[kind] = count, 0

    def gone(self) -> set[str]:
        """Kinds with fewer publishers than before. One that has not come yet is not gone."""
        found = set()
        for kind, count in self._counts.items():
            here = count()
            self._most[kind] = max(self._most[kind], here)
            if here < self._most[kind]:
                found.add(kind)
        self.silent |= found
        return found

    def heard(self, kind: str) -> bool:
        """Register a sample; True for the first one since the publisher was away. A node that was
        started again may have missed the inputs of the present cycle: it is there once it speaks.
        """
        if kind not in self.silent:
            return False
        self.silent.discard(kind)
        return True
