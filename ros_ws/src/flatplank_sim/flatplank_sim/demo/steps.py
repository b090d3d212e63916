# SPDX-License-Identifier: Apache-2.0
"""Progress of a long job on the terminal."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path


class Teller:
    """Numbered steps, each with what is going on now and how long it took."""

    def __init__(self, steps: int) -> None:
        self._steps = steps
        self._step = 0
        self._begin = time.monotonic()
        self._open = False
        self._text = ""
        self.took: list[tuple[str, float]] = []
        """the steps that are over, and how long each took [s]"""

    def step(self, text: str) -> None:
        """A new step begins."""
        self._finish()
        self._step += 1
        self._text = text
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
        """The last words, with the times of the steps."""
        self._finish()
        print("\n" + "\n".join([*lines, *self._times()]), flush=True)

    def _times(self) -> list[str]:
        rows = [(f"[{i}] {text}", seconds) for i, (text, seconds) in enumerate(self.took, 1)]
        rows.append(("all of the demo", sum(seconds for _, seconds in self.took)))
        if (set_up := set_up_time()) is not None:
            rows.append(("set-up before the first start (tools/setup)", set_up))
        return ["times:", *(f"  {seconds:5.0f} s  {text}" for text, seconds in rows)]

    def _finish(self) -> None:
        if self._open:
            print()
            self._open = False
        if self._step:
            took = time.monotonic() - self._begin
            self.took.append((self._text, took))
            print(f"      {took:.0f} s", flush=True)


def set_up_time() -> float | None:
    """How long the set-up of this checkout took [s]; None where ./flatplank has not made it."""
    file = Path(os.environ.get("FLATPLANK_ROOT", "."), ".cache", "setup-times.json")
    try:
        return float(json.loads(file.read_text(encoding="utf-8"))["set-up"])
    except (OSError, ValueError, KeyError):
        return None
