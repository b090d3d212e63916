# SPDX-License-Identifier: Apache-2.0
"""An emulated bus that waits for its nodes: as long as they live, and no longer."""

from __future__ import annotations

import time
from collections import deque

from flatplank_hw.bus.image import AxisCommand
from flatplank_hw.ethercat.master.waiting import Waiting

PATIENCE_S = 0.08


class Nodes:
    """What comes, look by look; nothing when the list is over."""

    def __init__(self, *looks: list[int]) -> None:
        self._looks = deque(looks)

    def take(self, _seconds: float) -> list[AxisCommand]:
        cycles = self._looks.popleft() if self._looks else []
        return [AxisCommand(0, cycle, 0, 9, 0, 0, 0, 0) for cycle in cycles]


def always() -> bool:
    return True


def test_nobody_has_answered_yet() -> None:
    waiting = Waiting(PATIENCE_S)
    assert waiting.hold(5, Nodes().take, always) == []
    assert (waiting.waited_ns, waiting.given_up) == (0, 0)


def test_a_real_bus_never_waits() -> None:
    waiting = Waiting(0.0)
    assert len(waiting.hold(5, Nodes([1]).take, always)) == 1
    assert (waiting.waited_ns, waiting.given_up) == (0, 0)


def test_waits_for_the_answer_to_the_last_cycle() -> None:
    waiting = Waiting(PATIENCE_S)
    found = waiting.hold(5, Nodes([1], [2], [], [3, 4], [5]).take, always)
    assert [c.cycle for c in found] == [1, 2, 3, 4]
    assert waiting.given_up == 0


def test_a_batch_is_answered_once() -> None:
    waiting = Waiting(PATIENCE_S, batch=4)
    assert [c.cycle for c in waiting.hold(7, Nodes([3]).take, always)] == [3]
    assert waiting.lacking(8) == [0]


def test_who_is_silent_delays_the_bus_only_for_a_moment() -> None:
    """Also one that answers each cycle only after the next one: its source is dead."""
    waiting = Waiting(PATIENCE_S)
    start = time.perf_counter()
    for cycle in range(2, 22):
        waiting.hold(cycle, Nodes([cycle - 2]).take, always)
    assert time.perf_counter() - start < 10 * PATIENCE_S
    assert waiting.given_up == 20
    waiting.hold(22, Nodes([21]).take, always)
    assert waiting.given_up == 20


def test_an_end_is_not_waited_for() -> None:
    waiting = Waiting(60.0)
    waiting.hold(5, Nodes([1]).take, lambda: False)
    assert waiting.given_up == 0
