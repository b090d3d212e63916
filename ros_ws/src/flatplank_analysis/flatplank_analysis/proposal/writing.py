# SPDX-License-Identifier: Apache-2.0
"""A proposal as an effect file, in the words of the person who will check the machine."""

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
from flatplank_analysis.errors import FlatplankError
from flatplank_analysis.proposal.hooks import NONE
from flatplank_analysis.proposal.shapes.base import PLACE, Shape, literal
from flatplank_analysis.proposal.sites import Site
from flatplank_analysis.wording import plain

_CLASSES = {"signal": "Signal", "motion": "Motion", "tire": "Tire"}
_HELPERS = {
    "play(": "from flatplank_analysis.proposal.shapes.operators import play",
    "follow(": "from flatplank_analysis.proposal.shapes.operators import follow",
}
WIDTH = 92


@dataclass(frozen=True)
class Sentence:
    """One sentence of the grammar: a shape at a site, with its numbers."""

    site: Site
    shape: Shape
    numbers: Mapping[str, float]
    sizes: Sequence[float] = ()
    interval: tuple[float, float] | None = None
    """90 % of the size"""
    told: Sequence[str] = field(default_factory=tuple)
    """what the data say of it, a sentence each"""
    name: str = ""

    @property
    def identifier(self) -> str:
        """The name it gets until somebody finds the cause."""
        site = self.site
        words = f"{site.hook.name} {self.shape.name} {site.place.name} {site.modulator.name}"
        return self.name or "proposed_" + "_".join(re.findall("[a-z0-9]+", words.lower()))

    @property
    def size_names(self) -> list[str]:
        """Names of the sizes."""
        names = ["cos", "sin", "second_cos", "second_sin"]
        return ["amount"] if len(self.shape.terms) == 1 else names[: len(self.shape.terms)]

    def words(self) -> str:
        """The sentence, for people."""
        site = self.site
        over = f" over {site.place.name}" if site.place.name else ""
        when, _, meant = site.modulator.words.partition("; ")
        form, _, measured = self.shape.words.partition("; ")
        aside = f", {when}," if when else ""
        notes = "".join(f"; {note}" for note in (measured, meant) if note)
        return f"{site.hook.words}{over}{aside} that {form}{notes}"


