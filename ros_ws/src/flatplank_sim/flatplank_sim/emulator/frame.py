# SPDX-License-Identifier: Apache-2.0
"""Parses EtherCAT frames: Ethernet header, EtherCAT header, datagrams with working counters."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from flatplank_data.errors import FlatplankError

HEADER = 16
"""Ethernet (14) and EtherCAT (2) header [byte]"""
DATAGRAM_HEADER = 10


class Command(IntEnum):
    """Datagram commands."""

    NOP = 0
    APRD = 1
    APWR = 2
    APRW = 3
    FPRD = 4
    FPWR = 5
    FPRW = 6
    BRD = 7
    BWR = 8
    BRW = 9
    LRD = 10
    LWR = 11
    LRW = 12
    ARMW = 13
    FRMW = 14


class FrameError(FlatplankError):
    """The bytes are no EtherCAT frame, or its lengths do not match."""


@dataclass(slots=True)
class Datagram:
    """Position of one datagram in its frame."""

    command: int
    start: int
    """offset of the datagram header [byte]"""
    data: int
    """offset of the data [byte]"""
    length: int
    """length of the data [byte]"""

    @property
    def counter(self) -> int:
        """Offset of the working counter [byte]."""
        return self.data + self.length


def is_ethercat(frame: bytes | bytearray) -> bool:
    """True when the EtherType is that of EtherCAT."""
    return len(frame) >= HEADER + DATAGRAM_HEADER + 2 and frame[12] == 0x88 and frame[13] == 0xA4


def split(frame: bytes | bytearray) -> list[Datagram]:
    """Datagrams of a frame, in order."""
    if not is_ethercat(frame):
        raise FrameError("not an EtherCAT frame")
    header = frame[14] | frame[15] << 8
    if header >> 12 != 1:
        raise FrameError(f"EtherCAT type {header >> 12}, expected 1")
    end = HEADER + (header & 0x07FF)
    if end > len(frame):
        raise FrameError("frame is cut short")
    datagrams = []
    start, more = HEADER, True
    while more:
        if start + DATAGRAM_HEADER + 2 > end:
            raise FrameError("datagram reaches over the end")
        word = frame[start + 6] | frame[start + 7] << 8
        length, more = word & 0x07FF, bool(word & 0x8000)
        if start + DATAGRAM_HEADER + length + 2 > end:
            raise FrameError("datagram reaches over the end")
        datagrams.append(Datagram(frame[start], start, start + DATAGRAM_HEADER, length))
        start += DATAGRAM_HEADER + length + 2
    return datagrams
