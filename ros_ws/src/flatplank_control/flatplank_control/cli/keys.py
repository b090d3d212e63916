# SPDX-License-Identifier: Apache-2.0
"""Single keys from a terminal while something else goes on."""

from __future__ import annotations

import select
import sys
import termios
import tty
from types import TracebackType


class Keys:
    """A context manager; without a terminal no key ever comes."""

    def __enter__(self) -> Keys:
        self._terminal = sys.stdin.isatty()
        if self._terminal:
            self._before = termios.tcgetattr(sys.stdin)
            tty.setcbreak(sys.stdin)
        return self

    def __exit__(
        self, kind: type | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._terminal:
            termios.tcsetattr(sys.stdin, termios.TCSADRAIN, self._before)

    def pressed(self) -> str:
        """A key that was pressed, or an empty text."""
        if not self._terminal or not select.select([sys.stdin], [], [], 0.0)[0]:
            return ""
        return sys.stdin.read(1)

    def line(self, prompt: str) -> str:
        """A whole line, with echo."""
        if not self._terminal:
            return ""
        termios.tcsetattr(sys.stdin, termios.TCSADRAIN, self._before)
        try:
            return input(prompt)
        finally:
            tty.setcbreak(sys.stdin)