def text_of(s: Sentence) -> str:
    """The effect file of a sentence."""
    site, hook = s.site, s.site.hook
    body = _body(s)
    name = class_of(s.identifier)
    head = [
        "Proposed by `flatplank propose`, not confirmed; give it the name of its cause.", *s.told,
    ]  # fmt: skip
    imports = [
        "from flatplank_analysis.discovery.parameters import param",
        f"from flatplank_analysis.effects.base import {_CLASSES[hook.method]}, TireEffect",
        *(line for call, line in _HELPERS.items() if any(call in b for b in body)),
    ]
    span = site.place.span
    over = _quoted(site.place.name)
    title = _quoted(f"Proposed: {hook.words} over {site.place.name or 'all runs'}")
    ranges = f"{{{over}: ({literal(span.low)}, {literal(span.high)})}}"
    lines = [
        '"""' + "\n".join(textwrap.fill(_plain(h), 96) for h in head) + '"""', "",
        "from dataclasses import dataclass", "", "import numpy as np", "",
        *imports, "", "",
        "@dataclass(frozen=True)", f"class {name}(TireEffect):",
        f'    identifier = "{s.identifier}"',
        f"    title = {title}",
        f'    kind = "{hook.kind}"',
        f"    coordinate = {over if site.place.name else _quoted('slip level')}",
        '    source = "flatplank propose"',
        *_text("what", f"{s.words()[0].upper()}{s.words()[1:]}."),
        *_text("check", check_of(s)),
        f'    removes = "{hook.removes}"',
        *([f"    ranges = {ranges}"] if site.place.name else []),
        *([f"    order = {hook.order}"] if hook.order else []),
        *(["    local = True"] if s.shape.name == "bump" and span.kind == PLACE else []),
        *([f"    interval = ({s.interval[0]:.6g}, {s.interval[1]:.6g})"] if s.interval else []),
        "", *_fields(s), "",
        *_size(s),
        f"    def {hook.method}(self, {hook.method}: {_CLASSES[hook.method]}) -> None:",
        *(f"        {line}" for line in body),
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def _body(s: Sentence) -> list[str]:
    site = s.site
    formulas = s.shape.formulas(site.place.span, lambda n: f"self.{n}")
    lines = [f"data = {site.hook.method}.data"]
    lines += (
        [f"u = data.coordinate({_quoted(site.place.name)})"]
        if site.place.name
        else ["u = np.zeros(data.position.shape)"]
    )
    lines += ["time = data.runs.time"] if any("time" in f for f in formulas) else []
    for i, (name, formula) in enumerate(zip(s.size_names, formulas, strict=True)):
        before = "change + " if i else ""
        lines.append(f"change = {before}self.{name} * ({formula})")
    if site.modulator.formula:
        lines.append(f"change = change * ({site.modulator.formula})")
    return [part for line in [*lines, site.hook.line] for part in _wrapped(line)]


def _wrapped(line: str) -> list[str]:
    """A long assignment on two lines, in brackets; a name in quotes is never broken."""
    if len(line) + 8 <= 99 or '"' in line:
        return [line]
    goal, _, value = line.partition(" = ")
    return [f"{goal} = (", *(f"    {p}" for p in textwrap.wrap(value, 84)), ")"]


def _plain(text: str) -> str:
    """A text that may stand in a docstring."""
    return text.replace("\\", "/").replace('"', "'")


def _quoted(text: str) -> str:
    """A text as it stands in a file, whatever a column is called."""
    return json.dumps(text, ensure_ascii=False)


def _text(name: str, text: str) -> list[str]:
    one = f"    {name} = {_quoted(text)}"
    if len(one) <= 99:
        return [one]
    rows = textwrap.wrap(text, WIDTH - 4)
    rows = [r + (" " if r is not rows[-1] else "") for r in rows]
    return [f"    {name} = (", *(f"        {_quoted(r)}" for r in rows), "    )"]


def _fields(s: Sentence) -> list[str]:
    hook, span = s.site.hook, s.site.place.span
    out = []
    for i, name in enumerate(s.size_names):
        note = ""
        if s.interval and not i:
            low, high = (plain(v, 3) for v in s.interval)
            note = f', note="found {low} to {high} (90 %)"'
        out.append(
            f'    {name}: float = param(0.0, unit="{hook.unit}", '
            f"bounds=({-hook.most}, {hook.most}), "
            f"screen={hook.screen}, matters={hook.matters}{note})"
        )
    for n in s.shape.numbers:
        low, high = sorted(n.bounds(span))
        unit = span.unit if n.unit == "u" else n.unit
        value = min(max(float(s.numbers[n.name]), low), high)
        note = f', note="{n.note}"' if n.note else ""
        out.append(
            f'    {n.name}: float = param({value:.6g}, unit="{unit}", '
            f"bounds=({_down(low, value):.6g}, {_up(high, value):.6g}){note})"
        )
    return [part for line in out for part in _param(line)]


def _param(line: str) -> list[str]:
    """A field on two lines where one is not enough: the note on the second."""
    if len(line) <= 99:
        return [line]
    head, _, note = line.rpartition(", note=")
    return [f"{head},", f"{' ' * (head.index('(') + 1)}note={note}"] if head else [line]


def _down(low: float, value: float) -> float:
    return min(float(f"{low:.6g}"), float(f"{value:.6g}"))


def _up(high: float, value: float) -> float:
    return max(float(f"{high:.6g}"), float(f"{value:.6g}"))


def _size(s: Sentence) -> list[str]:
    if len(s.shape.terms) == 1:
        return []
    return [
        "    @classmethod", "    def size(cls, values):",
        '        return float(np.hypot(values["cos"], values["sin"]))', "",
    ]  # fmt: skip


def check_of(s: Sentence) -> str:
    """What to do at the machine: where, and what would show it."""
    site, span = s.site, s.site.place.span
    where = ""
    if span.kind != NONE:
        at = [f"{n.name} {_amount(s.numbers[n.name], n.unit, span)}" for n in s.shape.numbers]
        where = f" over {site.place.name}" + (f" ({', '.join(at)})" if at else "")
    words = site.modulator.words.partition("; ")[0]
    when = f", {words}" if words else ""
    return f"{site.hook.check}{where}{when}."


def _amount(value: float, unit: str, span) -> str:
    unit = span.unit if unit == "u" else unit
    return plain(value, 3) + ("" if unit == "1" else f" {unit}")


def renamed(text: str, name: str) -> str:
    """The file of a proposal with another identifier, and a class named after it."""
    if not re.fullmatch("[a-z][a-z0-9_]*", name):
        raise FlatplankError(
            f"'{name}' is no identifier", "name", "small letters, digits and _ only"
        )
    text = re.sub('(?m)^    identifier = ".*"$', f'    identifier = "{name}"', text, count=1)
    return re.sub(r"(?m)^class \w+\(", f"class {class_of(name)}(", text, count=1)


def class_of(identifier: str) -> str:
    """Name of the class of an effect."""
    return "".join(w.capitalize() for w in identifier.split("_"))


def effect_of(text: str) -> type[Effect]:
    """The effect of a file's text."""
    name = f"flatplank_proposed_{crc32(text.encode()):08x}"
    module = types.ModuleType(name)
    sys.modules[name] = module
    exec(compile(text, f"<{name}>", "exec"), module.__dict__)
    return effects_in(module)[0]
