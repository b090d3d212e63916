# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C that waits for a place where it does no harm."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType, TracebackType


class Interrupt:
    """While entered, Ctrl-C within `held` is kept until its end, or until `look`.

    KeyboardInterrupt in the midst of rclpy loses the message that was being taken, and may leave
    its receiver deaf for ever: a goal could then neither be cancelled nor be heard of. The first
    Ctrl-C is kept; who is impatient has the second one at once. Where Ctrl-C is ignored or means
    something else it stays so.
    """

    def __init__(self) -> None:
        self._depth = 0
        self._asked = self._told = False
        self._ours = False

    def __enter__(self) -> Interrupt:
        self._ours = signal.getsignal(signal.SIGINT) is signal.default_int_handler
        if self._ours:
            signal.signal(signal.SIGINT, self._on_signal)
        return self

    def __exit__(
        self, kind: type | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._ours:
            signal.signal(signal.SIGINT, signal.default_int_handler)

    def _on_signal(self, _number: int, _frame: FrameType | None) -> None:
        if self._asked:
            raise KeyboardInterrupt
        self._asked = True
        if not self._depth:
            self.look()

    def look(self) -> None:
        """KeyboardInterrupt, once, when Ctrl-C was pressed."""
        if self._asked and not self._told:
            self._told = True
            raise KeyboardInterrupt

    @contextmanager
    def held(self) -> Iterator[None]:
        """No first Ctrl-C in here; it comes at the end of the outermost one."""
        self._depth += 1
        try:
            yield
        finally:
            self._depth -= 1
        if not self._depth:
            self.look()

    @contextmanager
    def let(self) -> Iterator[None]:
        """Within `held`: Ctrl-C comes through at once, for what waits for a person."""
        depth, self._depth = self._depth, 0
        try:
            self.look()
            yield
        finally:
            self._depth = depth
