# SPDX-License-Identifier: Apache-2.0
"""The rows of the table: what is tried, how many, how many failed."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class Options:
    """How much is tried."""

    share: float = 1.0
    """of the cases of a night; a row tries at least one"""
    seed: int = 1
    jobs: int = 1
    """processes"""
    progress: Progress = lambda _done, _all: None

    def count(self, night: int) -> int:
        """Number of cases of which a night has so many."""
        return max(round(self.share * night), 1)


@dataclass
class Tally:
    """Result of a row."""

    many: int = 0
    failures: list[str] = field(default_factory=list)
    """one line for each failed case: what was done and what came out"""
    refused: int = 0
    """cases that passed because they were refused"""
    notes: list[str] = field(default_factory=list)
    """what was measured beside the count: times, memory"""

    def add(self, failure: str) -> None:
        """Count a case; `failure` is empty when it passed."""
        self.many += 1
        if failure:
            self.failures.append(failure)

    def join(self, other: Tally) -> None:
        """Add the cases of another tally."""
        self.many += other.many
        self.refused += other.refused
        self.failures += other.failures
        self.notes += other.notes


@dataclass(frozen=True)
class Result:
    """A row as it was measured, in one run or in several with other seeds."""

    tally: Tally
    seconds: float
    share: float
    """of the cases of a night"""
    seeds: tuple[int, ...]
    place: str = ""
    """commit and kind of machine"""

    def join(self, other: Result) -> Result:
        """Both together."""
        both = Tally()
        both.join(self.tally)
        both.join(other.tally)
        places = [*self.place.split("; "), *other.place.split("; ")]
        return Result(
            both, self.seconds + other.seconds, self.share + other.share,
            (*self.seeds, *other.seeds), "; ".join(dict.fromkeys(filter(None, places))),
        )  # fmt: skip


Run = Callable[[Options], Tally]


@dataclass(frozen=True)
class Row:
    """A row of the table."""

    what: str
    bar: str
    """what counts as failed"""
    run: Run


ROWS: dict[str, Row] = {}
"""name -> row, in the order of the table"""


def row(name: str, what: str, bar: str) -> Callable[[Run], Run]:
    """Register a function as a row: `what` is tried, `bar` says which case has failed."""

    def register(run: Run) -> Run:
        if name in ROWS:
            raise ValueError(f"two rows are named '{name}'")
        ROWS[name] = Row(what, bar, run)
        return run

    return register


def rows() -> dict[str, Row]:
    """All rows of the modules in `rows/`."""
    from flatplank_validation.trust import rows as folder

    for name in _modules(folder.__path__):
        importlib.import_module(f"{folder.__name__}.{name}")
    return ROWS


def _modules(path: Iterable[str]) -> list[str]:
    return sorted(module.name for module in pkgutil.iter_modules(path))
