# SPDX-License-Identifier: Apache-2.0
"""A proposal as an effect file, in words for the engineer who will check the machine."""

from __future__ import annotations

import json
import re
import sys
import textwrap
import types
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from zlib import crc32

from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.effects.registry import effects_in
from flatplank_analysis.proposal.hooks import NONE
from flatplank_analysis.proposal.proposed import Proposed
from flatplank_analysis.proposal.shapes.base import Shape, literal
from flatplank_analysis.proposal.sites import Site
from flatplank_data.errors import FlatplankError
from flatplank_data.wording import quantity, span

_CLASSES = {"signal": "Signal", "motion": "Motion", "tire": "Tire"}
_HELPERS = ("follow", "play", "shifted")
WIDTH = 95


@dataclass(frozen=True)
class Sentence:
    """One sentence of the grammar: an effect as a shape at a site, with its numbers."""

    site: Site
    shape: Shape
    numbers: Mapping[str, float]
    sizes: Sequence[float] = ()
    interval: tuple[float, float] | None = None
    """90 % interval of the size"""
    evidence: Sequence[str] = field(default_factory=tuple)
    """statements about the data"""
    name: str = ""

    @property
    def identifier(self) -> str:
        """Identifier of the effect until its cause is known."""
        site = self.site
        words = f"{site.hook.name} {self.shape.name} {site.coordinate.name} {site.modulator.name}"
        return self.name or "proposed_" + "_".join(re.findall("[a-z0-9]+", words.lower()))

    @property
    def size_names(self) -> list[str]:
        names = ["cos", "sin", "second_cos", "second_sin"]
        return ["amount"] if len(self.shape.terms) == 1 else names[: len(self.shape.terms)]

    def words(self) -> str:
        site = self.site
        over = f" over {site.coordinate.name}" if site.coordinate.name else ""
        when, _, meant = site.modulator.words.partition("; ")
        form, _, measured = self.shape.words.partition("; ")
        condition = f", {when}," if when else ""
        notes = "".join(f"; {note}" for note in (measured, meant) if note)
        return f"{site.hook.words}{over}{condition} that {form}{notes}"


