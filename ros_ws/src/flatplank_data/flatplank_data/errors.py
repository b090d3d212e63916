# SPDX-License-Identifier: Apache-2.0
"""Errors of measurements and their files; the root, `FlatplankError`, is in `flatplank_tire`."""

from __future__ import annotations

from flatplank_tire.errors import FlatplankError


class UnwritableError(FlatplankError, OSError):
    """A file that cannot be written."""

    @property
    def strerror(self) -> str:  # type: ignore[override]
        """The fault alone, without the name of the file."""
        return self.what


class YamlError(FlatplankError):
    """A text that is not valid YAML."""


class NothingUsableError(FlatplankError):
    """No run could be used; programs exit with code 2."""


class RecordingError(FlatplankError):
    """A fault in a recording, its run record or its name."""
