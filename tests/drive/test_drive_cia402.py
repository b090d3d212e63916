# SPDX-License-Identifier: Apache-2.0
"""CiA 402: every status word, every transition."""

from __future__ import annotations

import pytest

from flatplank_hw.cia402 import PATTERNS, TRANSITIONS, Goal, State, control_word, decode

BOOK = {
    "x0xx0000": State.NOT_READY,
    "x1xx0000": State.SWITCH_ON_DISABLED,
    "x01x0001": State.READY_TO_SWITCH_ON,
    "x01x0011": State.SWITCHED_ON,
    "x01x0111": State.OPERATION_ENABLED,
    "x00x0111": State.QUICK_STOP_ACTIVE,
    "x0xx1111": State.FAULT_REACTION_ACTIVE,
    "x0xx1000": State.FAULT,
}
"""Low byte of the status word per state, as the profile prints it."""


def by_the_book(word: int) -> State:
    bits = f"{word & 0xFF:08b}"
    hits = [
        state
        for pattern, state in BOOK.items()
        if all(p in ("x", b) for p, b in zip(pattern, bits, strict=True))
    ]
    return hits[0] if hits else State.NOT_READY


def test_all_status_words():
    assert all(decode(word) is by_the_book(word) for word in range(0x10000))


def test_patterns_exclude_each_other():
    for word in range(0x80):
        assert sum(word & mask == value for mask, value, _ in PATTERNS) <= 1


@pytest.mark.parametrize("goal", Goal)
def test_every_state_has_a_control_word(goal):
    assert set(TRANSITIONS[goal]) == set(State)


def test_nothing_but_enabled_switches_power_on():
    for goal in (Goal.DISABLED, Goal.QUICK_STOP, Goal.RESET):
        for state in State:
            assert control_word(state, goal) & 0x0F not in (0x07, 0x0F)


def test_fault_is_reset_by_bit_7_only_when_asked():
    for goal in Goal:
        for state in State:
            bit = control_word(state, goal) & 0x80
            assert bool(bit) == (goal is Goal.RESET and state is State.FAULT)


def test_way_up():
    states = [State.SWITCH_ON_DISABLED, State.READY_TO_SWITCH_ON, State.SWITCHED_ON]
    assert [control_word(s, Goal.ENABLED) for s in states] == [0x06, 0x07, 0x0F]