def text_of(s: Sentence) -> str:
    """The effect file of a sentence."""
    site, hook = s.site, s.site.hook
    body = _body(s)
    seen = site.coordinate.span
    over = _quoted(site.coordinate.name)
    ranges = f"{{{over}: ({literal(seen.low)}, {literal(seen.high)})}}"
    lines = [
        *_head(s, body), "", "",
        "@dataclass(frozen=True)", f"class {class_of(s.identifier)}(Proposed):",
        f'    identifier = "{s.identifier}"',
        *([f'    kind = "{hook.kind}"'] if hook.kind != Proposed.kind else []),
        f"    coordinate = {over if site.coordinate.name else _quoted('slip level')}",
        *_text("what", f"{s.words()[0].upper()}{s.words()[1:]}."),
        *_text("check", check_of(s)),
        *([f"    ranges = {ranges}"] if site.coordinate.name else []),
        *([f"    order = {hook.order}"] if hook.order else []),
        *_interval(s),
        "", *_fields(s), "",
        f"    def {hook.method}(self, {hook.method}: {_CLASSES[hook.method]}) -> None:",
        *(f"        {line}" for line in body),
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def _head(s: Sentence, body: Sequence[str]) -> list[str]:
    """Docstring and imports."""
    origin = "Proposed by `flatplank propose`, not confirmed; give it the name of its cause. "
    names = ["Proposed", _CLASSES[s.site.hook.method], "param"]
    names += [h for h in _HELPERS if any(f"{h}(" in line for line in body)]
    return [
        *textwrap.wrap('"""' + origin + _plain(" ".join(s.evidence)) + '"""', 99), "",
        "from dataclasses import dataclass", "",
        *(["import numpy as np", ""] if any("np." in line for line in body) else []),
        f"from flatplank_analysis.proposal.proposed import {', '.join(sorted(names))}",
    ]  # fmt: skip


def _body(s: Sentence) -> list[str]:
    site = s.site

    write = "self.{}".format
    formulas = s.shape.formulas(site.coordinate.span, write)
    where = f"data.coordinate({_quoted(site.coordinate.name)})"
    lines = [f"data = {site.hook.method}.data"]
    lines += [f"u = {where if site.coordinate.name else 'np.zeros(data.position.shape)'}"]
    lines += ["time = data.runs.time"] if any("time" in f for f in formulas) else []
    parts = s.shape.named_parts(site.coordinate.span, write)
    lines += [f"{name} = {formula}" for name, formula in parts]
    # a sum is put in brackets
    factors = [f"({f})" if f[0].isdigit() else f for f in formulas]
    lines += _summed([f"self.{n} * {f}" for n, f in zip(s.size_names, factors, strict=True)])
    if site.modulator.formula:
        lines.append(f"change = change * ({site.modulator.formula})")
    return [*lines, *site.hook.line.split("\n")]


def _summed(terms: Sequence[str]) -> list[str]:
    """Code lines that sum the terms as `change`, wrapped to the line length."""
    lines = [f"change = {terms[0]}"]
    for term in terms[1:]:
        longer = f"{lines[-1]} + {term}"
        if len(longer) <= 91:
            lines[-1] = longer
        else:
            lines.append(f"change = change + {term}")
    return lines


def _plain(text: str) -> str:
    """A text that is safe in a docstring."""
    return text.replace("\\", "/").replace('"', "'")


def _quoted(text: str) -> str:
    """A text as a string literal, whatever a column is called."""
    return json.dumps(text, ensure_ascii=False)


def _text(name: str, text: str) -> list[str]:
    one = f"    {name} = {_quoted(text)}"
    if len(one) <= 99:
        return [one]
    head = f"    {name} = ("
    rows = textwrap.wrap(text, WIDTH - len(head))
    rows = [_quoted(r + (" " if r is not rows[-1] else "")) for r in rows]
    return [
        head + rows[0],
        *(" " * len(head) + r for r in rows[1:-1]),
        " " * len(head) + rows[-1] + ")",
    ]


def _fields(s: Sentence) -> list[str]:
    hook, seen = s.site.hook, s.site.coordinate.span
    out = [
        f'    {name}: float = param(0.0, unit="{hook.unit}", '
        f"bounds=({-hook.most}, {hook.most}), screen={hook.screen}, matters={hook.matters})"
        for name in s.size_names
    ]
    for n in s.shape.numbers:
        low, high = sorted(n.bounds(seen))
        unit = seen.unit if n.unit == "u" else n.unit
        value = min(max(float(s.numbers[n.name]), low), high)
        low, value, high = (float(f"{v:.6g}") for v in (low, value, high))
        note = f', note="{n.note}"' if n.note else ""
        out.append(
            f'    {n.name}: float = param({value:.6g}, unit="{unit}", '
            f"bounds=({min(low, value):.6g}, {max(high, value):.6g}){note})"
        )
    return [part for line in out for part in _param(line)]


def _param(line: str) -> list[str]:
    """A field, on two lines where needed: the note on the second."""
    if len(line) <= 99:
        return [line]
    head, _, note = line.rpartition(", note=")
    return [f"{head},", f"{' ' * (head.index('(') + 1)}note={note}"] if head else [line]


def _interval(s: Sentence) -> list[str]:
    if not s.interval:
        return []
    interval = span(*s.interval, s.site.hook.unit)
    return [f"    interval = ({s.interval[0]:.6g}, {s.interval[1]:.6g})  # size, 90 %: {interval}"]


def check_of(s: Sentence) -> str:
    """What to do at the machine: the place, and what would show the effect."""
    site, seen = s.site, s.site.coordinate.span
    where = ""
    if seen.kind != NONE:
        numbers = {
            n.name: quantity(s.numbers[n.name], seen.unit if n.unit == "u" else n.unit)
            for n in s.shape.numbers
        }
        at = s.shape.where.format(**numbers) or ", ".join(f"{n} {v}" for n, v in numbers.items())
        where = f"; {site.coordinate.name}" + (f" {at}" if at else "")
    words = site.modulator.words.partition("; ")[0]
    when = f", {words}" if words else ""
    return f"{site.hook.check}{where}{when}."


def renamed(text: str, name: str) -> str:
    """The file of a proposal with another identifier and class name.

    FlatplankError when the name is no identifier.
    """
    if not re.fullmatch("[a-z][a-z0-9_]*", name):
        what = f"'{name}' is no identifier"
        raise FlatplankError(what, "name", "small letters, digits and _ only")
    text = re.sub('(?m)^    identifier = ".*"$', f'    identifier = "{name}"', text, count=1)
    return re.sub(r"(?m)^class \w+\(", f"class {class_of(name)}(", text, count=1)


def class_of(identifier: str) -> str:
    return "".join(w.capitalize() for w in identifier.split("_"))


def effect_of(text: str) -> type[Effect]:
    name = f"flatplank_proposed_{crc32(text.encode()):08x}"
    module = types.ModuleType(name)
    sys.modules[name] = module
    exec(compile(text, f"<{name}>", "exec"), module.__dict__)
    return effects_in(module)[0]
