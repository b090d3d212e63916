# SPDX-License-Identifier: Apache-2.0
"""What a trouble of the bench is: how bad, what is seen, what it means, what to do."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class Level(IntEnum):
    """As in diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


@dataclass(frozen=True)
class Trouble:
    """One entry of the registry; each text is a clause without a full stop."""

    name: str
    level: Level
    text: str
    """what is seen"""
    cause: str
    """what it means"""
    remedy: str
    """what to do"""

    def line(self, detail: str = "") -> str:
        """For the log and /diagnostics."""
        seen = f"{self.text} ({detail})" if detail else self.text
        return f"{seen}; {self.remedy}" if self.remedy else seen


def table(*troubles: Trouble) -> dict[str, Trouble]:
    """By name; ValueError for a name that is there twice."""
    by_name = {trouble.name: trouble for trouble in troubles}
    if len(by_name) < len(troubles):
        raise ValueError("two troubles of one name")
    return by_name
