# SPDX-License-Identifier: Apache-2.0
"""What is wrong, where, and what to do, on one line."""

from __future__ import annotations


class FlatplankError(Exception):
    """Bad input, told so that the reader can mend it.

    `what` is wrong, `where` it is (file, row, column), and the `remedy`.
    """

    def __init__(self, what: str, where: str = "", remedy: str = "") -> None:
        self.what, self.where, self.remedy = (_one_line(part) for part in (what, where, remedy))
        super().__init__(self.what, self.where, self.remedy)

    def __str__(self) -> str:
        head = f"{self.where}: {self.what}" if self.where else self.what
        return f"{head}; {self.remedy}" if self.remedy else head


class UnwritableError(FlatplankError, OSError):
    """A file that cannot be written."""

    @property
    def strerror(self) -> str:  # type: ignore[override]
        """What is wrong, without the file."""
        return self.what


class YamlError(FlatplankError, ValueError):
    """A text that is no YAML."""


class NothingUsableError(FlatplankError):
    """Not one run could be used: programs see exit code 2."""


class RecordingError(ValueError):
    """A recording, its record or its name: what happened, where, and what to do."""


def _one_line(text: str) -> str:
    return " ".join(str(text).split())
