# SPDX-License-Identifier: Apache-2.0
"""Was it the computer? What a test may be made again for, measured while it ran."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

ATTEMPTS = 4
"""a scenario during which the computer itself stalled is made again"""
LONG_STALL_S = 0.04
"""the nodes of a graph stop their axis for silences from 42 ms on, whoever was silent"""

Send = Callable[[str], dict[str, Any]]


class EmulatorStalls:
    """Counters of the emulator: it was not let run, or took a frame too late for the master, whose
    answer it then misses."""

    def __init__(self, send: Send) -> None:
        self._send = send
        self._before = self._count()

    def _count(self) -> tuple[float, ...]:
        state = self._send("state")
        return state["stalled_ms"], state["wire"]["late"]

    def __bool__(self) -> bool:
        return self._count() != self._before

    def __str__(self) -> str:
        return f"emulator: {self._before} -> {self._count()} (stalled ms, late frames)"


class LongestWait:
    """A process like any node's that naps, and says how late it was woken up at the worst."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-I", "-S", str(Path(__file__).with_name("stall_nap.py"))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.pid = self._process.pid
        self.take()

    def take(self) -> float:
        """[s], since it was asked before."""
        self._process.stdin.write("\n")
        self._process.stdin.flush()
        return float(self._process.stdout.readline())

    def __enter__(self) -> LongestWait:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.communicate()


class GraphStalls:
    """The emulator's, or one that is long enough for a node to be missed by the others."""

    def __init__(self, send: Send, waits: LongestWait) -> None:
        self._emulator, self._waits = EmulatorStalls(send), waits
        waits.take()
        self._longest = 0.0

    def __bool__(self) -> bool:
        self._longest = max(self._longest, self._waits.take())
        return self._longest > LONG_STALL_S or bool(self._emulator)

    def __str__(self) -> str:
        return f"longest stall {1e3 * self._longest:.0f} ms; {self._emulator}"


def undisturbed(measure: Callable[[], Any], scenario: Callable[[], None]) -> None:
    """Make a scenario; once more when it failed while the computer itself stalled.

    `measure` begins to look for stalls; what it returns is true when there was one.
    """
    for attempt in range(1, ATTEMPTS + 1):
        stalls = measure()
        try:
            scenario()
            return
        except (AssertionError, pytest.fail.Exception) as failure:
            timed_out = "pytest-timeout" in str(failure)  # its clock goes only once
            if timed_out or attempt == ATTEMPTS or not stalls:
                raise
            print(f"attempt {attempt} failed beside a stall: {stalls}; {failure}")
