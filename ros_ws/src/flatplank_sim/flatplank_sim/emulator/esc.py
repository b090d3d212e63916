# SPDX-License-Identifier: Apache-2.0
"""The EtherCAT slave controller: registers, FMMUs and sync managers (ETG.1000.4).

The firmware of a device connects to the hooks at the end of `__init__`.
"""

from __future__ import annotations

from collections.abc import Callable

from flatplank_sim.emulator import registers as reg
from flatplank_sim.emulator.frame import Command

_READS = {Command.APRD, Command.FPRD, Command.BRD, Command.APRW, Command.FPRW, Command.BRW}
_WRITES = {Command.APWR, Command.FPWR, Command.BWR, Command.APRW, Command.FPRW, Command.BRW}
_BOTH = {Command.APRW, Command.FPRW, Command.BRW}
_POSITION = {Command.APRD, Command.APWR, Command.APRW, Command.ARMW}
_STATION = {Command.FPRD, Command.FPWR, Command.FPRW, Command.FRMW}
_BROADCAST = {Command.BRD, Command.BWR, Command.BRW}
_LOGICAL = {Command.LRD, Command.LWR, Command.LRW}

SYNC_MANAGERS = (reg.SYNC_MANAGER_END - reg.SYNC_MANAGER) // 8


def _ignore(*_: object) -> None:
    """Default hook that does nothing."""


