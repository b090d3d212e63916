# SPDX-License-Identifier: Apache-2.0
"""Finds numbers that an output prints without a unit; what is legal without one stands here."""

from __future__ import annotations

import html
import re
from collections.abc import Iterator

UNITS = (
    "N|kN|Nm|kN/m|N/m|N/mm|Nm/deg|Nm/rad|N/rad|N/deg|kN/deg|N/%|m|mm|cm|km|um|%|bar|Pa|kPa|deg|rad|"
    "1/m|1/km|1/K|K|1/rad|s/m|s|ms|us|min|minutes|h|Hz|kHz|m/s|mm/s|rad/s|deg/s|N/s|%/kN|kg|B|kB|MB|GB|"
    "N/m3|N m s2|N m s|N m|kg m2|1/s2|1/s|m/s2|rad/s2|V"
)
"""a number is followed by one of these, with or without a space"""
COUNTED = (
    "axes|batches|campaigns|candidates|channels|columns|conditions|cycles|decoys|effects|faults|"
    "files|floors|others|parameters|problems|runs?|samples|slips|starts|steps|sweeps|times|"
    "random arrangements|cases|degrees of freedom|lost|more"
)
"""a number before these counts or multiplies"""
NUMBERED = (
    "P|p|e|chi2|starts?|step|stage|trial|seed|version|figure|table|section|Python|runs?|batch|"
    "p above|order|at most|Magic Formula|gains|costs|below|other than"
)
"""a number behind these is a probability, odds, an e-value, or one that names"""
FACTORS = "peak|shape|round|denom|tread|patch_order|turn_y|turn_rate|grip_y|slip_turned|range"
"""parameters that are plain factors"""
JOINTS = r"to|and|or|by|->|,|/|±|of|before|after"
"""between numbers that share the unit behind the last"""
BLOCKS = r"p|li|ul|ol|h\d|div|figcaption|figure|section|dt|dd|br|summary"
"""elements of a page that begin a line"""

_NUMBER = r"[-+−±]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?"
_FREE = re.compile(rf"(?<![\w.=/\\-]){_NUMBER}(?!\.?\w)|(?<=\w=){_NUMBER}")
_UNIT = re.compile(rf"\s?(?:{UNITS})(?![\w/])|\s+(?:\w+ )?(?:{COUNTED})\b")
_JOINED = re.compile(rf"\s*(?:{JOINTS})\s*(?={_NUMBER})")
_NAMED = re.compile(rf"(?:^|[\s(.])(?:{NUMBERED}|{FACTORS})\s?(?:=|<|>|at most|at least|:)?\s?$")
_PARTS_OF_NAMES = re.compile(
    r"\(\d+\.\d+[a-z]?\)"  # an equation of the thesis
    r"|\d{4}-\d\d-\d\d(?:[ T][\d:.]+)?"  # a date
    r"|\b\d+/\d+(?![\w/])"  # one of so many
    r"|[\w.-]*[/\\][\w./\\-]*[A-Za-z_][\w./\\-]*"  # a path
    r"|\b(?!\d*e[-+]?\d)[\w-]*[A-Za-z_][\w.]*-\d[\w.-]*"  # the name of a run
    r"|\bv?\d+\.\d+\.\d+\b|^\s*\d+\.(?= )|`[^`]*`|--\w+ \S+"  # version, item, command, option
)


def bare_numbers(text: str) -> Iterator[str]:
    """'number in: line', for every number of an output that has no unit and is no count; a cell of
    a table has the unit of its column."""
    header: list[str] = []
    for line in text.splitlines():
        cells = re.split(r"\s{2,}", line.strip())
        row = len(cells) > 2 and (not header or len(cells) == len(header))
        header = (header or cells) if row else []
        columns = zip(cells, header, strict=True) if row else [(line, "")]
        for part in [part for part, head in columns if not _has_unit(head)]:
            yield from (f"{number} in: {line}" for number in _bare(part))


def _has_unit(head: str) -> bool:
    """True for a column whose cells need no unit of their own."""
    return bool(re.search(r"\[.+\]", head) or re.fullmatch(f"{COUNTED}|{NUMBERED}", head))


def _bare(part: str) -> Iterator[str]:
    words = _PARTS_OF_NAMES.sub(_masked, part)
    seen = 0
    for found in _FREE.finditer(words):
        if found.start() < seen:
            continue
        seen = _end_of_row(words, found.end())
        if not (_NAMED.search(words[: found.start()]) or _UNIT.match(words, seen)):
            yield words[found.start() : seen]


def _masked(name: re.Match[str]) -> str:
    return "m" if name[0] in UNITS.split("|") else "~" * len(name[0])


def _end_of_row(words: str, end: int) -> int:
    """End of the last of the numbers that share one unit, the first of which ends at `end`."""
    while joint := _JOINED.match(words, end):
        end = re.compile(_NUMBER).match(words, joint.end()).end()
    return end


def text_of_page(page: str) -> str:
    """The running text of a page, without pictures, scripts and tables; a line for each block."""
    page = re.sub(r"(?s)<(style|script|svg|table|pre|head)\b.*?</\1>", "", page).replace("\n", " ")
    page = re.sub(rf"(?i)</?(?:{BLOCKS})\b[^>]*>", "\n", page)
    words = html.unescape(re.sub(r"<[^>]+>", "", page)).replace("\xa0", " ")
    return "\n".join(" ".join(line.split()) for line in words.splitlines())
