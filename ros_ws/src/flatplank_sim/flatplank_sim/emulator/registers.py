# SPDX-License-Identifier: Apache-2.0
"""Registers of a slave controller (ETG.1000.4), and the units that they configure.

A sync manager passes whole messages one at a time (mailbox), or holds the newest data (buffer). An
FMMU maps bits of the logical image to bits of the slave's memory.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, field

STATION_ADDRESS = 0x0010
DL_STATUS = 0x0110
AL_CONTROL = 0x0120
AL_STATUS = 0x0130
AL_STATUS_CODE = 0x0134
PDI_CONTROL = 0x0140
WATCHDOG_DIVIDER = 0x0400
WATCHDOG_PDI = 0x0410
WATCHDOG_DATA = 0x0420
WATCHDOG_STATUS = 0x0440
WATCHDOG_COUNT = 0x0442
SII_CONTROL = 0x0502
SII_ADDRESS = 0x0504
SII_DATA = 0x0508
FMMU = 0x0600
FMMU_END = 0x0700
SYNC_MANAGER = 0x0800
SYNC_MANAGER_END = 0x0880
DC_RECEIVE = 0x0900
DC_SYSTEM_TIME = 0x0910
DC_SYSTEM_OFFSET = 0x0920
MEMORY = 0x1000
MEMORY_END = 0x3000

SYNC_MANAGER_SIZE = 8
FULL = 0x08
REPEAT = 0x02
FMMU_SIZE = 16
READ, WRITE = 1, 2


@dataclass
class SyncManager:
    """One enabled sync manager."""

    number: int
    start: int
    length: int
    control: int
    full: bool = False
    last: bytes = field(default=b"", repr=False)
    """last message to the master, for a repeat"""

    @property
    def end(self) -> int:
        """First address behind the sync manager's memory."""
        return self.start + self.length

    @property
    def mailbox(self) -> bool:
        """True in mailbox (one-buffer) mode."""
        return self.control & 3 == 2

    @property
    def written_by_master(self) -> bool:
        """True when the master writes and the slave reads."""
        return bool(self.control & 0x04)

    @property
    def watched(self) -> bool:
        """True when writing triggers the watchdog."""
        return bool(self.control & 0x40)

    @property
    def _registers(self) -> int:
        return SYNC_MANAGER + self.number * SYNC_MANAGER_SIZE

    def continued(self, new: SyncManager) -> SyncManager:
        """The new configuration; the old object if address, size and control are unchanged."""
        if (new.start, new.length, new.control) == (self.start, self.length, self.control):
            return self
        return new

    def set_full(self, memory: bytearray, full: bool) -> None:
        """Set the mailbox state, also in the status register."""
        self.full = full
        status = memory[self._registers + 5] & ~FULL
        memory[self._registers + 5] = status | (FULL if full else 0)

    def put(self, memory: bytearray, message: bytes) -> None:
        """Put a message for the master."""
        self.last = message[: self.length].ljust(self.length, b"\0")
        memory[self.start : self.end] = self.last
        self.set_full(memory, True)

    def repeat_asked(self, memory: bytearray) -> bool:
        """True when the master requests the last message again (toggle bit)."""
        activate, acknowledged = memory[self._registers + 6], memory[self._registers + 7]
        return (
            self.mailbox
            and not self.written_by_master
            and bool((activate ^ acknowledged) & REPEAT)
        )

    def repeat(self, memory: bytearray) -> None:
        """Put the last message again and acknowledge."""
        memory[self._registers + 7] ^= REPEAT
        if self.last:
            self.put(memory, self.last)


def read_sync_managers(registers: bytes | bytearray) -> list[SyncManager]:
    """Enabled sync managers of a block of registers."""
    managers = []
    for number in range(len(registers) // SYNC_MANAGER_SIZE):
        raw = registers[number * SYNC_MANAGER_SIZE : (number + 1) * SYNC_MANAGER_SIZE]
        length = int.from_bytes(raw[2:4], "little")
        if raw[6] & 1 and length:
            managers.append(
                SyncManager(number, int.from_bytes(raw[0:2], "little"), length, raw[4])
            )
    return managers


@dataclass(frozen=True)
class Fmmu:
    """One FMMU, as configured by its sixteen registers."""

    logical: int
    length: int
    start_bit: int
    end_bit: int
    physical: int
    physical_bit: int
    kind: int

    @property
    def whole_bytes(self) -> bool:
        """True when the mapping consists of whole bytes; otherwise bits are copied one by one."""
        return self.start_bit == 0 and self.end_bit == 7 and self.physical_bit == 0

    @property
    def bits(self) -> int:
        """Number of mapped bits."""
        return (self.length - 1) * 8 + self.end_bit - self.start_bit + 1

    def copy_in(
        self, memory: bytearray, frame: bytearray, data: int, address: int, end: int
    ) -> bool:
        """Copy outputs: logical `address`..`end` of a frame with data from `data` on, to the
        memory."""
        low, high = max(self.logical, address), min(self.logical + self.length, end)
        if low >= high:
            return False
        if self.whole_bytes:
            target, source = self.physical + low - self.logical, data + low - address
            memory[target : target + high - low] = frame[source : source + high - low]
            return True
        for n in range(self.bits):
            bit = (self.logical - address) * 8 + self.start_bit + n
            if 0 <= bit < (end - address) * 8:
                value = frame[data + (bit >> 3)] >> (bit & 7) & 1
                _set(memory, self.physical * 8 + self.physical_bit + n, value)
        return True

    def copy_out(
        self, memory: bytearray, frame: bytearray, data: int, address: int, end: int
    ) -> bool:
        """Copy inputs from the memory to the frame; bits that are not mapped stay unchanged."""
        low, high = max(self.logical, address), min(self.logical + self.length, end)
        if low >= high:
            return False
        if self.whole_bytes:
            source, target = self.physical + low - self.logical, data + low - address
            frame[target : target + high - low] = memory[source : source + high - low]
            return True
        for n in range(self.bits):
            bit = (self.logical - address) * 8 + self.start_bit + n
            if 0 <= bit < (end - address) * 8:
                place = self.physical * 8 + self.physical_bit + n
                _set(frame, data * 8 + bit, memory[place >> 3] >> (place & 7) & 1)
        return True


def read_fmmus(registers: bytes | bytearray) -> list[Fmmu]:
    """Active FMMUs of a block of registers."""
    units = []
    for start in range(0, len(registers), FMMU_SIZE):
        raw = registers[start : start + FMMU_SIZE]
        if raw[12] & 1 and raw[11] & 3 and (raw[4] or raw[5]):
            logical, length, first, last, physical, bit, kind = struct.unpack("<IHBBHBB", raw[:12])
            units.append(Fmmu(logical, length, first & 7, last & 7, physical, bit & 7, kind & 3))
    return units


def _set(memory: bytearray, bit: int, value: int) -> None:
    mask = 1 << (bit & 7)
    if value:
        memory[bit >> 3] |= mask
    else:
        memory[bit >> 3] &= ~mask & 0xFF
