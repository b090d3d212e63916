# SPDX-License-Identifier: Apache-2.0
"""A bench on an emulated bus for tests: namespace, emulator process, bus process, and a node by
hand."""

from __future__ import annotations

import contextlib
import gc
import os
import select
import subprocess
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from stalls import ATTEMPTS, EmulatorStalls

from flatplank_hw.bus.image import AXES, AxisCommand, AxisInputs, BusInputs, Digital, Health
from flatplank_hw.ethercat.master import BusClient
from flatplank_sim.emulated import MASTER, BenchNamespace, EmulatorProcess, NamespaceError

BUS_FILES = Path(__file__).parents[2] / "ros_ws/src/flatplank_hw/config/bus"
BENCH = BUS_FILES / "bench.yaml"
TURNING = 200_000_000
"""motor speed of about 0.1 rad/s at the wheel [counts/s]"""
VELOCITY_MODE = 9
ENABLED, RUN = 0x0237, 0x0F
_UPWARD = {0x40: 0x06, 0x60: 0x06, 0x21: 0x07, 0x23: 0x0F, 0x27: 0x0F}


def be_first(on: bool) -> None:
    """Real-time scheduling for this thread, where allowed."""
    policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK if on else os.SCHED_OTHER
    with contextlib.suppress(PermissionError):
        os.sched_setscheduler(0, policy, os.sched_param(30 if on else 0))


def be_quick(on: bool) -> None:
    """Real-time scheduling for the node by hand, where allowed, and no garbage collector: no stall
    of its own may spoil a test."""
    be_first(on)
    if on:
        gc.collect()
        gc.freeze()
        gc.disable()
    else:
        gc.enable()
        gc.unfreeze()


def axis(status: int = ENABLED) -> AxisInputs:
    return AxisInputs(status, 9, 1, 2, 3, 0)


def image(status: int = ENABLED, digital: int = Digital.EMERGENCY_STOP_OK) -> BusInputs:
    axes = (axis(status),) * len(AXES)
    return BusInputs(1, 4_000_000, (0.0,) * 6, 0.0, 0, 0, 0, 0, 0, int(digital), 0, axes)


def command(word: int = RUN, cycle: int = 1, which: int = 0) -> AxisCommand:
    return AxisCommand(which, cycle, word, 9, 5, 1000, 77, 1)


def namespace() -> BenchNamespace:
    """A namespace, or a skipped test that says why."""
    try:
        return BenchNamespace()
    except NamespaceError as error:
        pytest.skip(str(error))


class Emulator(EmulatorProcess):
    """The emulator, with a short word for what the tests ask most."""

    def __init__(self, ns: BenchNamespace, bus: Path = BENCH, *more: str) -> None:
        super().__init__(ns, bus, more)

    def wheel(self) -> dict[str, Any]:
        """What the monitor at the plant's shaft says of the wheel."""
        return self.send("motion")["axes"]["wheel"]


