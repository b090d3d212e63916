# SPDX-License-Identifier: Apache-2.0
"""The file of a proposal: a sentence of the grammar as YAML, for the engineer and for the search.

Reading runs no code: every key is a number, a word of the grammar, or a text that is only shown.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from flatplank_analysis.effects.grammar import modulators
from flatplank_analysis.effects.grammar.hooks import HOOKS, NONE
from flatplank_analysis.effects.grammar.sentence import Sentence, Site, SiteCoordinate
from flatplank_analysis.effects.grammar.shapes import shapes
from flatplank_analysis.effects.grammar.shapes.base import PLACE, Span
from flatplank_analysis.effects.grammar.sweep_hooks import SWEEP_HOOKS
from flatplank_data.errors import FlatplankError
from flatplank_data.names import nearest_hint
from flatplank_data.yaml_text import dump_yaml, load_yaml

FORMAT = "flatplank-proposal/1"
SUFFIX = ".yaml"
EVENT = "distance since the step"
"""coordinate whose zero is the event"""
KEYS = (
    "format", "name", "what", "check", "acts_on", "over", "within", "unit", "form", "numbers",
    "when", "interval", "evidence",
)  # fmt: skip
ACTS_ON = {h.name: h for h in (*HOOKS, *SWEEP_HOOKS)}
NEEDED = ("name", "acts_on", "form")
REMEDY = "leave the file as `flatplank propose` wrote it"
HEAD = """\
# A proposed effect, not confirmed: `flatplank confirm` tests it on new runs. When you know the
# cause, give it the name of the cause, and write what you found to `what` and `check`. SI units.
"""


def text_of(s: Sentence) -> str:
    """The file of a sentence."""
    hook, coordinate = s.site.hook, s.site.coordinate
    span = coordinate.span
    data: dict[str, Any] = {
        "format": FORMAT, "name": s.identifier, "what": s.what, "check": s.check,
        "acts_on": hook.name,
    }  # fmt: skip
    if coordinate.name:
        data |= {"over": coordinate.name, "within": [span.low, span.high], "unit": span.unit}
    data["form"] = s.shape.name
    if s.shape.numbers:
        data["numbers"] = {n.name: _short(s.numbers[n.name]) for n in s.shape.numbers}
    data |= {"when": s.site.modulator.name} if s.site.modulator.name else {}
    data |= {"interval": [_short(v) for v in s.interval]} if s.interval else {}
    data |= {"evidence": list(s.evidence)} if s.evidence else {}
    return HEAD + dump_yaml(data, allow_unicode=True, width=90, default_flow_style=None)


def _short(value: float) -> float:
    return float(f"{value:.6g}")


def sentence_of(text: str | bytes, where: str) -> Sentence:
    """The sentence of a file; FlatplankError for whatever is not in the grammar."""
    raw = load_yaml(text, where)
    if not isinstance(raw, Mapping) or raw.get("format") != FORMAT:
        raise FlatplankError(f"is not of format {FORMAT}", where, "name the file of a proposal")
    for key in raw:
        if key not in KEYS:
            raise FlatplankError(
                f"unknown key '{key}'{nearest_hint(str(key), KEYS)}", where, REMEDY
            )
    for key in NEEDED:
        if key not in raw:
            raise FlatplankError(f"'{key}' is missing", where, REMEDY)
    shape = _one_of(shapes(), raw["form"], "form", where)
    coordinate = _coordinate(raw, where)
    numbers = raw.get("numbers") or {}
    wanted = [n.name for n in shape.numbers]
    if not isinstance(numbers, Mapping) or sorted(map(str, numbers)) != sorted(wanted):
        what = f"'numbers' must be those of {shape.name}: {', '.join(wanted) or 'none'}"
        raise FlatplankError(what, where, REMEDY)
    ends = raw.get("interval")
    site = Site(
        _one_of(ACTS_ON, raw["acts_on"], "acts_on", where),
        coordinate,
        _one_of(modulators.BY_NAME, raw.get("when") or "", "when", where),
    )
    return Sentence(
        site, shape, {n: _number(numbers[n], n, where) for n in wanted},
        interval=_pair(ends, "interval", where) if ends is not None else None,
        evidence=tuple(_text(e, "evidence", where) for e in _list(raw.get("evidence"), where)),
        name=checked_name(_text(raw["name"], "name", where), where),
        told_what=_text(raw.get("what") or "", "what", where),
        told_check=_text(raw.get("check") or "", "check", where),
    )  # fmt: skip


def _coordinate(raw: Mapping[str, Any], where: str) -> SiteCoordinate:
    name = _text(raw.get("over") or "", "over", where)
    if not name:
        return SiteCoordinate("", Span(0.0, 1.0, NONE))
    low, high = _pair(raw.get("within"), "within", where)
    unit = _text(raw.get("unit") or "1", "unit", where)
    return SiteCoordinate(name, Span(low, high, PLACE, unit, name == EVENT))


def _one_of(known: Mapping[str, Any], name: object, key: str, where: str) -> Any:
    if not isinstance(name, str) or name not in known:
        hint = nearest_hint(str(name), known)
        raise FlatplankError(f"'{key}' is not in the grammar: '{name}'{hint}", where, REMEDY)
    return known[name]


def _number(raw: object, key: str, where: str) -> float:
    number = isinstance(raw, int | float) and not isinstance(raw, bool)
    if not number or not math.isfinite(raw):  # type: ignore[arg-type]
        raise FlatplankError(f"'{key}' is {raw!r:.60}", where, "write a finite number")
    return float(raw)  # type: ignore[arg-type]


def _pair(raw: object, key: str, where: str) -> tuple[float, float]:
    if not isinstance(raw, list) or len(raw) != 2:
        raise FlatplankError(f"'{key}' is {raw!r:.60}", where, "write [low, high]")
    low, high = (_number(v, key, where) for v in raw)
    if not low < high:
        raise FlatplankError(f"'{key}' is [{low:g}, {high:g}]", where, "write [low, high]")
    return low, high


def _list(raw: object, where: str) -> Iterable[object]:
    if raw is not None and not isinstance(raw, list):
        raise FlatplankError(f"'evidence' is {raw!r:.60}", where, "write a list of texts")
    return raw or ()


def _text(raw: object, key: str, where: str) -> str:
    if not isinstance(raw, str):
        raise FlatplankError(f"'{key}' is {raw!r:.60}", where, "write a text")
    return raw


def checked_name(name: str, where: str = "name") -> str:
    """The name of an effect; FlatplankError when it is no identifier."""
    if not re.fullmatch("[a-z][a-z0-9_]*", name):
        what = f"'{name}' is no identifier"
        raise FlatplankError(what, where, "small letters, digits and _ only")
    return name


def renamed(s: Sentence, name: str) -> Sentence:
    """The sentence with the name of its cause; FlatplankError when that is no identifier."""
    return replace(s, name=checked_name(name))
