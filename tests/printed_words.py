# SPDX-License-Identifier: Apache-2.0
"""Finds what an output prints as a heading, and the glossary does not have."""

from __future__ import annotations

import html
import re
from collections.abc import Collection, Iterator

from flatplank_analysis.effects.registry import library
from flatplank_analysis.words import known

LABEL = re.compile(r"^([A-Za-z][\w '-]*?(?:(?:, | or )[\w ]+)*):(?: |$)")
"""heading of a line: what stands before its first colon"""
ABOUT = re.compile(r" (?:of|over|for) | \d")
"""a heading says behind this what it is about"""
ORDER = "in this order"
"""behind the heading of a list"""
LEVEL = re.compile(r"[+-]?\d+ %")
"""column of a slip level"""
HEADER = re.compile(r"(?s)<(th|dt)\b[^>]*>(.*?)</\1>")


def unknown_labels(text: str, own: Collection[str] = ()) -> list[str]:
    """Headings of the lines of a text that are neither words nor names of effects.

    own: names of effects beside those of the library.
    """
    names = {*library(), *own, ORDER}
    found = map(LABEL.match, text.splitlines())
    labels = [ABOUT.split(label[1])[0] for label in found if label]
    parts = {label: re.split(", | or ", label) for label in labels}
    return [k for k, each in parts.items() if not all(known(p) or p in names for p in each)]


def unknown_headers(text: str) -> list[str]:
    """Headers of tables in a text that are no words."""
    return [name for name in headers_of(text) if not (known(name) or LEVEL.fullmatch(name))]


def unknown_in_page(page: str) -> list[str]:
    """Headers of the tables and lists of a page that are no words; the others have their sentence
    as hover text."""
    cells = [cell for _, cell in HEADER.findall(page)]
    return [
        cell
        for cell in cells
        if not (known(_plain(cell)) and "<abbr title=" in cell) and not LEVEL.fullmatch(cell)
    ]


def _plain(cell: str) -> str:
    return html.unescape(re.sub(r"<[^>]+>", "", cell)).strip()


def headers_of(text: str) -> Iterator[str]:
    """Cells of the lines that begin a table: three columns or more, above a line of such."""
    lines = [re.split(r"\s{2,}", line.strip()) for line in text.splitlines()]
    above = [[], *lines]
    for before, line, row in zip(above, lines, lines[1:], strict=False):
        if len(before) < 3 <= min(len(line), len(row)):
            yield from line
