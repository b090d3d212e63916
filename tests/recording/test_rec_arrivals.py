# SPDX-License-Identifier: Apache-2.0
"""Who has been heard, and who is waited for."""

from __future__ import annotations

import pytest

from flatplank_control.recording.bus_cycles import BEHIND_NS, Arrivals
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


def test_topics_of_every_cycle() -> None:
    at_rest, in_slip = set(at_every_cycle("off")), set(at_every_cycle("slip"))
    assert set(TOPICS) < at_rest < {t.name for t in RECORDED} and "/diagnostics" not in in_slip
    assert in_slip - at_rest == {"/slip_sequencer/state", "/wheel_drive/reference"}
