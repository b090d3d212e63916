# SPDX-License-Identifier: Apache-2.0
"""Decodes text files: UTF-8 and UTF-16 with or without a byte order mark, else Windows-1252."""

from __future__ import annotations

import codecs
import re

from flatplank_tire.errors import FlatplankError

_MARKS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF32_LE, "utf-32-le"),  # before UTF-16, whose mark is its beginning
    (codecs.BOM_UTF32_BE, "utf-32-be"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
_LINE_END = re.compile(r"\r\n|\n|\r")
_START = 4096
"""bytes that tell UTF-16 without a mark"""


def decode_text(data: bytes, where: str) -> str:
    """The text of a file, without a byte order mark.

    Bytes that have no meaning in Windows-1252 become U+FFFD, which no number and no name contains.

    Raises:
        FlatplankError: the data are no text.
    """
    mark, encoding = next(((m, e) for m, e in _MARKS if data.startswith(m)), (b"", ""))
    body = data[len(mark) :]
    encoding = encoding or _without_mark(body)
    try:
        text = body.decode(encoding)
    except UnicodeDecodeError as error:
        if encoding != "utf-8":
            line = 1 + body[: error.start].decode(encoding, "replace").count("\n")
            raise FlatplankError(
                f"cut short or damaged: no {encoding.upper()} text", f"{where}, line {line}",
                "export or copy the file again",
            ) from None  # fmt: skip
        text = body.decode("cp1252", "replace")
    if "\0" in text:
        line = 1 + text[: text.index("\0")].count("\n")
        raise FlatplankError(
            "binary data, no text", f"{where}, line {line}", "export or copy the file again"
        )
    return text


def _without_mark(body: bytes) -> str:
    """UTF-16 has a zero in every second byte of digits, letters and separators."""
    start = body[:_START]
    for encoding, zeros in (("utf-16-le", start[1::2]), ("utf-16-be", start[0::2])):
        if zeros.count(0) > len(zeros) // 2:
            return encoding
    return "utf-8"


def lines_of(text: str) -> list[str]:
    """Lines without their ends (LF, CR LF or CR); no other character ends a line."""
    lines = _LINE_END.split(text)
    return lines if lines[-1] else lines[:-1]
