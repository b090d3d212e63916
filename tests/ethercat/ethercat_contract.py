# SPDX-License-Identifier: Apache-2.0
"""What must hold after every fault, whatever it was; the one place where it is asked for.

1. At the plant's shaft the wheel rests within 100 ms of bench time, or turns on where it may.
2. Nothing is enabled by itself, however the bus recovers and whatever the node insists on.
3. After an explicit reset the next measurement runs: the wheel turns again.

`tests/graph/test_ethercat_faults_graph.py` asks the same of the whole graph, and further that the
bag of the run is closed and readable.
"""

from __future__ import annotations

import time
from typing import Any

import pytest
from ethercat_rig import Bench

WITHIN_MS = 100.0
"""from the fault to the last motion of the wheel's shaft, in bench time"""
REST_MS = 60.0
"""a wheel that has not moved for so long rests"""
AFTER = 40
"""cycles for which the node insists after the bus is well again"""


def check_shaft(name: str, stops: bool, wheel: dict[str, Any], ran_on_ms: float) -> None:
    """1. of the contract; `wheel` is What the monitor at the plant's shaft says."""
    if not stops:
        assert wheel["moving"] and wheel["enabled"], f"{name}: stopped without need"
        return
    print(f"{name}: the wheel rests after {ran_on_ms:g} ms")
    assert not wheel["moving"] and not wheel["enabled"], f"{name}: the wheel turns on"
    assert ran_on_ms <= WITHIN_MS, f"{name}: rests after {ran_on_ms:g} ms"


class Contract:
    """Around one fault: the wheel turns at the begin; judged at the end, in which the wheel turns
    again."""

    def __init__(self, bench: Bench, name: str, stops: bool = True) -> None:
        self.bench, self.name, self.stops = bench, name, stops
        self.enables = 0
        self._recovered = False

    def __enter__(self) -> Contract:
        bench = self.bench
        bench.revive()
        self.enables = bench.emulator.wheel()["enables"]
        self.mark()
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self.recovers()
            self._measures_again()

    def mark(self) -> None:
        """The fault comes now: a word of the emulator that does nothing but note the time."""
        self.bench.emulator.send("lose_share", share=0.0)

    def new_plant(self) -> None:
        """The plant itself is another one, which has never moved nor been enabled."""
        self.enables = 0

    def rests(self, since: str = "fault_ns") -> None:
        """1.; `since`: the monitor's name of the moment at which the fault came, for one that no
        word of the emulator has made."""
        if self.stops:
            self._wait_for_rest()
        report = self.bench.emulator.send("motion")
        wheel = report["axes"]["wheel"]
        ran_on_ms = max(wheel["last_moving_ns"] - report[since], 0) / 1e6
        check_shaft(self.name, self.stops, wheel, ran_on_ms)

    def not_enabled(self) -> None:
        """2."""
        now = self.bench.emulator.wheel()["enables"]
        assert now == self.enables, f"{self.name}: enabled by itself"

    def _wait_for_rest(self) -> None:
        """In bench time; the limit by the wall is only for a test that fails."""
        end = time.monotonic() + 5
        while self.bench.emulator.wheel()["still_ms"] <= REST_MS:
            if self.bench.client.alive:
                self.bench.node.cycles(1)
            if time.monotonic() > end:
                pytest.fail(f"{self.name}: the wheel turns on: {self.bench.emulator.wheel()}")

    def recovers(self) -> None:
        """2.: what was broken is mended, the bus is well again, the node insists."""
        if self._recovered:
            return
        self._recovered = True
        bench = self.bench
        if not bench.client.alive:
            bench.new_client()  # and a new node, which has not been asked for anything yet
        bench.emulator.send("mend")
        bench.node.silent = False
        bench.node.run(lambda i: i.health == 0, seconds=10.0, what="bus well again")
        bench.node.cycles(AFTER)
        self.not_enabled()
        wheel = bench.emulator.wheel()
        report = bench.client.diagnostics()
        assert wheel["moving"] is not self.stops, f"{self.name}: {wheel}; {report}"

    def _measures_again(self) -> None:
        """3."""
        bench = self.bench
        if self.stops:
            bench.node.reset()
            bench.node.spin_up(bench.stalls)
            bench.node.cycles(5)
        wheel = bench.emulator.wheel()
        assert wheel["moving"] and wheel["enabled"], f"{self.name}: no motion after a reset"
        bench.node.rest()
        assert not bench.emulator.wheel()["moving"]
