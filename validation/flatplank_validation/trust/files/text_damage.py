# SPDX-License-Identifier: Apache-2.0
"""Damages text files as cables, editors and spreadsheets do."""

from __future__ import annotations

import numpy as np

CELLS = (
    "OVL",
    "--",
    "",
    "nan",
    "1e999",
    "1.234",
    "1,234",
    "#REF!",
    "-",
    "12:30",
    "\N{DEGREE SIGN}",
)
MARKS = ",;\t. |\"'#\n\r\0\x0b\x85"


def damaged(data: bytes, random: np.random.Generator) -> bytes:
    """The data with one to three faults."""
    for _ in range(random.integers(1, 4)):
        data = FAULTS[random.integers(len(FAULTS))](data, random)
    return data


def _place(data: bytes, random: np.random.Generator) -> int:
    return int(random.integers(len(data) + 1))


def _cut(data: bytes, random: np.random.Generator) -> bytes:
    return data[: _place(data, random)]


def _lost(data: bytes, random: np.random.Generator) -> bytes:
    at = _place(data, random)
    return data[:at] + data[at + int(random.integers(1, 30)) :]


def _flipped(data: bytes, random: np.random.Generator) -> bytes:
    at = _place(data, random)
    return data[:at] + bytes([int(random.integers(256))]) + data[at + 1 :]


def _inserted(data: bytes, random: np.random.Generator) -> bytes:
    at = _place(data, random)
    return data[:at] + MARKS[random.integers(len(MARKS))].encode() + data[at:]


def _doubled(data: bytes, random: np.random.Generator) -> bytes:
    lines = data.split(b"\n")
    at = int(random.integers(len(lines)))
    return b"\n".join([*lines[:at], lines[at], *lines[at:]])


def _cell(data: bytes, random: np.random.Generator) -> bytes:
    """A cell of a line is another text."""
    lines = data.split(b"\n")
    at = int(random.integers(len(lines)))
    mark = next((m for m in (b"\t", b";", b",") if m in lines[at]), b" ")
    cells = lines[at].split(mark)
    cells[random.integers(len(cells))] = CELLS[random.integers(len(CELLS))].encode()
    lines[at] = mark.join(cells)
    return b"\n".join(lines)


def _line(data: bytes, random: np.random.Generator) -> bytes:
    lines = data.split(b"\n")
    lines.insert(
        int(random.integers(len(lines))),
        (b"Pause", b"# 1,2,3,4", b";;;", b"1")[random.integers(4)],
    )
    return b"\n".join(lines)


def _swapped(data: bytes, random: np.random.Generator) -> bytes:
    lines = data.split(b"\n")
    a, b = random.integers(len(lines), size=2)
    lines[a], lines[b] = lines[b], lines[a]
    return b"\n".join(lines)


FAULTS = (_cut, _lost, _flipped, _inserted, _doubled, _cell, _line, _swapped)
