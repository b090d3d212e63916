# SPDX-License-Identifier: Apache-2.0
"""Serialises a whole run of one topic: one array whose rows are serialised messages.

A message whose texts and sequence lengths do not change has one fixed layout in CDR (XCDR1, little
endian, as all ROS 2 middlewares send it). `CdrLayout` computes it once, as a numpy structured type
over the serialised bytes: filling its columns serialises the messages.
"""

from __future__ import annotations

from collections.abc import Mapping
from struct import pack
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype

from flatplank_control.recording.typestore import typestore
from flatplank_data.bags.cdr import PRIMITIVES
from flatplank_data.errors import RecordingError
from flatplank_data.names import nearest_hint

ENCAPSULATION = b"\x00\x01\x00\x00"
"""first bytes of a CDR message: XCDR1, little endian"""
_FORMATS = {kind: f"<{code}" for kind, code in PRIMITIVES.items()} | {"bool": "?"}


class CdrLayout:
    """Serialised form of one message type with given texts and lengths.

    `fixed` maps field paths to constants: a text for a string, a list of texts for a sequence of
    strings, a length for any other sequence. Missing ones are empty. Columns of `dtype` are the
    paths of the numbers: `header.stamp.sec`, `wrench.force.x`, `position` (n entries),
    `status[0].level`.
    """

    def __init__(self, msgtype: str, fixed: Mapping[str, Any] | None = None) -> None:
        self.msgtype = msgtype
        self._store = typestore()
        self._fixed = dict(fixed or {})
        self._used: set[str] = set()
        self._columns: list[tuple[str, Any, int]] = []
        """(name, format, offset) of each column"""
        self._constants: list[tuple[int, bytes]] = [(0, ENCAPSULATION)]
        self._end = 4
        if msgtype not in self._store.fielddefs:
            raise RecordingError(f"{msgtype}: unknown message type; check the topic's type")
        self._message(msgtype, "")
        for path in self._fixed:
            if path not in self._used:
                hint = nearest_hint(path, self._used)
                raise RecordingError(f"{msgtype}: nothing is fixed at {path!r}{hint}")
        self.itemsize = self._end
        names, formats, offsets = ([column[k] for column in self._columns] for k in range(3))
        self.dtype = np.dtype(
            {"names": names, "formats": formats, "offsets": offsets, "itemsize": self.itemsize}
        )
        template = bytearray(self.itemsize)
        for offset, data in self._constants:
            template[offset : offset + len(data)] = data
        self._template = np.frombuffer(bytes(template), np.uint8)

    def new(self, count: int) -> np.ndarray:
        """Array of `count` messages of `dtype`, all numbers zero."""
        rows: np.ndarray = np.empty((count, self.itemsize), np.uint8)
        rows[:] = self._template
        return rows.view(self.dtype).reshape(count)

    def _align(self, size: int) -> None:
        self._end += -(self._end - 4) % size

    def _constant(self, data: bytes, alignment: int) -> None:
        self._align(alignment)
        self._constants.append((self._end, data))
        self._end += len(data)

    def _number(self, path: str, kind: str, shape: tuple[int, ...] = ()) -> None:
        form = _FORMATS.get(kind)
        if form is None:
            raise RecordingError(f"{self.msgtype}: {path} is a {kind}, which has no fixed layout")
        size = np.dtype(form).itemsize
        self._align(size)
        self._columns.append((path, (form, shape) if shape else form, self._end))
        self._end += size * int(np.prod(shape, dtype=int))

    def _text(self, text: str) -> None:
        data = text.encode() + b"\0"
        self._constant(pack("<I", len(data)) + data, 4)

    def _take(self, path: str, kind: type, default: Any) -> Any:
        self._used.add(path)
        value = self._fixed.get(path, default)
        if not isinstance(value, kind) or isinstance(value, bool):
            raise RecordingError(f"{self.msgtype}: {path} needs {kind.__name__}, not {value!r}")
        return value

    def _message(self, msgtype: str, prefix: str) -> None:
        for name, (node, detail) in self._store.fielddefs[msgtype][1]:
            if name == "structure_needs_at_least_one_member":
                self._end += 1  # never filled
            else:
                self._field(prefix + name, node, detail)

    def _field(self, path: str, node: int, detail: Any) -> None:
        if node == Nodetype.BASE and detail[0] == "string":
            self._text(self._take(path, str, ""))
        elif node == Nodetype.BASE:
            self._number(path, detail[0])
        elif node == Nodetype.NAME:
            self._message(detail, path + ".")
        else:
            self._elements(path, node, detail)

    def _elements(self, path: str, node: int, detail: Any) -> None:
        (kind, of), limit = detail
        is_text = kind == Nodetype.BASE and of[0] == "string"
        fixed_size = node == Nodetype.ARRAY
        if is_text:
            texts = self._take(path, list, [""] * limit if fixed_size else [])
            count = len(texts)
        else:
            count = limit if fixed_size else self._take(path, int, 0)
        if fixed_size and count != limit:
            raise RecordingError(f"{self.msgtype}: {path} has {limit} entries, not {count}")
        if not fixed_size:
            self._constant(pack("<I", count), 4)
        if is_text:
            for text in texts:
                self._text(text)
        elif kind == Nodetype.NAME:
            for number in range(count):
                self._message(of, f"{path}[{number}].")
        elif count:
            self._number(path, of[0], (count,))


def set_stamps(messages: np.ndarray, stamps_ns: np.ndarray, path: str = "header.stamp") -> None:
    """Fill a stamp, `stamps_ns` int64 [N] [ns]."""
    seconds, rest = np.divmod(stamps_ns, 1_000_000_000)
    messages[path + ".sec"] = seconds
    messages[path + ".nanosec"] = rest
