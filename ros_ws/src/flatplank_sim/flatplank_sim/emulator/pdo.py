# SPDX-License-Identifier: Apache-2.0
"""PDO assignment (0x1C12, 0x1C13) and mapping (0x16xx, 0x1Axx), writable in PREOP."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from flatplank_hw.ethercat.busfile import Entry, Pdo
from flatplank_hw.ethercat.layout import Layout, encode_value
from flatplank_sim.emulator.dictionary import (
    ABORT_CANNOT_MAP,
    ABORT_PDO_LENGTH,
    ABORT_STATE,
    Dictionary,
    Object,
    SdoAbort,
    Variable,
)

SLOTS = 32
MAX_BITS = 8 * 256


class PdoDirection:
    """All PDOs of one direction, with their mapping and assignment."""

    def __init__(
        self,
        assign_index: int,
        pdos: tuple[Pdo, ...],
        known: Mapping[tuple[int, int], Entry],
        free_mapping: bool,
        in_preop: Callable[[], bool],
    ) -> None:
        self.assign_index = assign_index
        self.known = known
        self.version = 0
        self.values: tuple[int, ...] = ()
        """last exchanged values of the assigned entries"""
        self._in_preop = in_preop
        self._pdos = pdos
        self._free = free_mapping
        self.reset()

    def reset(self) -> None:
        """Reset to the state after power-on."""
        self.mapped = {pdo.index: list(pdo.entries) for pdo in self._pdos}
        self.names = {pdo.index: pdo.name for pdo in self._pdos}
        self.assigned = [pdo.index for pdo in self._pdos if pdo.assigned]
        self._renew()

    def _renew(self) -> None:
        self.entries = [e for index in self.assigned for e in self.mapped[index]]
        self.layout = Layout([(e.kind, e.bits) for e in self.entries])
        self.version += 1

    def present_value(self, index: int, subindex: int, item: Variable) -> bytes:
        """Value from the process data when it is exchanged, else the stored value."""
        if len(self.values) == len(self.entries):
            for entry, value in zip(self.entries, self.values, strict=True):
                if (entry.index, entry.subindex) == (index, subindex):
                    return encode_value(entry.kind, value)
        return item.value

    def add_objects(self, dictionary: Dictionary) -> None:
        """Add the assignment and mapping objects to the dictionary."""
        objects, assign = dictionary.objects, self.assign_index
        name = "RxPDO assign" if assign == 0x1C12 else "TxPDO assign"
        objects[assign] = self._list(name, "uint16", list(self.assigned), self._assign, True)
        for index, entries in self.mapped.items():
            words, name = [e.mapping_word for e in entries], self.names[index]
            objects[index] = self._list(
                name or f"PDO {index:04X}", "uint32", words, partial(self._map, index), self._free
            )

    def _list(
        self, name: str, kind: str, words: list[int], apply: Callable[[list[int]], None],
        writable: bool,
    ) -> Object:  # fmt: skip
        """A counted list: it is emptied, filled, and made valid by writing its count."""
        found = Object(name, 9)
        slots = SLOTS if writable else len(words)

        def count_written(data: bytes) -> None:
            self._need_preop()
            items = [int.from_bytes(found.subs[i + 1].value, "little") for i in range(data[0])]
            apply(items)

        def slot_written(_data: bytes) -> None:
            self._need_preop()
            if found.subs[0].value != b"\0":
                raise SdoAbort(ABORT_STATE)

        found.subs[0] = Variable(
            "uint8", bytes([len(words)]), writable, "count", wrote=count_written
        )
        for i in range(slots):
            word = words[i] if i < len(words) else 0
            found.subs[i + 1] = Variable(
                kind, encode_value(kind, word), writable, "entry", wrote=slot_written
            )
        return found

    def _need_preop(self) -> None:
        if not self._in_preop():
            raise SdoAbort(ABORT_STATE)

    def _assign(self, items: list[int]) -> None:
        if any(index not in self.mapped for index in items):
            raise SdoAbort(ABORT_CANNOT_MAP)
        bits = sum(e.bits for index in items for e in self.mapped[index])
        if bits > MAX_BITS:
            raise SdoAbort(ABORT_PDO_LENGTH)
        self.assigned = items
        self._renew()

    def _map(self, pdo: int, items: list[int]) -> None:
        self.mapped[pdo] = [self._entry(word) for word in items]
        self._renew()

    def _entry(self, word: int) -> Entry:
        index, subindex, bits = word >> 16, word >> 8 & 0xFF, word & 0xFF
        if index == 0:
            pads = [e for e in self.known.values() if e.index == 0 and e.bits == bits]
            return pads[0] if pads else Entry(0, 0, "", bits)
        found = self.known.get((index, subindex))
        if found is None or found.bits != bits:
            raise SdoAbort(ABORT_CANNOT_MAP)
        return found


def known_entries(pdos: tuple[Pdo, ...]) -> dict[tuple[int, int], Entry]:
    """All objects in the PDOs of one direction; padding has negative keys."""
    known: dict[tuple[int, int], Entry] = {}
    for pdo in pdos:
        for entry in pdo.entries:
            key = (entry.index, entry.subindex) if entry.index else (-1, len(known))
            known.setdefault(key, entry)
    return known
