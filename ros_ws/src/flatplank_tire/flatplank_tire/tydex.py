# SPDX-License-Identifier: Apache-2.0
"""Reads and writes TYDEX 1.3 (Unrau, Zamow 1997), the text format for tire measurements.

Lines have fields of fixed width: name 10, explanation 30, unit 10, then numbers of 10 characters.
Channels have a factor a and two offsets b, c: physical value = a (measured value + b) + c. `!`
starts a comment. A value takes ten characters, with or without a blank before the next one; a
sample may span lines.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from flatplank_tire.errors import FlatplankError
from flatplank_tire.numbers import NotNumbers, cell_numbers, number_of
from flatplank_tire.text import lines_of

KEYWORDS = (
    "HEADER",
    "COMMENTS",
    "CONSTANTS",
    "MEASURCHANNELS",
    "MEASURDATA",
    "MODELDEFINITION",
    "MODELPARAMETERS",
    "MODELCOEFFICIENTS",
    "MODELCHANNELS",
    "MODELOUTPUTS",
    "MODELEND",
    "END",
)
MISSING = "NOTAVAIL"


@dataclass(frozen=True)
class Quantity:
    """A constant: its unit and its value as written."""

    unit: str
    value: str
    note: str = ""


@dataclass(frozen=True)
class Channel:
    """A measured channel; physical value = factor (measured + before) + after, in `unit`."""

    name: str
    unit: str
    factor: float = 1.0
    before: float = 0.0
    after: float = 0.0
    note: str = ""


@dataclass(frozen=True)
class TydexFile:
    """Content of a file; `data` has shape (samples, channels), physical values."""

    header: Mapping[str, str] = field(default_factory=dict)
    comments: Sequence[str] = ()
    constants: Mapping[str, Quantity] = field(default_factory=dict)
    channels: Sequence[Channel] = ()
    data: np.ndarray = field(default_factory=lambda: np.empty((0, 0)))
    not_numbers: Mapping[str, NotNumbers] = field(default_factory=dict)
    """by channel: cells with other text, which are NaN in `data`"""


def parse_tydex(text: str, name: str) -> TydexFile:
    """Parse the text of a file; `name` is used in errors."""
    sections, ended = _sections(text, name)
    if "HEADER" not in sections:
        raise FlatplankError("no **HEADER", name, "is this a TYDEX file?")
    if not ended:
        raise FlatplankError("no **END: the file is cut short", name, "export or copy it again")
    header = {
        line[:10].strip().upper(): line[40:].strip() for _, line in sections["HEADER"] if line[:10]
    }
    constants = {}
    for number, line in sections.get("CONSTANTS", []):
        key, value = line[:10].strip().upper(), line[50:].strip()
        if key in constants:
            raise FlatplankError(f"constant {key} twice", f"{name}, line {number}", "remove one")
        constants[key] = Quantity(line[40:50].strip(), value, line[10:40].strip())
    channels = [_channel(line, f"{name}, line {n}") for n, line in sections["MEASURCHANNELS"]]
    names = [channel.name for channel in channels]
    twice = next((n for n in names if names.count(n) > 1), None)
    if twice is not None:
        raise FlatplankError(f"channel {twice} twice", name, "remove one")
    data, others = _data(sections["MEASURDATA"], channels, name)
    comments = [line for _, line in sections.get("COMMENTS", [])]
    return TydexFile(header, comments, constants, channels, data, others)


def _sections(text: str, name: str) -> tuple[dict[str, list[tuple[int, str]]], bool]:
    sections: dict[str, list[tuple[int, str]]] = {"MEASURCHANNELS": [], "MEASURDATA": []}
    current, ended = "", False
    for number, raw in enumerate(lines_of(text), start=1):
        line = raw.expandtabs(10).rstrip()
        if line.startswith("**"):
            current = line[2:].strip().split(" ")[0].upper()
            if current not in KEYWORDS:
                raise FlatplankError(
                    f"unknown keyword **{current}",
                    f"{name}, line {number}",
                    f"TYDEX 1.3 has {', '.join(KEYWORDS)}",
                )
            ended = ended or current == "END"
            sections.setdefault(current, [])
        elif current and line.strip() and not line.startswith("!") and not ended:
            sections[current].append((number, line))
    return sections, ended


def _channel(line: str, where: str) -> Channel:
    key, note, unit = line[:10].strip().upper(), line[10:40].strip(), line[40:50].strip()
    cells = line[50:].split()
    if not unit:
        raise FlatplankError(
            f"channel {key} has no unit", where, "write it in columns 41-50, '-' for a bare number"
        )
    numbers = [number for cell in cells[:3] if (number := number_of(cell)) is not None]
    if len(numbers) < len(cells[:3]):
        raise FlatplankError(
            f"channel {key}: '{' '.join(cells)}' is no factor", where, "columns 51-60 hold it"
        )
    factor, before, after = numbers + [1.0, 0.0, 0.0][len(numbers) :]
    return Channel(key, unit, factor, before, after, note)


def _data(
    lines: list[tuple[int, str]], channels: list[Channel], name: str
) -> tuple[np.ndarray, dict[str, NotNumbers]]:
    """Physical values (samples, channels), and the cells that are no numbers."""
    if not channels:
        raise FlatplankError("no channels", name, "needs **MEASURCHANNELS")
    cells: list[str] = []
    places: list[int] = []
    for number, line in lines:
        found = line.split()
        if any(len(cell) > 10 for cell in found):
            found = [line[i : i + 10].strip() for i in range(0, len(line), 10)]
        cells += found
        places += [number] * len(found)
    rest = len(cells) % len(channels)
    if rest or not cells:
        row = len(cells) // len(channels) + 1
        raise FlatplankError(
            f"{rest} of {len(channels)} values" if rest else "no samples",
            f"{name}, sample {row}, line {lines[-1][0] if lines else 0}",
            "the data are cut short: export or copy the file again",
        )
    values, other = cell_numbers(cells, name)
    others = {}
    for column, channel in enumerate(channels):
        bad = np.flatnonzero(other[column :: len(channels)])
        if bad.size:
            at = column + bad[0] * len(channels)
            first = f"'{cells[at]}' in line {places[at]}"
            others[channel.name] = NotNumbers(bad.size, len(cells) // len(channels), first)
    factor, before, after = np.array([(c.factor, c.before, c.after) for c in channels]).T
    return (values.reshape(-1, len(channels)) + before) * factor + after, others


def format_tydex(file: TydexFile) -> str:
    """The text of a file; data are written unscaled, with factor 1."""
    lines = ["**HEADER"]
    lines += [f"{key[:10]:<10}{'':<30}{value}" for key, value in file.header.items()]
    lines += ["**COMMENTS", *file.comments, "**CONSTANTS"]
    for key, quantity in file.constants.items():
        lines.append(
            f"{key[:9]:<10}{quantity.note[:29]:<30}{quantity.unit[:9]:<10}{quantity.value}"
        )
    lines.append("**MEASURCHANNELS")
    for channel in file.channels:
        start = f"{channel.name[:9]:<10}{channel.note[:29]:<30}{channel.unit[:9]:<10}"
        lines.append(f"{start}{1.0:<10g}{0.0:<10g}{0.0:<10g}".rstrip())
    lines.append("**MEASURDATA")
    lines += _rows(file.data)
    return "\n".join([*lines, "**END", ""])


def _rows(data: np.ndarray) -> list[str]:
    """One line per sample, ten columns per value."""
    return ["".join(f"{_number(value):>9} " for value in sample).rstrip() for sample in data]


def _number(value: float) -> str:
    """The number with as many digits as fit in nine characters."""
    if not np.isfinite(value):
        return MISSING
    digits = 9
    while len(text := f"{value:.{digits}g}".replace("e-0", "e-").replace("e+0", "e")) > 9:
        digits -= 1
    return text
