# SPDX-License-Identifier: Apache-2.0
"""A source works from the first cycle whose reference its drive awaits, whatever arrives first."""

from __future__ import annotations

import itertools

import pytest

from flatplank_control.nodes.source import SourceNode
from flatplank_hw.nodes.convert import StampedMode, StampedWrench
from flatplank_hw.samples import EncoderSample, Reference, Wrench

ENCODERS = EncoderSample(0, 0, *[0.0] * 9, True, False, 0.0)


class Core:
    def reset(self) -> None:
        pass


class Source(SourceNode):
    """A source without its node: what it would publish is kept."""

    MODE = "follow"

    def __init__(self) -> None:
        self.core, self.active, self.early = Core(), False, {}
        self.sent: list[int] = []
        self.publish = lambda reference: self.sent.append(reference.stamp_ns)

    def compute(self, latest) -> Reference:
        return Reference(0, latest["encoders"].stamp_ns, "follow", 0.0, True)


def arrivals(cycle: int) -> list:
    """What a source hears of a cycle, and how."""
    wrench = StampedWrench(cycle, Wrench(*[0.0] * 6))
    return [
        ("encoders", lambda s: s.on_encoders(ENCODERS._replace(stamp_ns=cycle))),
        ("contact", lambda s: s.take("contact", wrench.stamp_ns, wrench.wrench)),
    ]


ORDERS = list(itertools.permutations(range(3)))


@pytest.mark.parametrize("order", ORDERS)
def test_the_first_awaited_cycle_gets_its_reference_in_every_order(order):
    source = Source()
    for cycle in (8, 9):
        for _name, hear in arrivals(cycle):
            hear(source)
    assert source.sent == []
    after = [*(hear for _, hear in arrivals(10)), lambda s: s.on_mode(StampedMode(9, "follow"))]
    for k in order:
        after[k](source)
    assert source.sent == [10]


def test_a_source_that_hears_its_mode_in_time_makes_nothing_of_cycles_before_it():
    source = Source()
    for _name, hear in arrivals(9):
        hear(source)
    source.on_mode(StampedMode(9, "follow"))
    assert source.sent == []
    for _name, hear in arrivals(10):
        hear(source)
    source.on_mode(StampedMode(10, "velocity"))
    for _name, hear in arrivals(11):
        hear(source)
    assert source.sent == [10]
