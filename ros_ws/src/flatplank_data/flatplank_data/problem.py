# SPDX-License-Identifier: Apache-2.0
"""A problem with one file of a campaign; the other runs stay usable."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_data.errors import FlatplankError


@dataclass(frozen=True)
class Problem:
    """What is wrong with one file, where in it, and what to do."""

    file: str
    what: str
    place: str = ""
    """row, column or key"""
    remedy: str = ""
    fatal: bool = True
    """True: the run cannot be used"""
    left_out: bool = False
    """True: the run is left out on purpose, and this is not a fault"""

    def __str__(self) -> str:
        head = f"{self.file}: {self.place}: " if self.place else f"{self.file}: "
        tail = f"; {self.remedy}" if self.remedy else ""
        return f"{head}{self.what}{tail}" + ("" if self.fatal or self.left_out else " (run kept)")

    def as_error(self) -> FlatplankError:
        """The problem as an exception."""
        where = f"{self.file}, {self.place}" if self.place else self.file
        return FlatplankError(self.what, where, self.remedy)


def problem_from_error(error: FlatplankError, file: str) -> Problem:
    """Convert an exception about `file`."""
    where = error.where.removeprefix(file).lstrip(":, ")
    return Problem(file, error.what, where, error.remedy)
