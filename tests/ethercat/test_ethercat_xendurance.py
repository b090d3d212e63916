# SPDX-License-Identifier: Apache-2.0
"""Long runs: no watchdog trip, every cycle accounted for. Never a bound on jitter: that is
printed. A run in which the bus process itself was not scheduled for several cycles is made again:
a computer that stands still for longer than the watchdog allows trips it, as it must."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterable, Iterator
from itertools import count
from pathlib import Path
from typing import Any

import pytest
from stalls import undisturbed

HERE = Path(__file__).parent


def check(seen: dict[str, Any], rate: int, seconds: float) -> None:
    """Each scheduled cycle was sent, each sent one came back or is counted as lost."""
    report = seen["report"]
    times = report["round_trip"]
    print(
        f"{seconds:g} s at {rate} Hz: sent {report['sent']}, received {report['received']}, lost"
        f" {report['lost']}, stalls made up for {report['missed']}, round trip p50"
        f" {times['p50_us']} us, p99 {times['p99_us']} us, max {times['worst_us']} us, cycle p99"
        f" {report['cycle_time']['p99_us']} us ({report['scheduling']})"
    )
    assert seen["trips"] == 0 and seen["states"] == ["OP"]
    assert report["sent"] == report["received"] + report["lost"]
    assert report["sent"] == report["cycle"], "no number left out"
    assert sum(report["history"].values()) == report["sent"]
    start = seen["wire"]["process_data"] - report["sent"]
    assert 0 <= start <= 20, "the emulator has seen every frame, and some before the first cycle"
    assert seen["gaps"] == 0 and report["unread"] == 0, "the node has read every image"
    assert report["sent"] + report["missed"] >= 0.99 * rate * seconds


class MasterStalls:
    """True when the bus process of the run had to drop cycles."""

    def __init__(self) -> None:
        self.missed = 0

    def __bool__(self) -> bool:
        return self.missed > 0

    def __str__(self) -> str:
        return f"bus process: {self.missed} cycles dropped"


def check_undisturbed(accounts: Iterable[dict[str, Any]], rate: int, seconds: float) -> None:
    """Check the first account of a run without a stall."""
    stalls, left = MasterStalls(), iter(accounts)

    def scenario() -> None:
        seen = next(left)
        stalls.missed = seen["report"]["missed"]
        check(seen, rate, seconds)

    undisturbed(lambda: stalls, scenario)


def test_a_minute_at_250_hz_beside_the_other_tests(minute: subprocess.Popen[str]) -> None:
    def accounts() -> Iterator[dict[str, Any]]:
        out, errors = minute.communicate()
        assert minute.returncode == 0, errors
        yield json.loads(out)
        while True:
            yield run(60, 250, 0)

    check_undisturbed(accounts(), 250, 60)


def run(seconds: float, rate: int, busy: int) -> dict[str, Any]:
    words = [
        sys.executable,
        str(HERE / "ethercat_endurance.py"),
        str(seconds),
        str(rate),
        str(busy),
    ]
    result = subprocess.run(words, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    return json.loads(result.stdout)


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_ten_minutes_at_250_hz_on_two_busy_cores() -> None:
    check_undisturbed((run(600, 250, 2) for _ in count()), 250, 600)


@pytest.mark.long
def test_a_minute_at_1_khz() -> None:
    check_undisturbed((run(60, 1000, 0) for _ in count()), 1000, 60)
