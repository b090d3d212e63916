# SPDX-License-Identifier: Apache-2.0
"""Numbered steps of a long job on the terminal."""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from collections.abc import Sequence
from pathlib import Path

QUIET = 4.0
"""duration without a line after which the last one is repeated with the time that it takes [s]"""


class StepPrinter:
    """Prints numbered steps, each with its progress and duration; never silent for long."""

    def __init__(self, steps: int, quiet: float = QUIET) -> None:
        """quiet: longest silence [s]."""
        self._steps, self._quiet = steps, quiet
        self._step = 0
        self._first = self._begin = self._said = time.monotonic()
        self._open = False
        self._text = self._progress = ""
        self._lock, self._ended = threading.RLock(), threading.Event()
        self.took: list[tuple[str, float]] = []
        """completed steps, each with its duration [s]"""

    def __enter__(self) -> StepPrinter:
        threading.Thread(target=self._beat, daemon=True).start()
        return self

    def __exit__(self, *_error: object) -> None:
        self._ended.set()

    def step(self, text: str, began: float | None = None) -> None:
        """Begin a new step; `began`: where it was begun before, beside others, by the monotonic
        clock [s]."""
        with self._lock:
            now = time.monotonic()
            began = now if began is None else began
            # a step that was begun earlier than the one that ends is no step after it
            self.end_step(began if began > self._begin else now)
            self._step += 1
            self._text = self._progress = text
            self._begin, self._said = began, now
            print(f"[{self._step}/{self._steps}] {text}", flush=True)

    def print_progress(self, text: str) -> None:
        """Print the progress; on a terminal the line is overwritten."""
        self._progress = text
        self._print(text)

    def _print(self, text: str) -> None:
        with self._lock:
            self._said = time.monotonic()
            if sys.stdout.isatty():
                print(f"\r\033[K      {text}", end="", flush=True)
                self._open = True
            else:
                print(f"      {text}", flush=True)

    def _beat(self) -> None:
        """Repeat the last line where nothing else was said for a while."""
        while not self._ended.wait(max(self._said + self._quiet - time.monotonic(), 0.01)):
            now = time.monotonic()
            if self._step and now - self._said >= self._quiet:
                self._print(f"{self._progress} ({now - self._begin:.0f} s of this step)")

    def count(self, done: int, total: int, name: str) -> None:
        """Print the progress of many equal tasks."""
        if sys.stdout.isatty() or done == total or done % 9 == 0:
            self.print_progress(f"{done}/{total} {name}")

    def close(self, lines: Sequence[str]) -> None:
        """Print the closing lines, with the durations of the steps."""
        self._ended.set()
        with self._lock:
            self.end_step(time.monotonic())
        print("\n" + "\n".join([*lines, *self._times()]), flush=True)

    def _times(self) -> list[str]:
        rows = [(f"[{i}] {text}", seconds) for i, (text, seconds) in enumerate(self.took, 1)]
        rows.append(("all of the demo, with parts beside each other", self._end - self._first))
        if (set_up := set_up_time()) is not None:
            rows.append(("set-up before the first start (tools/setup)", set_up))
        return ["times:", *(f"  {seconds:5.0f} s  {text}" for text, seconds in rows)]

    def end_step(self, ended: float) -> None:
        """End the present step, if there is one, at a time of the monotonic clock [s]."""
        with self._lock:
            if self._open:
                print()
                self._open = False
            self._end = time.monotonic()
            if len(self.took) < self._step:
                took = ended - self._begin
                self.took.append((self._text, took))
                print(f"      {took:.0f} s", flush=True)


def set_up_time() -> float | None:
    """Duration of the set-up of this checkout [s]; None when ./flatplank has not made it."""
    file = Path(os.environ.get("FLATPLANK_ROOT", "."), ".cache", "setup-times.json")
    try:
        return float(json.loads(file.read_text(encoding="utf-8"))["set-up"])
    except (OSError, ValueError, KeyError):
        return None
