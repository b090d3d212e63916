# SPDX-License-Identifier: Apache-2.0
"""Sync managers: a mailbox passes whole messages one at a time, a buffer always has the newest
data."""

from __future__ import annotations

from dataclasses import dataclass, field

from flatplank_sim.emulator import registers as reg

SIZE = 8
FULL = 0x08
REPEAT = 0x02


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
        """First address behind."""
        return self.start + self.length

    @property
    def mailbox(self) -> bool:
        """One-buffer mode."""
        return self.control & 3 == 2

    @property
    def written_by_master(self) -> bool:
        """Direction."""
        return bool(self.control & 0x04)

    @property
    def watched(self) -> bool:
        """Whether writing feeds the watchdog."""
        return bool(self.control & 0x40)

    @property
    def _registers(self) -> int:
        return reg.SYNC_MANAGER + self.number * SIZE

    def continued(self, new: SyncManager) -> SyncManager:
        """The new configuration with the old contents when place and size are the same."""
        if (new.start, new.length, new.control) == (self.start, self.length, self.control):
            return self
        return new

    def set_full(self, memory: bytearray, full: bool) -> None:
        """Mailbox state, shown in the status register."""
        self.full = full
        status = memory[self._registers + 5] & ~FULL
        memory[self._registers + 5] = status | (FULL if full else 0)

    def put(self, memory: bytearray, message: bytes) -> None:
        """A message for the master."""
        self.last = message[: self.length].ljust(self.length, b"\0")
        memory[self.start : self.end] = self.last
        self.set_full(memory, True)

    def repeat_asked(self, memory: bytearray) -> bool:
        """The master lost the answer and wants it again (toggle bit)."""
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
    for number in range(len(registers) // SIZE):
        raw = registers[number * SIZE : (number + 1) * SIZE]
        length = int.from_bytes(raw[2:4], "little")
        if raw[6] & 1 and length:
            managers.append(
                SyncManager(number, int.from_bytes(raw[0:2], "little"), length, raw[4])
            )
    return managers
