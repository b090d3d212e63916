# SPDX-License-Identifier: Apache-2.0
"""Runs the emulated bench on a port: answers frames, and advances bench time without them."""

from __future__ import annotations

import fcntl
import gc
import select
import socket
import struct
import time
from typing import Any

from flatplank_data.errors import FlatplankError
from flatplank_hw.ethercat.master.interface import (
    ETHERCAT,
    IFF_UP,
    NAME_LIMIT,
    SIOCGIFFLAGS,
)
from flatplank_hw.process import prepare_thread
from flatplank_sim.emulator.bench import EmulatedBench
from flatplank_sim.emulator.control import ControlServer
from flatplank_sim.emulator.wire import Wire

SO_TIMESTAMPNS = 35
SIOCSIFFLAGS = 0x8914


class PortError(FlatplankError):
    """The interface cannot be used; one line with the remedy."""


class Port:
    """Raw socket bound to one interface."""

    def __init__(self, interface: str) -> None:
        if len(interface.encode()) > NAME_LIMIT:
            raise PortError(f"interface '{interface}': names have at most {NAME_LIMIT} characters")
        self.interface = interface
        try:
            self.socket = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ETHERCAT))
        except PermissionError:
            raise PortError(
                "no permission for raw Ethernet; run as root or inside 'unshare -Urn', or give the"
                " interpreter CAP_NET_RAW (sudo setcap cap_net_raw+ep $(readlink -f python3))"
            ) from None
        try:
            self.socket.bind((interface, ETHERCAT))
        except OSError as error:
            self.socket.close()
            raise PortError(
                f"interface '{interface}': {error.strerror}; 'ip link' lists what there is"
            ) from None
        self.socket.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
        self.socket.setblocking(False)

    def fileno(self) -> int:
        """File descriptor for poll."""
        return self.socket.fileno()

    def receive(self) -> tuple[bytes, int] | None:
        """Next frame and its age [ns]; None: no frame, or the link is down."""
        try:
            frame, ancillary, _, _ = self.socket.recvmsg(2048, 64)
        except OSError:
            return None
        age = 0
        for level, kind, data in ancillary:
            if level == socket.SOL_SOCKET and kind == SO_TIMESTAMPNS:
                seconds, nanoseconds = struct.unpack("qq", data[:16])
                age = time.time_ns() - (seconds * 1_000_000_000 + nanoseconds)
        return frame, age

    def send(self, frame: bytes | bytearray) -> None:
        """Send a frame to the master; it is lost when the link is down."""
        try:
            self.socket.send(frame)
        except OSError:
            return

    def set_link(self, up: bool) -> None:
        """Take the interface down or up, like unplugging the cable."""
        name = self.interface.encode().ljust(16, b"\0")
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as control:
            raw = fcntl.ioctl(control, SIOCGIFFLAGS, name + bytes(24))
            flags = struct.unpack_from("H", raw, 16)[0]
            flags = flags | IFF_UP if up else flags & ~IFF_UP
            fcntl.ioctl(control, SIOCSIFFLAGS, name + struct.pack("H", flags) + bytes(22))

    def close(self) -> None:
        """Close the socket."""
        self.socket.close()


STALL_NS = 3_000_000
"""a wait that ends later than this counts as a stall of this process [ns]"""
SILENT_CYCLES = 5
"""cycles without process data after which bench time follows the wall clock"""


class Runner:
    """Runs the bench in one loop in one thread."""

    def __init__(
        self, bench: EmulatedBench, wire: Wire, port: Port, master_timeout_ns: int = 0
    ) -> None:
        """master_timeout_ns: time without frames that is tolerated, for a master that waits for
        its nodes."""
        self.bench = bench
        self.wire = wire
        self.port = port
        self.control: ControlServer | None = None
        self.running = True
        self.scheduling = ""
        self._poll = select.poll()
        self._poll.register(port, select.POLLIN)
        self._wall = 0
        """wall time that bench time has reached [ns]"""
        self._silent = True
        self._silence_ns = max(SILENT_CYCLES * bench.bus.period_ns, master_timeout_ns)
        self._parent = -1
        self.stalled_ns = 0
        """wall time for which this process was not scheduled [ns]"""

    def attach(self, control: ControlServer) -> None:
        """Serve a control socket."""
        self.control = control
        for fd in control.filenos():
            self._poll.register(fd, select.POLLIN)

    def close(self) -> None:
        """Close the port and the control socket."""
        self.port.close()
        if self.control is not None:
            self.control.close()

    def end_with(self, fd: int) -> None:
        """End when the other end of the pipe `fd` is closed, as when the parent process ends."""
        self._parent = fd
        self._poll.register(fd, select.POLLHUP)

    def facts(self) -> dict[str, Any]:
        """Facts about the process, for the control socket."""
        return {"scheduling": self.scheduling, "stalled_ms": self.stalled_ns / 1e6}

    def run(self, fifo: bool = False) -> None:
        """Run until `running` is false."""
        self.scheduling = prepare_thread(fifo, priority=40)
        self._wall = time.monotonic_ns()
        gc.freeze()
        gc.disable()
        while self.running:
            deadline = self._deadline()
            ready = self._poll.poll(max(deadline - time.monotonic_ns(), 0) / 1e6)
            now = time.monotonic_ns()
            if any(fd == self._parent for fd, _ in ready):
                break
            self._forgive(now - deadline)
            self._serve(now)
            for frame in self.wire.due(now):
                self.port.send(frame)
            if self.control is not None:
                self.control.poll()
            self._silence(now)

    def _deadline(self) -> int:
        """Time of the next action without frames [ns]."""
        period = self.bench.bus.period_ns
        until = self._wall + (period if self._silent else self._silence_ns)
        due = self.wire.next_due
        return until if due is None else min(until, due)

    def _forgive(self, late: int) -> None:
        """Exclude a stall of this process from bench time: the wait ended late."""
        if late > STALL_NS:
            self._wall += late
            self.stalled_ns += late

    def _serve(self, now: int) -> None:
        while True:
            received = self.port.receive()
            if received is None:
                return
            frame, age = received
            process_data = self.bench.segment.is_process_data(frame)
            if not self.wire.admits(process_data, age):
                continue
            before = self.bench.cycle
            answer = self.bench.frame(frame)
            if self.bench.cycle != before:
                self._wall, self._silent = now, False
            for out in self.wire.answer(answer, process_data, now):
                self.port.send(out)

    def _silence(self, now: int) -> None:
        """Let bench time follow the wall clock without process data, so that watchdogs act."""
        period = self.bench.bus.period_ns
        if not self._silent and now - self._wall >= self._silence_ns:
            self._silent = True
        if self._silent:
            while now - self._wall >= period:
                self._wall += period
                self.bench.step()