class SlaveController:
    """Memory and registers of one slave, accessed by datagrams."""

    def __init__(self, dc: bool = False) -> None:
        self.dc = dc
        self.now = 0
        """bench time of the frame being served [ns]"""
        self.last_outputs = 0
        """bench time of the last outputs that fed the watchdog [ns]"""
        self.process_data_on = False
        """true when process data are enabled, from SAFEOP on"""
        self.al_control: Callable[[int], None] = _ignore
        self.sii_command: Callable[[int], None] = _ignore
        self.mailbox_received: Callable[[bytes], None] = _ignore
        self.mailbox_fetched: Callable[[], None] = _ignore
        self.reset()

    def reset(self) -> None:
        """Reset the registers to their state after power-on."""
        self.memory = bytearray(reg.MEMORY_END)
        self.memory[0:10] = bytes([0x11, 1, 1, 0, 8, 8, 8, 0x0F, 0xC4 if self.dc else 0xC0, 1])
        self.write_register(reg.WATCHDOG_DIVIDER, 0x09C2)
        self.write_register(reg.WATCHDOG_PDI, 1000)
        self.write_register(reg.WATCHDOG_DATA, 1000)
        self.write_register(reg.WATCHDOG_STATUS, 1)
        self.write_register(reg.PDI_CONTROL, 0x0C80)
        self.write_register(reg.SII_CONTROL, 0x0040)
        self._managers: list[reg.SyncManager] = []
        self._fmmus: list = []
        self.process_data_on = False

    def write_register(self, address: int, value: int, size: int = 2) -> None:
        """Set a register from the firmware."""
        self.memory[address : address + size] = value.to_bytes(size, "little")

    def read_register(self, address: int, size: int = 2) -> int:
        """Read a register from the firmware."""
        return int.from_bytes(self.memory[address : address + size], "little")

    def manager(self, number: int) -> reg.SyncManager | None:
        """Sync manager by number, if enabled."""
        return next((m for m in self._managers if m.number == number), None)

    @property
    def watchdog_ns(self) -> int:
        """Process data watchdog [ns]; 0 is off."""
        tick = 40 * (self.read_register(reg.WATCHDOG_DIVIDER) + 2)
        return self.read_register(reg.WATCHDOG_DATA) * tick

    # --- datagrams -------------------------------------------------------------------------

    def execute(self, command: int, frame: bytearray, start: int, length: int) -> int:
        """Process one datagram in place; returns the increment of the working counter."""
        data = start + 10
        if command in _LOGICAL:
            return self._logical(command, frame, start, data, length)
        position = frame[start + 2] | frame[start + 3] << 8
        offset = frame[start + 4] | frame[start + 5] << 8
        if command in _POSITION or command in _BROADCAST:
            next_position = (position + 1) & 0xFFFF
            frame[start + 2], frame[start + 3] = next_position & 0xFF, next_position >> 8
        if command in (Command.ARMW, Command.FRMW):
            return self._read_multiple_write(command, position, offset, frame, data, length)
        if command in _POSITION and position != 0:
            return 0
        if command in _STATION and position != self.read_register(reg.STATION_ADDRESS):
            return 0
        return self._physical(command, offset, frame, data, length)

    def _physical(
        self, command: int, offset: int, frame: bytearray, data: int, length: int
    ) -> int:
        grown = 0
        given = bytes(frame[data : data + length])
        if command in _READS:
            found = self._read(offset, length)
            if found is not None:
                if command in _BROADCAST:
                    found = bytes(a | b for a, b in zip(found, given, strict=True))
                frame[data : data + length] = found
                grown += 1
        if command in _WRITES and self._write(offset, given):
            grown += 2 if command in _BOTH else 1
        return grown

    def _read_multiple_write(
        self, command: int, position: int, offset: int, frame: bytearray, data: int, length: int
    ) -> int:
        wanted = 0 if command == Command.ARMW else self.read_register(reg.STATION_ADDRESS)
        if position == wanted:
            found = self._read(offset, length)
            if found is None:
                return 0
            frame[data : data + length] = found
            return 1
        return 1 if self._write(offset, bytes(frame[data : data + length])) else 0

    def _logical(self, command: int, frame: bytearray, start: int, data: int, length: int) -> int:
        if not self.process_data_on:
            return 0
        address = int.from_bytes(frame[start + 2 : start + 6], "little")
        end = address + length
        wrote = command != Command.LRD and self.latch_outputs(frame, start, length)
        read = False
        for unit in self._fmmus:
            if unit.kind & reg.READ and command != Command.LWR:
                read |= unit.copy_out(self.memory, frame, data, address, end)
        return read + wrote * (2 if command == Command.LRW else 1)

    def latch_outputs(self, frame: bytearray, start: int, length: int) -> bool:
        """Take the outputs of a logical datagram; true when it has any for this slave."""
        if not self.process_data_on:
            return False
        address = int.from_bytes(frame[start + 2 : start + 6], "little")
        wrote = False
        for unit in self._fmmus:
            if unit.kind & reg.WRITE:
                wrote |= unit.copy_in(self.memory, frame, start + 10, address, address + length)
        if wrote:
            self.last_outputs = self.now
        return wrote

    # --- memory ----------------------------------------------------------------------------

    def _read(self, offset: int, length: int) -> bytes | None:
        end = offset + length
        if end > reg.MEMORY_END:
            return None
        if offset >= reg.MEMORY:
            manager = self._mailbox_at(offset, end)
            if manager is not None:
                return self._read_mailbox(manager, offset, end)
        elif self.dc and offset <= reg.DC_SYSTEM_TIME < end:
            self.write_register(
                reg.DC_SYSTEM_TIME,
                self.now + self.read_register(reg.DC_SYSTEM_OFFSET, 8) & (1 << 64) - 1,
                8,
            )
        return bytes(self.memory[offset:end])

    def _write(self, offset: int, data: bytes) -> bool:
        end = offset + len(data)
        if end > reg.MEMORY_END:
            return False
        if offset >= reg.MEMORY:
            manager = self._mailbox_at(offset, end)
            if manager is not None:
                return self._write_mailbox(manager, offset, data)
            self.memory[offset:end] = data
            return True
        return self._write_registers(offset, end, data)

    def _write_registers(self, offset: int, end: int, data: bytes) -> bool:
        if reg.SYNC_MANAGER <= offset < reg.SYNC_MANAGER_END:
            self._configure_managers(offset, data)
            return True
        if offset <= reg.AL_CONTROL < end:
            place = reg.AL_CONTROL - offset
            self.memory[offset:end] = data
            self.al_control(int.from_bytes(data[place : place + 2], "little"))
            return True
        if offset <= reg.SII_CONTROL < end:
            self.memory[offset:end] = data
            self.sii_command(self.read_register(reg.SII_CONTROL))
            return True
        if offset <= reg.DC_RECEIVE < end:
            for port in range(4):
                self.write_register(reg.DC_RECEIVE + 4 * port, self.now & 0xFFFFFFFF, 4)
            return True
        if reg.DL_STATUS <= offset < reg.AL_CONTROL or reg.AL_STATUS <= offset < reg.PDI_CONTROL:
            return True
        self.memory[offset:end] = data
        if offset < reg.FMMU_END and end > reg.FMMU:
            self._fmmus = reg.read_fmmus(self.memory[reg.FMMU : reg.FMMU_END])
        return True

    # --- sync managers ---------------------------------------------------------------------

    def _configure_managers(self, offset: int, data: bytes) -> None:
        """Configure the sync managers; writes to the status and PDI bytes are ignored."""
        for i, value in enumerate(data):
            if (offset + i) & 7 not in (5, 7):
                self.memory[offset + i] = value
        before = {m.number: m for m in self._managers}
        managers = reg.read_sync_managers(self.memory[reg.SYNC_MANAGER : reg.SYNC_MANAGER_END])
        self._managers = [
            before[m.number].continued(m) if m.number in before else m for m in managers
        ]
        full = {m.number for m in self._managers if m.full}
        for number in range(SYNC_MANAGERS):
            if number not in full:
                self.memory[reg.SYNC_MANAGER + 8 * number + 5] &= ~reg.FULL
        for manager in self._managers:
            if manager.repeat_asked(self.memory):
                manager.repeat(self.memory)

    def _mailbox_at(self, offset: int, end: int) -> reg.SyncManager | None:
        for manager in self._managers:
            if manager.mailbox and offset < manager.end and end > manager.start:
                return manager
        return None

    def _read_mailbox(self, manager: reg.SyncManager, offset: int, end: int) -> bytes | None:
        if manager.written_by_master or offset != manager.start or not manager.full:
            return None
        found = bytes(self.memory[offset:end])
        if end >= manager.end:
            manager.set_full(self.memory, False)
            self.mailbox_fetched()
        return found

    def _write_mailbox(self, manager: reg.SyncManager, offset: int, data: bytes) -> bool:
        if not manager.written_by_master or offset != manager.start or manager.full:
            return False
        self.memory[offset : offset + len(data)] = data
        if offset + len(data) >= manager.end:
            manager.set_full(self.memory, True)
            self.mailbox_received(bytes(self.memory[manager.start : manager.end]))
        return True

    def take_mailbox(self) -> None:
        """Mark the mailbox from the master as read."""
        manager = self.manager(0)
        if manager is not None:
            manager.set_full(self.memory, False)

    def offer_mailbox(self, message: bytes) -> bool:
        """Put a message for the master into the mailbox; False when the last one was not fetched
        yet."""
        manager = self.manager(1)
        if manager is None or not manager.mailbox or manager.full:
            return False
        manager.put(self.memory, message)
        return True
