# SPDX-License-Identifier: Apache-2.0
"""Joins the samples of one bus cycle that arrive over several topics."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any


class CycleJoin:
    """Call `complete(at, samples)` once per bus cycle, in order, when every needed kind is there.

    `at`, the stamp of the inputs [ns], identifies a cycle. A later sample of the leading kind (the
    first of `kinds`) completes a waiting cycle as it is: the last sample of an ended source stays
    in use, and the rules on stale data act. A late sample is kept as the latest of its kind.
    `await_kinds` changes the needed ones.
    """

    def __init__(
        self, kinds: tuple[str, ...], complete: Callable[[int, Mapping[str, Any]], None]
    ) -> None:
        self.kinds = kinds
        self._needed = frozenset(kinds)
        self._complete = complete
        self._due: int | None = None
        self._latest: dict[str, Any] = dict.fromkeys(kinds)
        self._at: dict[str, int] = dict.fromkeys(kinds, -1)
        self._queues: dict[str, dict[int, Any]] = {kind: {} for kind in kinds}

    def await_kinds(self, needed: Iterable[str]) -> None:
        """Wait for these kinds from now on, also in the cycle that waits already."""
        self._needed = frozenset(needed)
        self._flush()

    def put(self, kind: str, due: int, sample: Any) -> None:
        """Add a sample of the cycle whose inputs have the stamp `due` [ns]."""
        if self._due is not None and due < self._due:
            self._keep(kind, due, sample)
            return
        self._queues[kind][due] = sample
        if kind == self.kinds[0]:
            if self._due is None:
                self._due = due
            elif due > self._due:
                while self._due is not None and self._due < due:
                    self._release()
        self._flush()

    def _keep(self, kind: str, due: int, sample: Any) -> None:
        if due >= self._at[kind]:
            self._at[kind], self._latest[kind] = due, sample

    def _flush(self) -> None:
        lead = self._queues[self.kinds[0]]
        while self._due in lead and all(self._due in self._queues[k] for k in self._needed):
            self._release()

    def _release(self) -> None:
        now = self._due
        assert now is not None, "only what is due is released"
        for kind, queue in self._queues.items():
            for due in sorted(d for d in queue if d <= now):
                self._keep(kind, due, queue.pop(due))
        lead = self._queues[self.kinds[0]]
        had_lead = self._at[self.kinds[0]] == now
        self._due = min(lead) if lead else now + 1
        if had_lead:
            self._complete(now, self._latest)
