# SPDX-License-Identifier: Apache-2.0
"""Fieldbus memory management units: which bits of the logical image are which bits of a slave's
memory."""

from __future__ import annotations

from dataclasses import dataclass

SIZE = 16
READ, WRITE = 1, 2


@dataclass(frozen=True)
class Fmmu:
    """One unit, as its sixteen registers say."""

    logical: int
    length: int
    start_bit: int
    end_bit: int
    physical: int
    physical_bit: int
    kind: int

    @property
    def whole_bytes(self) -> bool:
        """Whether slices do; otherwise bits are copied one by one."""
        return self.start_bit == 0 and self.end_bit == 7 and self.physical_bit == 0

    @property
    def bits(self) -> int:
        """Number of mapped bits."""
        return (self.length - 1) * 8 + self.end_bit - self.start_bit + 1

    def copy_in(
        self, memory: bytearray, frame: bytearray, data: int, address: int, end: int
    ) -> bool:
        """Outputs: logical `address`..`end` of the frame, whose data start at `data`, to
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
        """Inputs: memory to the frame; bits that are not mapped stay as they are."""
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
    """Active units of a block of registers."""
    units = []
    for start in range(0, len(registers), SIZE):
        raw = registers[start : start + SIZE]
        if raw[12] & 1 and raw[11] & 3 and (raw[4] or raw[5]):
            units.append(
                Fmmu(
                    int.from_bytes(raw[0:4], "little"),
                    int.from_bytes(raw[4:6], "little"),
                    raw[6] & 7,
                    raw[7] & 7,
                    int.from_bytes(raw[8:10], "little"),
                    raw[10] & 7,
                    raw[11] & 3,
                )
            )
    return units


def _set(memory: bytearray, bit: int, value: int) -> None:
    mask = 1 << (bit & 7)
    if value:
        memory[bit >> 3] |= mask
    else:
        memory[bit >> 3] &= ~mask & 0xFF
