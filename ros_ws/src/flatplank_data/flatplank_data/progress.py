# SPDX-License-Identifier: Apache-2.0
"""What a long job tells while it goes on."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

Item = TypeVar("Item")
Progress = Callable[[str, float], None]
"""text of the present activity and completed share"""


def told(runs: Sequence[Item], progress: Progress | None) -> Iterator[Item]:
    """The runs in turn, each told with its number before it is read."""
    for number, run in enumerate(runs, start=1):
        if progress:
            progress(f"reading run {number} of {len(runs)}", (number - 1) / len(runs))
        yield run
