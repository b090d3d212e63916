# SPDX-License-Identifier: Apache-2.0
"""Errors that state what is wrong, where, and what to do, on one line."""

from __future__ import annotations


class FlatplankError(ValueError):
    """Bad input, the root of all errors of the project, described so that the user can correct it.

    `what`: the fault; `where`: file, row, column; `remedy`: what to do.
    """

    def __init__(self, what: str, where: str = "", remedy: str = "") -> None:
        self.what, self.where, self.remedy = (_one_line(part) for part in (what, where, remedy))
        super().__init__(self.what, self.where, self.remedy)

    def __str__(self) -> str:
        head = f"{self.where}: {self.what}" if self.where else self.what
        return f"{head}; {self.remedy}" if self.remedy else head


def _one_line(text: str) -> str:
    return " ".join(str(text).split())
