# SPDX-License-Identifier: Apache-2.0
"""Numbers and data types of ESI and ENI files.

The data type of a CiA 402 object comes from CiA 402: makers write DINT, INT32, INTEGER32, UDINT or
nothing for the same object.
"""

from __future__ import annotations

import re

from flatplank_data.errors import FlatplankError
from flatplank_hw.ethercat.layout import TYPES


class EsiError(FlatplankError):
    """A device description that cannot be used, described in one line."""


_HEXADECIMAL = re.compile(r"[#0][xX]([0-9a-fA-F]+)")
_DECIMAL = re.compile(r"\+?[0-9]+")


def parse_number(text: str | None, where: str, high: int = 0xFFFFFFFF) -> int:
    """Parse '#x1A00', '0x1A00' or a decimal number, which may have leading zeros; EsiError beyond
    0 .. `high`."""
    if text is None or not text.strip():
        raise EsiError(f"{where} is missing")
    word = text.strip()
    if found := _HEXADECIMAL.fullmatch(word):
        value = int(found.group(1), 16)
    elif _DECIMAL.fullmatch(word):
        value = int(word, 10)
    else:
        raise EsiError(f"{where} is '{_shown(word)}', not a number such as 26, #x1A or 0x1A")
    if value > high:
        raise EsiError(f"{where} is {_shown(word)}, must be within 0 .. {high}")
    return value


def _shown(text: str) -> str:
    return " ".join(text.split())[:40]


_WIDTHS = (8, 16, 24, 32, 40, 48, 56, 64)
_NAMES = {
    **{f"{word}{n}": f"int{n}" for n in _WIDTHS for word in ("INT", "INTEGER")},
    **{f"{word}{n}": f"uint{n}" for n in _WIDTHS for word in ("UINT", "UNSIGNED")},
    **{f"BITARR{n}": f"uint{n}" for n in (8, 16, 32)},
    **{f"BIT{n}": f"bit{n}" for n in range(2, 9)},
    "BOOL": "bool", "BOOLEAN": "bool", "BIT": "bool", "BIT1": "bool",
    "SINT": "int8", "INT": "int16", "DINT": "int32", "LINT": "int64",
    "USINT": "uint8", "UINT": "uint16", "UDINT": "uint32", "ULINT": "uint64",
    "BYTE": "uint8", "WORD": "uint16", "DWORD": "uint32",
}  # fmt: skip
NAMES = {name: kind for name, kind in _NAMES.items() if kind in TYPES}
"""type name of ETG.2000 or of a maker -> type of the bus file"""
BY_BITS = {1: "bool", **{n: f"bit{n}" for n in range(2, 8)}}
BY_BITS |= {n: f"uint{n}" for n in (8, 16, 24, 32, 64)}
"""number of bits -> type of an object whose type is not known"""

CIA402_TYPES = {
    **dict.fromkeys(
        (
            0x6040, 0x6041, 0x603F, 0x6066, 0x6068, 0x606D, 0x606E, 0x606F, 0x6070, 0x6072,
            0x6073, 0x60E0, 0x60E1,
        ),
        "uint16",
    ),
    **dict.fromkeys((0x6060, 0x6061, 0x6098), "int8"),
    **dict.fromkeys((0x607E,), "uint8"),
    **dict.fromkeys(
        (
            0x605A, 0x605B, 0x605C, 0x605D, 0x605E, 0x6007, 0x6071, 0x6074, 0x6077, 0x6078, 0x6086,
            0x6088, 0x60B2,
        ),
        "int16",
    ),
    **dict.fromkeys(
        (
            0x6062, 0x6063, 0x6064, 0x6069, 0x606B, 0x606C, 0x607A, 0x607C, 0x60B0, 0x60B1, 0x60BA,
            0x60BB, 0x60BC, 0x60BD, 0x60E4, 0x60F4, 0x60FA, 0x60FC, 0x60FF,
        ),
        "int32",
    ),
    **dict.fromkeys(
        (
            0x6065, 0x6067, 0x6075, 0x6076, 0x6079, 0x607F, 0x6080, 0x6081, 0x6082, 0x6083, 0x6084,
            0x6085, 0x6087, 0x609A, 0x60C5, 0x60C6, 0x60FD, 0x6502,
        ),
        "uint32",
    ),
}  # fmt: skip
"""object of CiA 402 with subindex 0 -> its type (IEC 61800-7-201, object tables)"""
AXIS_STEP = 0x800
"""CiA 402: the objects of the next axis of a drive are so much higher"""


def cia402_type(index: int, subindex: int) -> str:
    """Type of an object of a drive by CiA 402; empty when it has none."""
    profile = 0x6000 <= index < 0xA000 and subindex == 0
    first = 0x6000 + (index - 0x6000) % AXIS_STEP
    return CIA402_TYPES.get(index) or CIA402_TYPES.get(first, "") if profile else ""


def type_of(raw: str, bits: int, where: str) -> tuple[str, bool]:
    """Type of an object from the text of DataType and its length, and whether the text says it;
    EsiError where they contradict each other."""
    known = NAMES.get(raw.upper().replace(" ", ""))
    kind = known or BY_BITS.get(bits)
    if kind is None:
        raise EsiError(f"{where} has type '{_shown(raw)}' of {bits} bits, which is not known")
    if TYPES[kind][0] != bits:
        raise EsiError(
            f"{where} has {bits} bits, its type {_shown(raw)} has {TYPES[kind][0]} bits: ask the "
            "maker for a corrected file"
        )
    return kind, known is not None
