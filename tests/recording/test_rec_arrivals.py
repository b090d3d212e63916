# SPDX-License-Identifier: Apache-2.0
"""Who has been heard, and who is waited for."""

from __future__ import annotations

import pytest

from flatplank_control.recording.bus_cycles import BEHIND_NS, Arrivals, BenchClock
from flatplank_control.recording.topics import RECORDED, at_every_cycle

PERIOD_NS = 4_000_000
BUS, ENCODERS, HUB = TOPICS = ("/bus/inputs", "/encoders/state", "/measurement_hub/state")


@pytest.fixture
def arrivals() -> Arrivals:
    """One cycle in which all have spoken."""
    arrivals = Arrivals()
    for topic in TOPICS:
        arrivals.add(topic, PERIOD_NS)
    return arrivals


def test_all_are_waited_for_up_to_a_stamp(arrivals: Arrivals) -> None:
    assert arrivals.behind(PERIOD_NS, TOPICS) == []
    assert arrivals.behind(2 * PERIOD_NS, TOPICS) == list(TOPICS)
    arrivals.add(BUS, 3 * PERIOD_NS)
    arrivals.add(ENCODERS, 2 * PERIOD_NS)
    assert arrivals.behind(2 * PERIOD_NS, TOPICS) == [HUB]
    arrivals.add(HUB, 2 * PERIOD_NS)
    assert arrivals.behind(2 * PERIOD_NS, TOPICS) == []


def test_diagnostics_are_put_at_the_cycle(arrivals: Arrivals) -> None:
    assert arrivals.add("/diagnostics", 10**18) == PERIOD_NS


def test_who_was_never_heard_is_behind(arrivals: Arrivals) -> None:
    assert arrivals.behind(0, [*TOPICS, "/wheel_drive/status"]) == []
    arrivals.add(BUS, PERIOD_NS + BEHIND_NS)
    assert arrivals.behind(0, [*TOPICS, "/wheel_drive/status"]) == ["/wheel_drive/status"]


def test_who_falls_silent_is_behind(arrivals: Arrivals) -> None:
    arrivals.add(BUS, PERIOD_NS + BEHIND_NS)
    assert arrivals.behind(0, TOPICS) == []
    arrivals.add(BUS, 2 * PERIOD_NS + BEHIND_NS)
    assert arrivals.behind(0, TOPICS) == [ENCODERS, HUB]


def test_without_a_bus_nobody_is_expected() -> None:
    assert Arrivals().behind(0, TOPICS) == []


MS = 1_000_000
BOOT_NS, BENCH_NS = 5 * 10**12, 1_700_000_000 * 10**9
"""monotonic clock and bench time of the first cycle [ns]"""


def test_in_real_time_a_message_is_late_by_its_way() -> None:
    """Every third cycle is on its way for 3 ms, and so is what a node computes from each."""
    arrivals = Arrivals()
    arrivals.real_time = True
    delays: dict[str, set[int]] = {BUS: set(), HUB: set()}
    for i in range(600):
        stamp, now = BENCH_NS + i * PERIOD_NS, BOOT_NS + i * PERIOD_NS + 3 * MS * (i % 3 == 2)
        for topic, at in ((BUS, now), (HUB, now + MS)):
            delays[topic].add(arrivals.received(topic, stamp, at) - stamp)
    assert delays == {BUS: {0, 3 * MS}, HUB: {MS, 4 * MS}}


@pytest.mark.parametrize("behind", [50 * MS, 5000 * MS, -5000 * MS])
def test_cycles_that_a_bus_leaves_out_are_no_delay_for_good(behind: int) -> None:
    clock = BenchClock()
    for i in range(1000):
        stamp, now = BENCH_NS + i * PERIOD_NS - behind * (i > 300), BOOT_NS + i * PERIOD_NS
        clock.add(stamp, now)
        late = clock.time(now) - stamp
        assert 0 <= late <= abs(behind)
    assert late == 0


def test_without_real_time_bench_time_stands_while_a_message_is_on_its_way() -> None:
    arrivals = Arrivals()
    for i in range(10):
        stamp = i * PERIOD_NS
        assert arrivals.received(BUS, stamp, BOOT_NS + 7 * i) == stamp
        assert arrivals.received(HUB, stamp, BOOT_NS + 7 * i + MS) == stamp


def test_topics_of_every_cycle() -> None:
    at_rest, in_slip = set(at_every_cycle("off")), set(at_every_cycle("slip"))
    assert set(TOPICS) < at_rest < {t.name for t in RECORDED} and "/diagnostics" not in in_slip
    assert in_slip - at_rest == {"/slip_sequencer/state", "/wheel_drive/reference"}
