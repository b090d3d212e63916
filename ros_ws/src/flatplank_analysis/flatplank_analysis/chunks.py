# SPDX-License-Identifier: Apache-2.0
"""Independent work in chunks of about two seconds: in order, bounded in flight, repeated when a
worker dies. Whoever does the work, processes or a cluster, is a `Crew`."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol, TypeVar

from flatplank_data.errors import FlatplankError

Item = TypeVar("Item")
Result = TypeVar("Result")
CHUNK = 2.0
"""wanted time of a chunk: long beside the cost of sending it [s]"""
GROWTH = 8
"""a chunk has at most so many times the items of the largest one that was measured"""
AHEAD = 4
"""number of chunks in flight per worker: done chunks wait for those before them"""
RETRIES = 3
"""number of times in a row that work is repeated after a worker has died"""


class Crew(Protocol):
    """Workers that take chunks."""

    lost: tuple[type[BaseException], ...]
    """what a result raises when its worker died"""

    def workers(self) -> int:
        """Number of workers at present; 0: none has come yet."""

    def submit(self, work: Callable[..., Any], *arguments: Any) -> Any:
        """A future of `work(*arguments)`."""

    def renew(self) -> None:
        """Get new workers in place of those that died."""


def in_order(
    crew: Crew, function: Callable[[Item], Result], items: Sequence[Item]
) -> Iterator[Result]:
    """Yield the results in the order of the items; the first error of `function` is raised.

    Raises FlatplankError when workers die again and again at the same work.
    """
    begun, losses, size, measured = 0, 0, 1, 0
    flight: deque[tuple[Sequence[Item], Any]] = deque()
    try:
        while flight or begun < len(items):
            workers = max(crew.workers(), 1)
            while begun < len(items) and len(flight) < AHEAD * workers:
                fair = math.ceil((len(items) - begun) / (2 * workers))
                chunk = items[begun : begun + min(size, fair)]
                flight.append((chunk, crew.submit(_work, function, chunk)))
                begun += len(chunk)
            chunk, future = flight[0]
            try:
                seconds, results = future.result()
            except crew.lost as error:
                losses += 1
                if losses > RETRIES:
                    what = f"workers died {losses} times at the same work"
                    remedy = "use fewer --jobs, or workers with more memory"
                    raise FlatplankError(what, "parallel work", remedy) from error
                crew.renew()
                flight = deque(_again(crew, function, c, f) for c, f in flight)
                continue
            flight.popleft()
            losses, measured = 0, max(measured, len(chunk))
            wanted = CHUNK * len(chunk) / max(seconds, 1e-9)
            size = max(1, int(min(wanted, GROWTH * measured)))
            yield from results
    finally:
        for _, future in flight:
            future.cancel()


def _again(
    crew: Crew, function: Callable[[Item], Result], chunk: Sequence[Item], future: Any
) -> tuple[Sequence[Item], Any]:
    """The chunk with its result where it has one, else submitted once more."""
    if future.done() and not future.cancelled() and future.exception() is None:
        return chunk, future
    return chunk, crew.submit(_work, function, chunk)


def _work(function: Callable[[Item], Result], chunk: Sequence[Item]) -> tuple[float, list[Result]]:
    """Time of a chunk [s] and its results."""
    begin = time.perf_counter()
    results = [function(item) for item in chunk]
    return time.perf_counter() - begin, results
