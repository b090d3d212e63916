# SPDX-License-Identifier: Apache-2.0
"""Who has been heard, and who is waited for."""

from __future__ import annotations

import pytest

from flatplank_control.recording.arrivals import BEHIND_NS, Arrivals
from flatplank_control.topics import EVERY_CYCLE, RECORDED

PERIOD_NS = 4_000_000
TOPICS = ("/bus/inputs", "/encoders/state", "/measurement_hub/state")


@pytest.fixture
def arrivals() -> Arrivals:
    """One cycle in which all have spoken."""
    arrivals = Arrivals()
    for topic in TOPICS:
        arrivals.add(topic, PERIOD_NS)
    return arrivals


def test_cycle_is_complete_when_all_have_spoken(arrivals: Arrivals) -> None:
    assert arrivals.complete(PERIOD_NS)
    arrivals.add("/bus/inputs", 2 * PERIOD_NS)
    arrivals.add("/encoders/state", 2 * PERIOD_NS)
    assert not arrivals.complete(2 * PERIOD_NS)
    arrivals.add("/measurement_hub/state", 2 * PERIOD_NS)
    assert arrivals.complete(2 * PERIOD_NS)
    assert not arrivals.complete(3 * PERIOD_NS)


def test_diagnostics_are_put_at_the_cycle(arrivals: Arrivals) -> None:
    assert arrivals.add("/diagnostics", 10**18) == PERIOD_NS


def test_who_was_never_heard_is_silent(arrivals: Arrivals) -> None:
    assert arrivals.silent(TOPICS) == []
    assert arrivals.silent([*TOPICS, "/wheel_drive/status"]) == ["/wheel_drive/status"]


def test_who_falls_behind_is_silent(arrivals: Arrivals) -> None:
    arrivals.add("/bus/inputs", PERIOD_NS + BEHIND_NS)
    assert arrivals.silent(TOPICS) == []
    arrivals.add("/bus/inputs", 2 * PERIOD_NS + BEHIND_NS)
    assert arrivals.silent(TOPICS) == ["/encoders/state", "/measurement_hub/state"]
    arrivals.add("/encoders/state", 2 * PERIOD_NS + BEHIND_NS)
    assert arrivals.silent(TOPICS) == ["/measurement_hub/state"]


def test_without_a_bus_nobody_is_expected() -> None:
    assert Arrivals().silent(TOPICS) == []


def test_topics_of_every_cycle() -> None:
    assert set(TOPICS) < set(EVERY_CYCLE) < {t.name for t in RECORDED}
    assert "/slip_sequencer/state" not in EVERY_CYCLE and "/diagnostics" not in EVERY_CYCLE
