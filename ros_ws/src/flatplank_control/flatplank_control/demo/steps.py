# SPDX-License-Identifier: Apache-2.0
"""Progress of a long job on the terminal."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence


class Teller:
    """Numbered steps, each with what is going on now and how long it took."""

    def __init__(self, steps: int) -> None:
        self._steps = steps
        self._step = 0
        self._begin = time.monotonic()
        self._open = False

    def step(self, text: str) -> None:
        """A new step begins."""
        self._finish()
        self._step += 1
        self._begin = time.monotonic()
        print(f"[{self._step}/{self._steps}] {text}", flush=True)

    def now(self, text: str) -> None:
        """What is going on; on a terminal the line is written over."""
        if sys.stdout.isatty():
            print(f"\r\033[K      {text}", end="", flush=True)
            self._open = True
        else:
            print(f"      {text}", flush=True)

    def count(self, done: int, total: int, name: str) -> None:
        """Progress of many alike."""
        if sys.stdout.isatty() or done == total or done % 9 == 0:
            self.now(f"{done}/{total} {name}")

    def close(self, lines: Sequence[str]) -> None:
        """The last words."""
        self._finish()
        print("\n" + "\n".join(lines), flush=True)

    def _finish(self) -> None:
        if self._open:
            print()
            self._open = False
        if self._step:
            print(f"      {time.monotonic() - self._begin:.0f} s", flush=True)
