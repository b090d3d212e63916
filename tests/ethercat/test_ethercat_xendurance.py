# SPDX-License-Identifier: Apache-2.0
"""Long runs: no watchdog trip, every cycle accounted for. Never a bound on jitter: that is
printed."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parent


def check(seen: dict[str, Any], rate: int, seconds: float) -> None:
    """Each scheduled cycle was sent, each sent one came back or is counted as lost."""
    report = seen["report"]
    times = report["round_trip"]
    print(
        f"{seconds:g} s at {rate} Hz: sent {report['sent']}, received {report['received']}, lost"
        f" {report['lost']}, stalls made up for {report['missed']}, round trip p50"
        f" {times['p50_us']} us, p99 {times['p99_us']} us, max {times['max_us']} us, cycle p99"
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


def test_a_minute_at_250_hz_beside_the_other_tests(minute: subprocess.Popen[str]) -> None:
    out, errors = minute.communicate(timeout=110)
    assert minute.returncode == 0, errors
    check(json.loads(out), 250, 60)


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
@pytest.mark.timeout(800)
def test_ten_minutes_at_250_hz_on_two_busy_cores() -> None:
    check(run(600, 250, 2), 250, 600)


@pytest.mark.long
@pytest.mark.timeout(200)
def test_a_minute_at_1_khz() -> None:
    check(run(60, 1000, 0), 1000, 60)
