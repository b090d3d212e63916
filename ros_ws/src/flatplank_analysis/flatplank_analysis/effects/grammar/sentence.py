# SPDX-License-Identifier: Apache-2.0
"""A sentence of the grammar: an effect as data, in words, and as a class that the engine uses."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from flatplank_analysis.contact_patch.tire_runs import TireRuns
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.grammar.hooks import NONE, Hook
from flatplank_analysis.effects.grammar.modulators import Modulator
from flatplank_analysis.effects.grammar.parameter_words import WORDS
from flatplank_analysis.effects.grammar.shapes.base import Number, Shape, Span
from flatplank_data.wording import quantity

Change = Callable[[Any, TireRuns], np.ndarray]
"""effect with its values, runs -> change (sets, runs, samples) in the unit of a hook"""


@dataclass(frozen=True)
class SiteCoordinate:
    """A coordinate over which a proposed effect may act: its range and values in these runs."""

    name: str
    span: Span
    values: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)), compare=False)
    """(runs, samples); none in a sentence that was read from a file"""
    alias: tuple[str, ...] = ()
    """other names of the same coordinate in these runs"""


@dataclass(frozen=True)
class Site:
    """One hook over one coordinate under one condition."""

    hook: Hook
    coordinate: SiteCoordinate
    modulator: Modulator

    @property
    def key(self) -> tuple[str, str, str]:
        return self.hook.name, self.coordinate.name, self.modulator.name


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
    told_what: str = ""
    told_check: str = ""
    """what a person wrote in place of the words of the grammar; empty: nothing"""

    @property
    def identifier(self) -> str:
        """Identifier of the effect until its cause is known."""
        site = self.site
        words = f"{site.hook.name} {self.shape.name} {site.coordinate.name} {site.modulator.name}"
        return self.name or "proposed_" + "_".join(re.findall("[a-z0-9]+", words.lower()))

    @property
    def what(self) -> str:
        """The effect in a sentence for the engineer."""
        words = self.words()
        return self.told_what or f"{words[0].upper()}{words[1:]}."

    @property
    def check(self) -> str:
        """What to do at the machine: the place, and what would show the effect."""
        return self.told_check or _check_of(self)

    def words(self) -> str:
        """The effect in words, without a capital and a stop."""
        site = self.site
        over = f" over {site.coordinate.name}" if site.coordinate.name else ""
        when, _, meant = site.modulator.words.partition("; ")
        form, _, measured = self.shape.words.partition("; ")
        condition = f", {when}," if when else ""
        notes = "".join(f"; {note}" for note in (measured, meant) if note)
        return f"{site.hook.words}{over}{condition} that {form}{notes}"


def _check_of(s: Sentence) -> str:
    site, seen = s.site, s.site.coordinate.span
    where = ""
    if seen.kind != NONE:
        numbers = {n.name: quantity(s.numbers[n.name], _unit(n, seen)) for n in s.shape.numbers}
        at = s.shape.where.format(**numbers) or ", ".join(f"{n} {v}" for n, v in numbers.items())
        where = f"; {site.coordinate.name}" + (f" {at}" if at else "")
    words = site.modulator.words.partition("; ")[0]
    when = f", {words}" if words else ""
    return f"{site.hook.check}{where}{when}."


def effect_of(s: Sentence) -> type[Effect]:
    """The class of a sentence, as the engine uses it; no text is executed."""
    coordinate, hook, seen = s.site.coordinate, s.site.hook, s.site.coordinate.span
    facts: dict[str, Any] = {
        "identifier": s.identifier, "kind": hook.kind, "what": s.what, "check": s.check,
        "coordinate": coordinate.name or "slip level", "order": hook.order, "sentence": s,
        hook.method: method_of(hook, s.site.modulator, _change_of(s)),
    }  # fmt: skip
    if coordinate.name:
        facts["ranges"] = {coordinate.name: (seen.low, seen.high)}
    if s.interval:
        facts["interval"] = tuple(s.interval)
    title = "".join(w.capitalize() for w in s.identifier.split("_"))
    return dataclasses.make_dataclass(
        title, _fields(s), bases=(hook.base,), frozen=True, namespace=facts
    )


def _change_of(s: Sentence) -> Change:
    """The shape of a sentence as a function of the effect's values and of the runs."""
    name, span = s.site.coordinate.name, s.site.coordinate.span

    def change(effect: Any, data: TireRuns) -> np.ndarray:
        u = data.coordinate(name) if name else np.zeros(data.position.shape)
        numbers = {n.name: getattr(effect, n.name) for n in s.shape.numbers}
        terms = s.shape.terms(span, u, numbers, data.runs.time)
        first, *more = (getattr(effect, n) * t for n, t in zip(s.shape.sizes, terms, strict=True))
        return sum(more, start=first)

    return change


def method_of(hook: Hook, modulator: Modulator, change: Change) -> Callable[[Any, Any], None]:
    """The hook method of an effect that applies a change under a condition."""

    def method(self: Any, on: Any) -> None:
        made = change(self, on.data)
        if modulator.factor is not None:
            made = made * modulator.factor(on.data)
        hook.apply(on, made)

    method.__name__ = hook.method
    return method


def _fields(s: Sentence) -> list[tuple[str, type, Any]]:
    hook, seen = s.site.hook, s.site.coordinate.span
    ends = (-hook.most, hook.most)
    size = {"unit": hook.unit, "screen": hook.screen, "matters": hook.matters}
    out = [_field(name, 0.0, bounds=ends, **size) for name in s.shape.sizes]
    for n in s.shape.numbers:
        low, high = sorted(n.bounds(seen))
        value = float(s.numbers[n.name])
        within = (min(low, value), max(high, value))
        out.append(_field(n.name, value, bounds=within, unit=_unit(n, seen)))
    return out


def _field(name: str, null: float, **declared: Any) -> tuple[str, type, Any]:
    word = WORDS[name]
    said = param(null, title=word.title, symbol=word.symbol, note=word.sentence, **declared)
    return name, float, said


def _unit(number: Number, span: Span) -> str:
    return span.unit if number.unit == "u" else number.unit
