# SPDX-License-Identifier: Apache-2.0
"""An emulated bus that waits for its nodes: as long as they live, and no longer.

The clock is that of the test: a computer that is slow changes nothing.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable

import pytest

from flatplank_hw.bus.image import AxisCommand
from flatplank_hw.ethercat.master import pacing
from flatplank_hw.ethercat.master.pacing import AnswerWait

TIMEOUT_S = 0.08


class Clock:
    """Stands in for the module `time`: only who sleeps or waits lets time go by."""

    def __init__(self) -> None:
        self.now_ns = 1_000_000_000

    def perf_counter_ns(self) -> int:
        return self.now_ns

    def sleep(self, seconds: float) -> None:
        self.now_ns += round(seconds * 1e9)


CLOCK = Clock()


@pytest.fixture(autouse=True)
def own_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pacing, "time", CLOCK)


class Nodes:
    """What comes, look by look; when the list is over, nothing comes in the time of a look."""

    def __init__(self, *looks: list[int]) -> None:
        self._looks = deque(looks)

    def take(self, seconds: float) -> list[AxisCommand]:
        if not self._looks:
            CLOCK.sleep(seconds)
        cycles = self._looks.popleft() if self._looks else []
        return [AxisCommand(0, cycle, 0, 9, 0, 0, 0, 0) for cycle in cycles]


def always() -> bool:
    return True


def hold(
    waiting: AnswerWait, cycle: int, nodes: Nodes, go_on: Callable[[], bool] = always
) -> list[AxisCommand]:
    """A cycle that began just now and is over."""
    now = CLOCK.now_ns
    return waiting.wait_for_cycle(cycle, now, now, nodes.take, go_on)


def test_nobody_has_answered_yet() -> None:
    waiting = AnswerWait(TIMEOUT_S)
    assert hold(waiting, 5, Nodes()) == []
    assert (waiting.waited_ns, waiting.given_up) == (0, 0)


def test_a_real_bus_never_waits() -> None:
    waiting = AnswerWait(0.0)
    assert len(hold(waiting, 5, Nodes([1]))) == 1
    assert (waiting.waited_ns, waiting.given_up) == (0, 0)


def test_waits_for_the_answer_to_the_last_cycle() -> None:
    waiting = AnswerWait(TIMEOUT_S)
    found = hold(waiting, 5, Nodes([1], [2], [], [3, 4]))
    assert [c.cycle for c in found] == [1, 2, 3, 4]
    assert waiting.given_up == 0


def test_a_batch_is_answered_once() -> None:
    waiting = AnswerWait(TIMEOUT_S, batch=4)
    assert [c.cycle for c in hold(waiting, 7, Nodes([3]))] == [3]
    assert waiting.axes_without_answer(8) == [0]


def test_who_is_silent_delays_the_bus_only_for_a_moment() -> None:
    """Also one that answers each cycle only after the next one: its source is dead."""
    waiting = AnswerWait(TIMEOUT_S)
    start = CLOCK.now_ns
    for cycle in range(2, 22):
        hold(waiting, cycle, Nodes([cycle - 2]))
    # the whole time first, then half of the last one, and in the end 10 ms
    assert (CLOCK.now_ns - start) / 1e6 == pytest.approx(80 + 40 + 20 + 17 * 10)
    assert waiting.given_up == 20
    hold(waiting, 22, Nodes([21]))
    assert waiting.given_up == 20


def test_an_end_is_not_waited_for() -> None:
    waiting = AnswerWait(60.0)
    hold(waiting, 5, Nodes([1]), lambda: False)
    assert waiting.given_up == 0


PERIOD_NS = 40_000_000


class Slow(Nodes):
    """One axis that answers a cycle so long after its start."""

    def __init__(self, seconds: float) -> None:
        super().__init__()
        self._at = CLOCK.now_ns + round(seconds * 1e9)

    def take(self, seconds: float) -> list[AxisCommand]:
        CLOCK.sleep(max(min(seconds, (self._at - CLOCK.now_ns) * 1e-9), 0.0))
        if self._at > CLOCK.now_ns:
            return []
        self._at = math.inf
        return [AxisCommand(0, 5, 0, 9, 0, 0, 0, 0)]


@pytest.mark.parametrize(("answer_s", "periods"), [(0.005, 1.0), (0.03, 1.5), (0.06, 3.0)])
def test_a_late_answer_makes_the_cycle_twice_as_long_as_the_answer(answer_s, periods) -> None:
    """Answers take at most half of the time: the rest is for who only listens."""
    waiting = AnswerWait(1.0)
    hold(waiting, 5, Nodes([4]))
    begun = CLOCK.now_ns
    found = waiting.wait_for_cycle(6, begun, begun + PERIOD_NS, Slow(answer_s).take, always)
    assert [c.cycle for c in found] == [5]
    assert CLOCK.now_ns - begun == periods * PERIOD_NS
    assert waiting.waited_ns == (periods - 1.0) * PERIOD_NS
