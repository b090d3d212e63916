# SPDX-License-Identifier: Apache-2.0
"""Faults in pairs on a running bus: none leaves the wheel turning, none enables it by itself.

Pairs and the time between their faults are drawn, other ones with FLATPLANK_SEED=N. One fault of
a pair at least stops the wheel when it comes alone; whichever comes first, the wheel rests soon
after the second one.
"""

from __future__ import annotations

import itertools
import os
import random
from typing import NamedTuple

import pytest
from ethercat_contract import Contract
from ethercat_rig import Bench
from ethercat_scenarios import SCENARIOS, Scenario
from stalls import undisturbed

SEED = int(os.environ.get("FLATPLANK_SEED", "1"))
APART = range(2, 16)
"""cycles from the first fault to the second: before the first is noticed, while the wheel brakes,
when it rests"""
SOME, MANY = 4, 120


class Pair(NamedTuple):
    """Two faults."""

    first: Scenario
    second: Scenario
    apart: int
    """cycles between the two"""

    def __str__(self) -> str:
        return f"{self.first.name}, {self.apart} cycles later {self.second.name}"


def drawn() -> list[Pair]:
    """Pairs of this seed."""
    draw = random.Random(SEED)
    ordered = [p for p in itertools.permutations(SCENARIOS, 2) if any(s.stops for s in p)]
    return [Pair(*pair, draw.choice(APART)) for pair in draw.sample(ordered, MANY)]


DRAWN = drawn()


def both(bench: Bench, pair: Pair) -> None:
    """Two faults, mended together; judged by the contract of a single one."""
    first, second, apart = pair
    with Contract(bench, str(pair)) as contract:
        bench.emulator.send(first.fault, **first.arguments)
        bench.node.cycles(apart)
        bench.emulator.send(second.fault, **second.arguments)
        bench.node.cycles(max(first.cycles, second.cycles))
        contract.recovers()
        contract.rests()


BY_NAME = {s.name: s for s in SCENARIOS}


@pytest.mark.parametrize("restart", ["drive restarts", "drive without power"])
def test_a_drive_that_has_restarted_has_its_watchdog_again(bench: Bench, restart: str) -> None:
    """A slave comes back with the watchdog of its maker: 100 ms, far more than the bus file's."""

    def one_after_the_other() -> None:
        for name in (restart, "a wire that passes nothing"):
            fault = BY_NAME[name]
            with Contract(bench, name) as contract:
                bench.emulator.send(fault.fault, **fault.arguments)
                bench.node.cycles(fault.cycles)
                contract.recovers()
                contract.rests()

    undisturbed(bench.stalls, one_after_the_other)


@pytest.mark.parametrize("pair", DRAWN[:SOME], ids=str)
def test_two_faults(bench: Bench, pair: Pair) -> None:
    undisturbed(bench.stalls, lambda: both(bench, pair))


@pytest.mark.long
@pytest.mark.timeout(3600)
def test_many_pairs_of_faults(bench: Bench) -> None:
    failed = []
    for done, pair in enumerate(DRAWN, 1):
        try:
            undisturbed(bench.stalls, lambda pair=pair: both(bench, pair))
        except (AssertionError, pytest.fail.Exception) as error:
            failed.append(f"{pair}: {error}".splitlines()[0])
        print(f"seed {SEED}: {done} of {MANY} pairs, {len(failed)} failed", flush=True)
    assert not failed, "\n".join(failed)
