# SPDX-License-Identifier: Apache-2.0
"""Converts bytes of the slaves to `BusInputs` and `AxisCommand`s to bytes, by the bus file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flatplank_hw.bus.image import AXES, AxisCommand, AxisInputs, BusInputs, Digital
from flatplank_hw.cia402 import TORQUE_UNIT
from flatplank_hw.encoders.counter import wrapped
from flatplank_hw.ethercat import busfile
from flatplank_hw.ethercat.busfile import BusFile, Entry
from flatplank_hw.ethercat.layout import Layout, range_of_type
from flatplank_hw.ethercat.reader import BusFileError


@dataclass(frozen=True)
class BitPlace:
    """Position of the bits of one slave in the process image.

    Slaves with less than a byte share bytes of the logical image, and pysoem returns the whole
    byte. SOEM packs them one after the other; a slave with eight bits or more starts a new byte.
    """

    shift: int = 0
    bits: int = 0
    """0: whole bytes"""
    group: int = -1
    """number of the shared byte"""

    def extract_bits(self, data: bytes) -> bytes:
        """The bits of this slave alone."""
        if not self.bits or not data:
            return data
        return bytes([data[0] >> self.shift & ((1 << self.bits) - 1)])

    def insert_bits(self, data: bytes, shared: dict[int, int]) -> bytes:
        """Return the whole byte; `shared` (group -> byte) collects the bits of all its slaves."""
        if not self.bits:
            return data
        shared[self.group] = shared.get(self.group, 0) | data[0] << self.shift
        return bytes([shared[self.group]])


def place_bits(lengths: list[int]) -> list[BitPlace]:
    """Positions for slaves of the given lengths [bit] in one direction."""
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


class CounterExtension:
    """Extends an encoder counter that wraps at its own width; 32 bits pass through as int32."""

    def __init__(self, bits: int) -> None:
        self._bits = bits
        self._value: int | None = None

    def extend(self, raw: int) -> int:
        """Extended count for the next raw value; assumes a step of less than half the range."""
        if self._bits >= 32:
            return wrapped(raw)
        if self._value is None:
            self._value = raw
        half = 1 << (self._bits - 1)
        step = (raw - self._value + half) % (2 * half) - half
        self._value += step
        return wrapped(self._value)


_ZERO, _ECHO, _DIGITAL, _AXES = 0, 1, 2, 3
_WORDS = len(busfile.AXIS_OUTPUTS)


@dataclass(frozen=True)
class _Row:
    """Process data of one slave in one direction."""

    slave: int
    layout: Layout
    place: BitPlace


class InputImage:
    """Converts the input bytes of all slaves to one image of the bench."""

    def __init__(self, bus: BusFile) -> None:
        places = place_bits([s.input_bits for s in bus.slaves])
        self.rows = [
            _Row(i, Layout([(e.kind, e.bits) for e in s.input_entries]), places[i])
            for i, s in enumerate(bus.slaves)
            if s.input_bits
        ]
        found: dict[str, tuple[int, Entry]] = {}
        for position, entry in enumerate(e for s in bus.slaves for e in s.input_entries):
            if entry.channel:
                found[entry.channel] = (position, entry)
        self._volts = [_scaled(found.get(n)) for n in busfile.VOLTS]
        self._counts = [_counter(found.get(n)) for n in busfile.COUNTS]
        self._bits = [(found[n][0], int(bit)) for n, bit in busfile.DIGITAL.items() if n in found]
        unmonitored = "emergency_stop_ok" not in found
        self._always = int(Digital.EMERGENCY_STOP_OK) if unmonitored else 0
        self._axes = [_axis(found, name) for name in AXES]

    def decode(self, data: Sequence[bytes], cycle: int, stamp_ns: int, health: int) -> BusInputs:
        """One cycle of inputs; data: input bytes per slave, in the order of the bus file."""
        flat: list[int] = [0]
        for row in self.rows:
            flat += row.layout.unpack(row.place.extract_bits(data[row.slave]))
        volts = [flat[at + 1] * scale for at, scale in self._volts]
        counts = [counter.extend(flat[at + 1]) for at, counter in self._counts]
        digital = self._always
        for at, bit in self._bits:
            if flat[at + 1]:
                digital |= bit
        axes = tuple(
            [
                AxisInputs(
                    flat[a[0]],
                    flat[a[1]],
                    flat[a[2]],
                    flat[a[3]],
                    round(flat[a[4]] * scale),
                    flat[a[5]],
                )
                for a, scale in self._axes
            ]
        )
        return BusInputs._make(
            [cycle, stamp_ns, tuple(volts[:6]), volts[6], *counts, digital, health, axes]
        )


class OutputImage:
    """Converts commands to output bytes, with the echo of the cycle in a padding byte."""

    def __init__(self, bus: BusFile) -> None:
        places = place_bits([s.output_bits for s in bus.slaves])
        self.rows: list[tuple[_Row, list[int], list[tuple[int, int]]]] = []
        self.echo: tuple[int, int] | None = None
        """slave and byte of the echo; None: the bus file has none"""
        self._torque_scale = [1.0] * len(AXES)
        for i, slave in enumerate(bus.slaves):
            if not slave.output_bits:
                continue
            entries = slave.output_entries
            row = _Row(i, Layout([(e.kind, e.bits) for e in entries]), places[i])
            sources = [self._source(e) for e in entries]
            # a padding entry carries zero or the echo of the cycle
            ranges = [range_of_type(e.kind or "uint64") for e in entries]
            self.rows.append((row, sources, ranges))
            self._find_echo(i, entries)

    def encode(
        self, commands: Sequence[AxisCommand], digital_outputs: int, echo: int
    ) -> list[tuple[int, bytes]]:
        """(slave, output bytes) for each slave with outputs; values are limited to the range of
        their type."""
        flat = [0, echo & 0xFF, digital_outputs] + [0] * (_WORDS * len(AXES))
        for c in commands:
            at = _AXES + _WORDS * c.axis
            torque = round(c.target_torque * self._torque_scale[c.axis])
            flat[at : at + _WORDS] = (
                c.control_word,
                c.mode,
                c.target_position,
                c.target_velocity,
                torque,
            )
        shared: dict[int, int] = {}
        out = []
        for row, sources, ranges in self.rows:
            values = [
                min(max(flat[s], low), high)
                for s, (low, high) in zip(sources, ranges, strict=True)
            ]
            out.append((row.slave, row.place.insert_bits(row.layout.pack(values), shared)))
        return out

    def _source(self, entry: Entry) -> int:
        name = entry.channel
        if name == busfile.ECHO:
            return _ECHO
        if name == busfile.DIGITAL_OUTPUTS:
            return _DIGITAL
        axis, _, word = name.partition(".")
        if not word:
            return _ZERO
        number = AXES.index(axis)
        if entry.unit_nm:
            self._torque_scale[number] = TORQUE_UNIT / entry.unit_nm
        return _AXES + _WORDS * number + busfile.AXIS_OUTPUTS.index(word)

    def _find_echo(self, slave: int, entries: tuple[Entry, ...]) -> None:
        bit = 0
        for entry in entries:
            if entry.channel == busfile.ECHO and bit % 8 == 0 and entry.bits == 8:
                self.echo = (slave, bit // 8)
            bit += entry.bits


def expected_counter(bus: BusFile) -> int:
    """Working counter of a good cycle: 2 per slave with outputs, 1 per slave with inputs."""
    return sum(2 * (s.output_bits > 0) + (s.input_bits > 0) for s in bus.slaves)


def _scaled(found: tuple[int, Entry] | None) -> tuple[int, float]:
    """Index and volts per count; index -1 means the zero of a missing channel."""
    if found is None:
        return -1, 0.0
    position, entry = found
    return position, entry.full_scale_volts / entry.full_scale_counts


def _counter(found: tuple[int, Entry] | None) -> tuple[int, CounterExtension]:
    return (
        (-1, CounterExtension(32))
        if found is None
        else (found[0], CounterExtension(found[1].bits))
    )


def _axis(found: dict[str, tuple[int, Entry]], name: str) -> tuple[tuple[int, ...], float]:
    places = [found.get(f"{name}.{word}") for word in busfile.AXIS_INPUTS]
    torque = found.get(f"{name}.torque")
    scale = torque[1].unit_nm / TORQUE_UNIT if torque else 1.0
    return tuple(0 if p is None else p[0] + 1 for p in places), scale
