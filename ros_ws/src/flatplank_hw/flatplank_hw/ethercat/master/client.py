# SPDX-License-Identifier: Apache-2.0
"""Client of the bus process: starts it, receives images, sends commands and requests.

When the bus process is silent or dead, the client makes images with the last values and health
LOST, so that the safety rules of all nodes act.
"""

from __future__ import annotations

import itertools
import json
import os
import select
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from flatplank_hw.bus.image import AXES, AxisCommand, AxisInputs, BusInputs, Health
from flatplank_hw.ethercat.master import link
from flatplank_hw.ethercat.master.interface import BusError
from flatplank_hw.ethercat.reader import read_bus_file
from flatplank_hw.process import child_environment

SILENCE_S = 0.05
"""after this time without an image the client makes its own, with health LOST [s]"""
_NO_AXIS = AxisInputs(0, 0, 0, 0, 0, 0)
_NOTHING = BusInputs(
    0, 0, (0.0,) * 6, 0.0, 0, 0, 0, 0, 0, 0, int(Health.LOST), (_NO_AXIS,) * len(AXES)
)


class BusClient:
    """One bus process and its sockets. One thread reads images; any thread may make requests."""

    def __init__(
        self,
        bus_file: str | Path,
        interface: str,
        rate_hz: int = 0,
        fifo: bool = True,
        slip: bool = False,
        reply_timeout_ms: float = 0.0,
        node_timeout_ms: float = 0.0,
        batch: int = 1,
        launch: Sequence[str] = (),
        on_event: Callable[[dict[str, Any]], None] | None = None,
    ) -> None:
        """
        rate_hz: cycles per second; 0: as in the bus file.
        fifo: SCHED_FIFO when allowed.
        slip: after a stall of this computer cycle numbers go on without a gap; for an emulated
            bus, which stalls with it.
        reply_timeout_ms: a later answer counts as lost; 0: 2 ms, at most 0.6 of the period.
        node_timeout_ms: longest wait of a cycle for the nodes' answer to the last one; 0: no wait,
            as on a real bus.
        batch: the nodes answer the last of this many cycles.
        launch: words in front of the interpreter, for instance `BenchNamespace.enter`.
        on_event: called with each event of the bus process (emergency, recovery, end), in the
            thread of the request that receives it.
        """
        self.bus = read_bus_file(bus_file)
        self.interface = interface
        self.rate_hz = rate_hz or self.bus.rate_hz
        self.period_ns = 1_000_000_000 // self.rate_hz
        self.process: subprocess.Popen[bytes] | None = None
        self._bus_file = str(bus_file)
        self._slip = slip
        self._flags = ["--fifo"] * fifo + ["--slip"] * slip
        self._flags += ["--reply-timeout-ms", str(reply_timeout_ms)]
        self._flags += ["--node-timeout-ms", str(node_timeout_ms), "--batch", str(batch)]
        self._silence_s = SILENCE_S + 1.5e-3 * node_timeout_ms
        self._launch = list(launch)
        self._on_event = on_event or (lambda _event: None)
        self._lock = threading.Lock()
        self._ids = itertools.count(1)
        self._last = _NOTHING
        self._last_wall = 0.0
        self.invented = 0
        """number of images made by the client because none came"""

    # --- life ------------------------------------------------------------------------------

    def start(self, timeout: float = 5.0) -> None:
        """Start the bus process and wait until the bus is in OP; BusError with the reason."""
        self._data, data = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._control, control = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        for end in (self._data, data):
            end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1 << 20)
        words = [*self._launch, sys.executable, "-m", "flatplank_hw.ethercat.master"]
        words += ["--interface", self.interface, "--bus", self._bus_file]
        words += ["--rate", str(self.rate_hz)]
        words += ["--data-fd", str(data.fileno()), "--control-fd", str(control.fileno())]
        words += self._flags
        self.process = subprocess.Popen(
            words,
            pass_fds=(data.fileno(), control.fileno()),
            env=child_environment(),
            stdin=subprocess.DEVNULL,
        )
        data.close()
        control.close()
        self._await_ready(timeout)
        self._data.setblocking(False)
        self._last_wall = time.monotonic()

    def stop(self, timeout: float = 3.0) -> None:
        """Stop the axes and the bus, and end the process."""
        if self.process is None:
            return
        self._send_request({"do": "stop", "id": 0})
        end = time.monotonic() + timeout
        while self.process.poll() is None and time.monotonic() < end:
            self._drain_events(0.02)
        self._drain_events(0.0)
        self._abandon()

    def _abandon(self) -> None:
        self._data.close()
        self._control.close()
        if self.process is not None:
            try:
                self.process.wait(1.0)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        self.process = None

    @property
    def alive(self) -> bool:
        """True while the bus process runs."""
        return self.process is not None and self.process.poll() is None

    def __enter__(self) -> BusClient:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    # --- cycle -----------------------------------------------------------------------------

    def poll(self, timeout: float = SILENCE_S) -> list[BusInputs]:
        """Images since the last call, oldest first; waits for one, at most `timeout` [s].

        After 50 ms without an image (longer for a bus that waits for answers, while its process
        runs) it returns one image with the last values and health LOST.
        """
        found = self._take()
        if not found and timeout > 0:
            select.select([self._data], [], [], timeout)
            found = self._take()
        now = time.monotonic()
        if found:
            self._last, self._last_wall = found[-1], now
            return found
        silence = self._silence_s if self.alive else SILENCE_S
        if now - self._last_wall < silence:
            return []
        return [self._invent(now)]

    def send(self, command: AxisCommand) -> None:
        """Send a command in answer to an image; it is lost when the bus process cannot take it."""
        try:
            self._data.send(link.pack_command(command))
        except OSError:
            return

    def _take(self) -> list[BusInputs]:
        found = []
        while True:
            try:
                data = self._data.recv(link.MAX_MESSAGE)
            except OSError:
                break
            if not data:
                time.sleep(self.period_ns * 1e-9)
                break
            inputs = link.unpack_inputs(data)
            if inputs.cycle > self._last.cycle:
                found.append(inputs)
        return found

    def _invent(self, now: float) -> BusInputs:
        """Make an image with the cycle number by the wall clock, as the bus process will count.

        With `slip` the bus process counts without gaps, and each image gets the next number.
        """
        self.invented += 1
        gone = max(round((now - self._last_wall) * self.rate_hz), 1) if not self._slip else 1
        cycle = self._last.cycle + gone
        self._last = self._last._replace(
            cycle=cycle, stamp_ns=cycle * self.period_ns, health=Health.LOST
        )
        self._last_wall = now
        return self._last

    # --- requests --------------------------------------------------------------------------

    def sdo_read(self, slave: str, index: int, subindex: int = 0, timeout: float = 1.0) -> bytes:
        """Read an object of a slave; LookupError with the reason (abort text, no answer)."""
        answer = self._ask(timeout, do="sdo_read", slave=slave, index=index, subindex=subindex)
        return bytes.fromhex(answer["data"])

    def sdo_write(
        self, slave: str, index: int, subindex: int, data: bytes, timeout: float = 1.0
    ) -> None:
        """Write an object of a slave; LookupError with the reason."""
        place = {"slave": slave, "index": index, "subindex": subindex}
        self._ask(timeout, do="sdo_write", **place, data=data.hex())

    def diagnostics(self, timeout: float = 1.0) -> dict[str, Any]:
        """Health with reason, counts, histograms, recoveries, stops, emergencies."""
        return self._ask(timeout, do="diagnostics")["diagnostics"]

    def _ask(self, timeout: float, **request: Any) -> dict[str, Any]:
        with self._lock:
            number = next(self._ids)
            self._send_request({"id": number, **request})
            end = time.monotonic() + timeout
            while time.monotonic() < end and self.alive:
                message = self._receive(max(end - time.monotonic(), 0.0))
                if message is None:
                    continue
                if message.get("id") != number:
                    self._event(message)
                elif message["ok"]:
                    return message
                else:
                    raise LookupError(message["reason"])
        raise LookupError("the bus process is gone" if not self.alive else "no answer in time")

    def _send_request(self, message: dict[str, Any]) -> None:
        try:
            self._control.send(json.dumps(message).encode())
        except OSError:
            return

    def _receive(self, timeout: float) -> dict[str, Any] | None:
        ready, _, _ = select.select([self._control], [], [], timeout)
        if not ready:
            return None
        data = self._control.recv(link.MAX_MESSAGE)
        return json.loads(data) if data else None

    def _event(self, message: dict[str, Any]) -> None:
        if "event" in message:
            self._on_event(message)

    def _drain_events(self, timeout: float) -> None:
        message = self._receive(timeout)
        while message is not None:
            self._event(message)
            message = self._receive(0.0)

    def _await_ready(self, timeout: float) -> None:
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            # check this first: messages sent before the end of the process are still read
            code = self.process.poll() if self.process is not None else None
            message = self._receive(0.05)
            if message is not None and message.get("event") == "ready":
                return
            if message is not None and message.get("event") == "failed":
                self._abandon()
                raise BusError(message["reason"])
            if message is None and code is not None:
                self._abandon()
                raise BusError(f"the bus process ended with code {code} before it was ready")
        if self.process is not None:
            os.kill(self.process.pid, 15)
        self._abandon()
        raise BusError(f"the bus is not in OP after {timeout:g} s")
