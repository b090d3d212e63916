# SPDX-License-Identifier: Apache-2.0
"""Health of the bus cycle by cycle, its reason in words, and when a step of recovery is taken."""

from __future__ import annotations

import pytest

from flatplank_hw.bus.image import Health
from flatplank_hw.ethercat.master.health import (
    CycleObservation,
    HealthMonitor,
    RecoveryPolicy,
    RecoveryStep,
    SlaveState,
    describe_slaves,
)

GOOD, LOST = CycleObservation(True, 11, True), CycleObservation(False, 0, True)
SHORT, OLD = CycleObservation(True, 10, True), CycleObservation(True, 11, False)
OLD_SHORT = CycleObservation(True, 9, False)
FALLEN = SlaveState("bridges_a", 0x14, 0x1B, "watchdog")
LETTERS = {"G": GOOD, "L": LOST, "S": SHORT, "O": OLD, "o": OLD_SHORT}


@pytest.mark.parametrize(
    ("seen", "healths", "counts"),
    [  # sent, received, lost, wrong counter, stale
        ("GGG", "OOO", (3, 3, 0, 0, 0)), ("LLLL", "DDLL", (4, 0, 4, 0, 0)),
        ("SSSG", "DDLO", (4, 4, 0, 3, 0)), ("LSLS", "DDLL", (4, 2, 2, 2, 0)),
        ("OGO", "SOS", (3, 3, 0, 0, 2)), ("oooL", "SSSL", (4, 3, 1, 3, 3)),
        ("LLOLL", "DDSDD", (5, 1, 4, 0, 1)), ("LGLGLG", "DODODO", (6, 3, 3, 0, 0)),
    ],
)  # fmt: skip
def test_health_by_what_is_seen(seen, healths, counts):
    """G good, L lost, S too few slaves, O an older answer, o an older one of too few slaves."""
    monitor = HealthMonitor(11)
    found = [monitor.observe(LETTERS[letter]) for letter in seen]
    assert "".join(health.name[0] for health in found) == healths
    m = monitor
    assert (m.sent, m.received, m.lost, m.wrong_counter, m.stale) == counts
    assert m.history == {
        health.name: found.count(health) for health in dict.fromkeys(found)
    }  # fmt: skip
    assert m.states_in_doubt == (seen[-1] not in "GO")


@pytest.mark.parametrize(
    ("seen", "link", "faulty", "health", "reason"),
    [
        ("G", "no link", False, Health.OK, ""),
        ("L", "no link", False, Health.DEGRADED, ""),
        ("LLL", "", False, Health.LOST, "no answer for 3 cycles"),
        ("LLLL", "no link", False, Health.LOST, "no answer for 4 cycles; no link"),
        ("SSS", "no link", False, Health.LOST, "working counter 10 of 11"),
        ("LLL", "no link", True, Health.LOST,
         "no answer for 3 cycles; no link; bridges_a: SAFEOP with error 0x001B (watchdog)"),
        ("SSS", "", True, Health.LOST,
         "working counter 10 of 11; bridges_a: SAFEOP with error 0x001B (watchdog)"),
        ("G", "", True, Health.SLAVE_FAULT, "bridges_a: SAFEOP with error 0x001B (watchdog)"),
        ("LL", "", True, Health.SLAVE_FAULT, "bridges_a: SAFEOP with error 0x001B (watchdog)"),
        ("LLLO", "", True, Health.STALE, "answers belong to an older cycle"),
        ("LLLG", "", False, Health.OK, ""),
        ("LLLGL", "", False, Health.DEGRADED, ""),
        ("LLLSG", "no link", False, Health.OK, ""),
    ],
)  # fmt: skip
def test_the_reason_in_words(seen, link, faulty, health, reason):
    monitor = HealthMonitor(11)
    monitor.link = link
    monitor.register_states((FALLEN,) if faulty else (SlaveState("drive", 8, 0, ""),))
    assert [monitor.observe(LETTERS[letter]) for letter in seen][-1] == health
    assert monitor.reason == reason


@pytest.mark.parametrize(
    ("state", "text"),
    [(0, "no answer"), (1, "INIT"), (2, "PREOP"), (3, "BOOT"), (4, "SAFEOP"), (8, "OP"),
     (0x12, "PREOP with error 0x0021 (why)"), (0x18, "OP with error 0x0021 (why)"),
     (0x05, "0x5"), (0x25, "0x25"), (0x10, "no answer with error 0x0021 (why)")],
)  # fmt: skip
def test_a_state_in_words(state, text):
    assert describe_slaves((SlaveState("drive", state, 0x21, "why"),)) == f"drive: {text}"


