# SPDX-License-Identifier: Apache-2.0
"""Finds numbers that an output prints without a unit; what is legal without one stands here."""

from __future__ import annotations

import html
import re
from collections.abc import Iterator

UNITS = (
    "N|kN|Nm|kN/m|N/m|N/mm|Nm/deg|Nm/rad|N/rad|N/deg|kN/deg|N/%|m|mm|cm|km|um|%|bar|Pa|kPa|deg|rad|"
    "1/m|1/km|1/K|K|1/rad|s/m|s|ms|us|min|minutes|h|Hz|kHz|m/s|mm/s|rad/s|deg/s|N/s|%/kN|kg|B|kB|MB|GB|"
    "N/m3|N m s2|N m s|N m|kg m2|1/s2|1/s|m/s2|rad/s2|V|km/h"
)
"""a number is followed by one of these, with or without a space"""
COUNTED = (
    "axes|bins|angles|pressures|slip levels|investigations|batches|campaigns|candidates|"
    "channels|columns|conditions|cycles|decoys|effects|faults|files|floors|loads?|"
    "operating points?|others|parameters|problems|runs?|samples|slips|starts|steps|sweeps|"
    "times|random arrangements|cases|degrees of freedom|lost|more"
)
"""a number before these counts or multiplies"""
NUMBERED = (
    "P|p|e|chance|ISO|accepted|minute|ratio of|[Aa]bove|condition|chi2|starts?|step|stage|"
    "trial|seeds?|version|figure|[Tt]ables?|section|Python|runs?|batch|[Tt]hesis|Pacejka|"
    "by these data: ±|p above|order|at most|Magic Formula|gains|costs|below|other than"
)
"""a number behind these is a probability, odds, an e-value, or one that names"""
FACTORS = (
    "peak|shape|round|denom|tread|patch_order|turn_y|turn_rate|grip_y|slip_turned|range"
    r"|P[A-Z]{2}\d"
)
"""parameters that are plain factors, those of the Magic Formula among them"""
PLAIN = r"corr\(σ, F\)|rest / rolling|cycles lost|C|E|R2"
"""columns of plain factors and counts"""
UNIT_OF_ROW = "unit"
"""column with the unit of the other cells of its row"""
JOINTS = r"to|and|or|by|->|,|/|±|of|before|after"
"""between numbers that share the unit behind the last"""
BLOCKS = r"p|li|ul|ol|h\d|div|figcaption|figure|section|dt|dd|br|summary"
"""elements of a page that begin a line"""

_NUMBER = r"[-+−±–]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?"
_POWER = re.compile(r"(?<![\w.])[-+−]?\d+(?:\.\d+)?e[-+−]?\d+(?!\w)")
_FREE = re.compile(rf"(?<![\w.=/\\-]){_NUMBER}(?!\.?\w)|(?<=\w=){_NUMBER}")
_UNIT = re.compile(rf"\s?(?:{UNITS})(?![\w/])|\s+(?:\w+ )?(?:{COUNTED})\b")
_JOINED = re.compile(rf"\s*(?:{JOINTS})\s*(?={_NUMBER})")
_NAMED = re.compile(rf"(?:^|[\s(.])(?:{NUMBERED}|{FACTORS})\s?(?:=|<|>|at most|at least|:)?\s?$")
_PARTS_OF_NAMES = re.compile(
    r"\(\d+\.\d+[a-z]?(?:, \d+\.\d+[a-z]?)*\)|\b[A-Z]\.\d+(?:, \d+\.\d+)*"  # of the thesis
    r"|\(1 \+ [^)]*\)|[<>=] 0\b(?!\.)"  # equations, comparisons with 0
    r"|\w+_deg: \[[^]]*\]|(?<=[.;:] )-?\d: "  # a line of a plan, what a value means
    r"|\d{4}-\d\d-\d\d(?:[ T][\d:.]+)?"  # a date
    r"|\b\d+/\d+(?![\w/])"  # one of so many
    r"|[\w.-]*[/\\][\w./\\-]*[A-Za-z_][\w./\\-]*"  # a path
    r"|\b(?!\d*e[-+]?\d)[\w-]*[A-Za-z_][\w.]*-\d[\w.-]*"  # the name of a run
    r"|\bv?\d+\.\d+\.\d+\b|^\s*\d+\.(?= )|`[^`]*`|--\w+ \S+"  # version, item, command, option
)


def bare_numbers(text: str) -> Iterator[str]:
    """'number in: line', for every number of an output that has no unit and is no count; a cell of
    a table has the unit of its column. And every number that is written with a power of ten."""
    header: list[str] = []
    title = ""
    for line in filter(str.strip, text.splitlines()):
        yield from (f"{number} in: {line}" for number in _POWER.findall(line))
        cells = re.split(r"\t|\s{2,}", line.strip())
        row = "\t" in line.strip() or len(cells) > 2
        row = row and (not header or len(cells) <= len(header))
        header, title = ((header or cells), title) if row else ([], line)
        columns = zip(cells, header, strict=False) if row else [(line, "")]
        given = row and (_has_unit(title) or UNIT_OF_ROW in header)
        for part in [part for part, head in columns if not _has_unit(head)]:
            if not (given and re.fullmatch(rf"\(?{_NUMBER}\)?|~", part)):
                yield from (f"{number} in: {line}" for number in _bare(part))


def _has_unit(head: str) -> bool:
    """True for a column whose cells need no unit of their own."""
    return bool(re.search(r"\[.+\]", head) or re.fullmatch(f"{COUNTED}|{NUMBERED}|{PLAIN}", head))


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
    return "m" if name[0].rstrip(".") in UNITS.split("|") else "~" * len(name[0])


def _end_of_row(words: str, end: int) -> int:
    """End of the last of the numbers that share one unit, the first of which ends at `end`."""
    while joint := _JOINED.match(words, end):
        end = re.compile(_NUMBER).match(words, joint.end()).end()
    return end


def text_of_page(page: str) -> str:
    """The text of a page, without pictures and scripts; a line for each block and each row."""
    page = re.sub(r"(?s)<(style|script|svg|pre|head)\b.*?</\1>", "", page).replace("\n", " ")
    page = re.sub(r"(<t[dh]\b[^>]*>)\s*(?=</t[dh]>)", r"\1~", page)
    page = re.sub(r"</t[dh]>", "\0", re.sub(r"(?i)</?tr\b[^>]*>", "\n", page))
    page = page.replace("</b><span>", "</b> ")  # a number and its caption
    page = re.sub(rf"(?i)</?(?:{BLOCKS})\b[^>]*>", "\n", page)
    words = html.unescape(re.sub(r"<[^>]+>", "", page)).replace("\xa0", " ")
    lines = (" ".join(line.split()) for line in words.split("\n"))
    return "\n".join(re.sub(" ?\0 ?", "\t", line).rstrip("\t") for line in lines)