class InsistentNode:
    """The worst node there is: once told to, it drives towards 'enabled and turning' for ever.

    It never looks at the health. That nothing moves by itself after a fault must come from the
    bus.
    """

    def __init__(self, client: BusClient) -> None:
        self.client = client
        self.last: BusInputs | None = None
        self.insists = False
        self.speed = TURNING
        self.silent = False
        self.resets = 0
        self.seen: set[str] = set()
        self.gaps = 0
        self._pending: deque[BusInputs] = deque()

    def run(
        self, until: Callable[[BusInputs], bool], seconds: float = 5.0, what: str = ""
    ) -> BusInputs:
        """Answer images until a condition holds; the limit is only for a test that fails."""
        if not self.reaches(until, seconds):
            report = self.client.diagnostics() if self.client.alive else {}
            pytest.fail(f"not reached: {what or until}; last {self.last}, {report}")
        return self.last

    def reaches(self, until: Callable[[BusInputs], bool], seconds: float) -> bool:
        """The same, and says whether the condition came to hold."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._pending.extend(self.client.poll() if not self._pending else ())
            while self._pending:
                inputs = self._pending.popleft()
                self._answer(inputs)
                if until(inputs):
                    return True
        return False

    def cycles(self, count: int) -> None:
        """Go on for so many cycles."""
        start = self.last.cycle if self.last else 0
        self.run(lambda i: i.cycle >= start + count, what=f"{count} cycles")

    def _answer(self, inputs: BusInputs) -> None:
        if self.last is not None and inputs.cycle != self.last.cycle + 1:
            self.gaps += 1
        self.last = inputs
        self.seen.add(Health(inputs.health).name)
        if self.silent:
            return
        word = 0
        if self.resets:
            self.resets -= 1
            word = 0x80 if self.resets == 0 else 0x00
        elif self.insists:
            word = _UPWARD.get(inputs.axes[0].status_word & 0x6F, 0)
        speed = self.speed if self.insists else 0
        self.client.send(AxisCommand(0, inputs.cycle, word, VELOCITY_MODE, 0, speed, 0, 0))

    def reset(self) -> None:
        """One fault reset: the bit goes up once, in answer to a fresh image."""
        self.run(lambda _inputs: not self._pending, what="caught up")
        self.resets = 3

    def spin_up(self, measure: Callable[[], Any] = lambda: False) -> None:
        """Enable and turn; an operator resets again when the machine of a test has stalled, which
        `measure` looks for, and stopped the wheel anew."""

        def turns(inputs: BusInputs) -> bool:
            return inputs.health == 0 and inputs.axes[0].velocity > TURNING * 0.9

        for _ in range(ATTEMPTS - 1):
            stalls = measure()
            self.insists = True
            if self.reaches(turns, 2.0):
                return
            if not stalls:
                break
            self.insists = False
            self.reset()
            self.cycles(10)
        self.insists = True
        self.run(turns, what="wheel turns")

    def rest(self) -> None:
        """Disable and wait for standstill."""
        self.insists = False
        self.run(lambda i: abs(i.axes[0].velocity) < 1000, what="wheel rests")


class Bench:
    """Everything together; the wheel hangs free, so that it may turn."""

    def __init__(
        self, bus: Path = BENCH, rate_hz: int = 0, emulator: tuple[str, ...] = ()
    ) -> None:
        self.namespace = namespace()
        self.bus = bus
        self._rate_hz = rate_hz
        self.events: list[dict[str, Any]] = []
        self.emulator: Emulator | None = None
        # There from the beginning, with the node's priority: the start of a thread waits until it
        # runs, at ordinary priority on a busy computer, and the node is due meanwhile.
        self._asker = ThreadPoolExecutor(1, initializer=be_first, initargs=(True,))
        self._asker.submit(int).result()
        try:
            rate = ("--rate", str(rate_hz)) if rate_hz else ()
            self.emulator = Emulator(self.namespace, bus, *rate, *emulator)
            self.new_client()
            be_quick(True)
        except BaseException:
            self.close()
            raise

    def unload(self) -> None:
        """Lift the wheel off the road."""
        self.emulator.send("operator", name="unload")
        self.node.cycles(5)

    def new_client(self) -> None:
        """A fresh bus process and node on the same emulator."""
        if hasattr(self, "client"):
            self.client.stop()
        self.client = BusClient(
            self.bus,
            MASTER,
            rate_hz=self._rate_hz,
            slip=True,
            launch=self.namespace.enter,
            on_event=self.events.append,
        )
        self.client.start()
        self.node = InsistentNode(self.client)

    def stalls(self) -> EmulatorStalls:
        """Those of the computer from now on."""
        return EmulatorStalls(self.emulator.send)

    def revive(self) -> None:
        """Whatever the test before has left: well, reset, and the wheel turning."""
        self.emulator.send("mend")
        if not self.client.alive:
            self.new_client()
        node = self.node
        node.insists, node.silent = False, False
        node.run(lambda i: i.health == 0, seconds=10.0, what="bus well")
        node.cycles(10)
        if self.emulator.wheel()["enabled"] or self.client.diagnostics()["held"]:
            node.reset()
            node.cycles(10)
        node.spin_up(self.stalls)
        node.cycles(5)
        node.seen.clear()
        self.client.diagnostics()  # takes the events that came before
        self.events.clear()

    def meanwhile(self, process: subprocess.Popen[bytes]) -> bytes:
        """Go on answering until a process says something or ends; what it said.

        No thread: it would hold the interpreter's lock at ordinary priority while the node is due.
        """
        ready = select.poll()
        ready.register(process.stdout)
        self.node.run(lambda _inputs: bool(ready.poll(0)), seconds=20.0, what="process is done")
        return process.stdout.readline()

    def ask_sdo(self) -> str:
        """How a read of the drive's name ends, while the node goes on answering."""
        asked = self._asker.submit(self.client.sdo_read, "wheel_drive", 0x1008)
        self.node.run(lambda _inputs: asked.done(), what="SDO answered")
        error = asked.exception()
        if isinstance(error, LookupError):
            return str(error)
        return asked.result().decode()

    def close(self) -> None:
        """End everything."""
        be_quick(False)
        self._asker.shutdown()
        if hasattr(self, "client"):
            self.client.stop()
        if self.emulator is not None:
            self.emulator.close()
        self.namespace.close()