def test_several_slaves_in_words_and_those_in_op_are_no_fault():
    states = (SlaveState("a", 1, 0, ""), SlaveState("b", 8, 0, ""), SlaveState("c", 0x18, 2, "x"))
    assert describe_slaves(states) == "a: INIT, b: OP, c: OP with error 0x0002 (x)"
    monitor = HealthMonitor(11)
    monitor.register_states(states)
    assert [s.name for s in monitor.faulty] == ["a", "c"]


NONE, REOPEN, ACK = RecoveryStep.NONE, RecoveryStep.REOPEN, RecoveryStep.ACKNOWLEDGE
SETUP, RESCAN = RecoveryStep.RECONFIGURE, RecoveryStep.RESCAN
BAD = Health.SLAVE_FAULT


@pytest.mark.parametrize(
    "calls",
    [
        # a slave in SAFEOP: after 0.3 s to stop, a step each 0.25 s, a scan each second
        [(10.0, BAD, (0x14,), False, NONE), (10.29, BAD, (0x14,), False, NONE),
         (10.31, BAD, (0x14,), False, ACK), (10.55, BAD, (0x14,), False, NONE),
         (10.57, BAD, (0x14,), False, SETUP), (10.81, BAD, (0x14,), False, NONE),
         (10.83, BAD, (0x14,), False, RESCAN), (11.82, BAD, (0x14,), False, NONE),
         (11.84, BAD, (0x14,), False, RESCAN), (12.83, BAD, (0x14,), False, NONE),
         (12.85, BAD, (0x14,), False, RESCAN)],
        # a slave of several that lost its state is configured at once
        [(0.0, BAD, (0x14, 0x02), False, NONE), (0.31, BAD, (0x14, 0x02), False, SETUP)],
        [(0.0, BAD, (0x04, 0x14), False, NONE), (0.31, BAD, (0x04, 0x14), False, ACK),
         (0.57, BAD, (0x04, 0x02), False, SETUP)],
        # without a slave that is not in OP there is nothing to do
        [(0.0, Health.LOST, (), False, NONE), (9.0, Health.LOST, (), False, NONE)],
        # a silent wire: the socket is opened again once, then the slaves are looked for
        [(0.0, Health.LOST, (), True, NONE), (0.29, Health.LOST, (), True, NONE),
         (0.31, Health.LOST, (), True, REOPEN), (0.32, Health.LOST, (), True, NONE),
         (0.33, Health.LOST, (0,), True, SETUP), (0.57, Health.LOST, (0,), True, NONE),
         (0.59, Health.LOST, (0,), True, RESCAN)],
        # old answers: the socket is opened again every 20 ms, at once
        [(5.0, Health.STALE, (), False, REOPEN), (5.019, Health.STALE, (), False, NONE),
         (5.021, Health.STALE, (0x14,), False, REOPEN)],
        # the time to stop begins with the fault, whatever it is
        [(0.0, Health.STALE, (), False, REOPEN), (0.31, BAD, (0x14,), False, ACK)],
        [(0.0, BAD, (0x14,), False, NONE), (0.31, BAD, (0x14,), False, ACK),
         (0.4, Health.STALE, (0x14,), False, REOPEN), (0.42, BAD, (0x14,), False, ACK)],
        # what is well, or tolerated, starts everything over
        [(0.0, BAD, (0x14,), False, NONE), (0.31, BAD, (0x14,), False, ACK),
         (0.4, Health.DEGRADED, (0x14,), False, NONE), (0.6, BAD, (0x14,), False, NONE),
         (0.89, BAD, (0x14,), False, NONE), (0.91, BAD, (0x14,), False, ACK)],
        [(0.0, BAD, (0x14,), False, NONE), (0.2, Health.OK, (), False, NONE),
         (0.31, BAD, (0x14,), False, NONE)],
    ],
)  # fmt: skip
def test_when_a_step_is_taken(calls):
    policy = RecoveryPolicy()
    taken = [policy.step(*given) for *given, _ in calls]
    assert taken == [expected for *_, expected in calls]
    steps = [step.name for step in taken if step]
    assert policy.taken == {name: steps.count(name) for name in dict.fromkeys(steps)}


def test_the_first_step_may_be_taken_at_any_time_of_the_clock():
    assert RecoveryPolicy().step(0.001, Health.STALE, ()) == REOPEN
