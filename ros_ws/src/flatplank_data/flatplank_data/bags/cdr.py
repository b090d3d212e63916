# SPDX-License-Identifier: Apache-2.0
"""CDR payloads to columns: the layout is found once, then many payloads are one numpy view.

Plain CDR (XCDR1), as ROS 2 writes it: four bytes of encapsulation, then members aligned to their
size. Texts and sequences have a length before them; payloads whose lengths agree share a layout.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from flatplank_data.bags.definitions import PRIMITIVES, MessageType
from flatplank_data.errors import FlatplankError

_START = 4


@dataclass
class Layout:
    """Where each member lies in a payload of `size` bytes."""

    size: int
    order: str
    members: dict[str, tuple[str, int]] = field(default_factory=dict)
    """path -> (numpy type, offset)"""
    texts: dict[str, tuple[int, int]] = field(default_factory=dict)
    """path -> (offset, bytes without the closing zero)"""
    lengths: list[tuple[int, int]] = field(default_factory=list)
    """(offset, value) of the length words; payloads must agree in them"""


class _Walk:
    """Walks one payload along its type."""

    def __init__(self, kind: MessageType, payload: bytes) -> None:
        if len(payload) < _START or payload[0] != 0 or payload[1] not in (0, 1):
            raise FlatplankError("payload is not plain CDR", kind.name, "record it with rosbag2")
        self.kind, self.payload, self.at = kind, payload, _START
        self.order = "<" if payload[1] == 1 else ">"
        self.layout = Layout(len(payload), self.order)

    def message(self, name: str, prefix: str) -> None:
        for item in self.kind.fields(name):
            path = prefix + item.name
            count = item.count
            if item.array and not item.count:
                count = self.length()
            for i in range(count):
                self.member(item.type, f"{path}[{i}]" if item.array else path)

    def member(self, kind: str, path: str) -> None:
        if kind in PRIMITIVES:
            code = PRIMITIVES[kind]
            size = int(code[1])
            self.at += (_START - self.at) % size
            self.layout.members[path] = (self.order + code, self.at)
            self.at += size
        elif kind == "string":
            size = self.length()
            self.layout.texts[path] = (self.at, max(size - 1, 0))
            self.at += size
        elif kind == "wstring":
            raise FlatplankError("wide strings are not read", path, "map other topics")
        else:
            self.message(kind, path + ".")
        if self.at > len(self.payload):
            raise FlatplankError("payload is cut short", path, "the bag is damaged")

    def length(self) -> int:
        self.at += (_START - self.at) % 4
        if self.at + 4 > len(self.payload):
            raise FlatplankError("payload is cut short", self.kind.name, "the bag is damaged")
        (value,) = struct.unpack_from(self.order + "I", self.payload, self.at)
        self.layout.lengths.append((self.at, value))
        self.at += 4
        return value


def layout_of(kind: MessageType, payload: bytes) -> Layout:
    """Layout of the payloads that look like this one."""
    walk = _Walk(kind, payload)
    walk.message(kind.name, "")
    return walk.layout


def decode_one(kind: MessageType, payload: bytes) -> dict[str, float | str]:
    """All members of one message by path."""
    layout = layout_of(kind, payload)
    out: dict[str, float | str] = {}
    for path, (code, at) in layout.members.items():
        out[path] = np.frombuffer(payload, dtype=code, count=1, offset=at)[0].item()
    for path, (at, size) in layout.texts.items():
        out[path] = payload[at : at + size].decode("utf-8", "replace")
    return out


def decode_many(
    kind: MessageType, payloads: np.ndarray, paths: Iterable[str]
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Members `paths` of payloads, a uint8 array of shape (messages, bytes).

    Returns the order (index of each decoded row) and the columns; payloads with other lengths of
    texts or sequences are decoded group by group.
    """
    paths = list(paths)
    rest = np.arange(len(payloads))
    rows: list[np.ndarray] = []
    parts: dict[str, list[np.ndarray]] = {path: [] for path in paths}
    while rest.size:
        layout = layout_of(kind, payloads[rest[0]].tobytes())
        same = np.ones(rest.size, dtype=bool)
        for at, value in layout.lengths:
            words = np.ascontiguousarray(payloads[rest, at : at + 4]).view(layout.order + "u4")
            same &= words[:, 0] == value
        chosen = rest[same]
        block = payloads if same.all() and rest.size == len(payloads) else payloads[chosen]
        for path, values in _view(layout, block, paths).items():
            parts[path].append(values)
        rows.append(chosen)
        rest = rest[~same]
    index = np.concatenate(rows) if rows else rest
    return index, {p: np.concatenate(v) if v else np.empty(0) for p, v in parts.items()}


def _view(layout: Layout, block: np.ndarray, paths: list[str]) -> dict[str, np.ndarray]:
    found = {path: layout.members[path] for path in paths if path in layout.members}
    kind = np.dtype(
        {
            "names": list(found),
            "formats": [code for code, _ in found.values()],
            "offsets": [at for _, at in found.values()],
            "itemsize": layout.size,
        }
    )
    table = np.ascontiguousarray(block).view(kind)[:, 0]
    missing = np.full(len(block), np.nan)
    return {path: table[path] if path in found else missing for path in paths}
