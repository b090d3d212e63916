# SPDX-License-Identifier: Apache-2.0
"""Which of many settings change an answer: sequential bifurcation.

Several settings are applied together. Where the answer changes, the group is halved and both
halves are tried, down to single settings. Two settings whose changes cancel are not seen.

Source: B. Bettonvil, J. P. C. Kleijnen, Searching for important factors in simulation models with
many factors: sequential bifurcation, European Journal of Operational Research 96 (1997) 180-194.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

Item = TypeVar("Item")
Answer = TypeVar("Answer")


def bifurcate(
    groups: Sequence[Sequence[Item]],
    answers_of: Callable[[Sequence[Sequence[Item]]], Sequence[Answer]],
    changed: Callable[[Answer], bool],
) -> Iterator[tuple[Item, Answer, int]]:
    """Every item with an answer and the number of items that were applied for it: its own answer,
    or that of a group without a change.

    answers_of: one answer for each group.
    """
    while groups:
        halves: list[Sequence[Item]] = []
        for group, answer in zip(groups, answers_of(groups), strict=True):
            middle = len(group) // 2
            if middle and changed(answer):
                halves += [group[:middle], group[middle:]]
            else:
                yield from ((item, answer, len(group)) for item in group)
        groups = halves


def groups_of(items: Sequence[Item], most: int) -> list[Sequence[Item]]:
    """Neighbours in groups of at most so many."""
    return [items[i : i + most] for i in range(0, len(items), most)]
