# SPDX-License-Identifier: Apache-2.0
"""Line of slaves: a frame passes through all of them and returns."""

from __future__ import annotations

from collections.abc import Callable

from flatplank_sim.emulator import registers as reg
from flatplank_sim.emulator.frame import Command, Datagram, FrameError, split
from flatplank_sim.emulator.slave import EmulatedSlave

_LOGICAL = (Command.LRD, Command.LWR, Command.LRW)
LOCAL_BIT = 0x02
"""bit set in the source address of a frame that has passed a slave"""


class Segment:
    """Slaves in the order of the wire; handles process data and register frames."""

    def __init__(self, slaves: list[EmulatedSlave]) -> None:
        self.slaves = slaves
        self.cut_after: int | None = None
        """injected fault: the cable is cut behind this many slaves"""
        self.counter_offset = 0
        """injected fault: added to the working counter of process data"""
        self.rejected = 0
        self.exchange: Callable[[], None] | None = None
        """called when all outputs of a process data frame have been taken, before the inputs are
        read"""
        self.show_topology()

    @property
    def reached(self) -> list[EmulatedSlave]:
        """Slaves that frames reach; a slave without power ends the line."""
        slaves = self.slaves if self.cut_after is None else self.slaves[: self.cut_after]
        line = []
        for slave in slaves:
            if slave.absent:
                break
            line.append(slave)
        return line

    def show_topology(self) -> None:
        """Set the port bits of the DL status: all ports are open except the last of the line."""
        line = self.reached
        for position, slave in enumerate(line):
            last = position + 1 == len(line)
            slave.esc.write_register(reg.DL_STATUS, 0x5611 if last else 0x5A31)

    def is_process_data(self, frame: bytes | bytearray) -> bool:
        """True when a frame contains logical datagrams."""
        try:
            return any(d.command in _LOGICAL for d in split(frame))
        except FrameError:
            return False

    def process(self, frame: bytes, now: int) -> bytearray | None:
        """The frame as it returns at bench time `now` [ns]; None when no slave passes it on.

        Malformed frames are counted and dropped, as by a real slave.
        """
        answer = bytearray(frame)
        try:
            datagrams = split(answer)
        except FrameError:
            self.rejected += 1
            return None
        line = self.reached
        if not line:
            return None
        for slave in line:
            slave.esc.now = now
        if self.exchange is not None:
            self._exchange(answer, datagrams, line)
        for d in datagrams:
            counter = answer[d.counter] | answer[d.counter + 1] << 8
            for slave in line:
                counter += slave.esc.execute(d.command, answer, d.start, d.length)
            if d.command in _LOGICAL:
                counter += self.counter_offset
            answer[d.counter], answer[d.counter + 1] = counter & 0xFF, counter >> 8 & 0xFF
        answer[6] |= LOCAL_BIT
        return answer

    def _exchange(
        self, frame: bytearray, datagrams: list[Datagram], line: list[EmulatedSlave]
    ) -> None:
        """Pass the outputs of a process data frame to the devices before its inputs are read."""
        logical = [d for d in datagrams if d.command in _LOGICAL]
        for d in logical:
            if d.command != Command.LRD:
                for slave in line:
                    slave.esc.latch_outputs(frame, d.start, d.length)
        if logical and self.exchange is not None:
            self.exchange()
