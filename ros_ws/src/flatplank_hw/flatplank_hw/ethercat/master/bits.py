# SPDX-License-Identifier: Apache-2.0
"""Slaves with less than a byte share bytes of the logical image; pysoem hands out the whole byte.

SOEM packs them one behind the other; a slave of eight bits or more starts at a new byte.
"""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_hw.ethercat.strict import BusFileError


@dataclass(frozen=True)
class BitPlace:
    """Where the bits of one slave lie."""

    shift: int = 0
    bits: int = 0
    """0: whole bytes"""
    group: int = -1
    """number of the shared byte"""

    def take(self, data: bytes) -> bytes:
        """The slave's own bits."""
        if not self.bits or not data:
            return data
        return bytes([data[0] >> self.shift & ((1 << self.bits) - 1)])

    def put(self, data: bytes, shared: dict[int, int]) -> bytes:
        """The whole byte, with the bits of the slaves before it in the same byte."""
        if not self.bits:
            return data
        shared[self.group] = shared.get(self.group, 0) | data[0] << self.shift
        return bytes([shared[self.group]])


def place_bits(lengths: list[int]) -> list[BitPlace]:
    """Places for slaves with so many bits in one direction."""
    places, position, group = [], 0, 0
    for number, bits in enumerate(lengths):
        if bits >= 8 or bits == 0:
            if bits:
                position, group = 0, group + 1
            places.append(BitPlace())
            continue
        if position + bits > 8:
            raise BusFileError(
                f"slave {number + 1}: its {bits} bits would cross a byte, which is not supported;"
                " put a slave of eight bits or more between the small ones"
            )
        places.append(BitPlace(position, bits, group))
        position += bits
        if position == 8:
            position, group = 0, group + 1
    return places
