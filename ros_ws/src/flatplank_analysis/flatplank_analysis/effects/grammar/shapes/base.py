# SPDX-License-Identifier: Apache-2.0
"""A shape: a closed formula over a coordinate u, its numbers with their ranges, and its words.

The formula is written once, as the text that goes into the effect's file; the search evaluates
the same text. In it u is the coordinate; {low}, {high}, {middle}, {width} describe its observed
range, {begin} is the event or the lower end, and {name} is a number of the shape.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flatplank_analysis.effects.gaps import play_distance

PLACE, ANGLE, LEVEL, SIGNAL = "place", "angle", "level", "signal"


@dataclass(frozen=True)
class Span:
    """The observed range of a coordinate."""

    low: float
    high: float
    kind: str
    """place, angle, level (constant within a run), signal, or none"""
    unit: str = "1"
    event: bool = False
    """True when it is measured from an event, which is at zero"""

    @property
    def width(self) -> float:
        return self.high - self.low

    @property
    def middle(self) -> float:
        return 0.5 * (self.low + self.high)

    @property
    def crosses(self) -> bool:
        """True when it includes both sides of zero."""
        return self.low < -0.1 * self.width and self.high > 0.1 * self.width

    @property
    def begin(self) -> float:
        """Start of a lasting change: the event, or the lower end."""
        return 0.0 if self.event else self.low

    def shares(self, *parts: float) -> np.ndarray:
        """Values at these fractions of the range."""
        return self.low + self.width * np.array(parts)


@dataclass(frozen=True)
class Number:
    """A parameter of a shape that is fitted beside its size."""

    name: str
    unit: str
    """'u' is the unit of the coordinate"""
    grid: Callable[[Span], Sequence[float] | np.ndarray]
    """values that are tried"""
    bounds: Callable[[Span], tuple[float, float]]
    note: str = ""


@dataclass(frozen=True)
class Shape:
    """One form: a sum of `terms`, each multiplied by a size of its own."""

    name: str
    words: str
    """what the effect does, after "that"; behind a semicolon, what its size means"""
    terms: tuple[str, ...]
    kinds: tuple[str, ...]
    numbers: tuple[Number, ...] = ()
    both_signs: bool = False
    """True when it needs a range on both sides of zero"""
    memory: bool = False
    """True when it depends on the course along the run, not only on u"""
    parts: tuple[tuple[str, str], ...] = ()
    """name and formula of parts used in several terms"""
    after_event: bool = False
    """True when it may begin at an event: over a place it is also tried from the step on"""
    where: str = ""
    """where to look, with its numbers by name; empty: they are listed one by one"""

    @property
    def price(self) -> int:
        """Number of parameters that are penalised."""
        return len(self.terms) + len(self.numbers)

    def suits(self, span: Span) -> bool:
        """Whether it is tried over such a coordinate."""
        return span.kind in self.kinds and (span.crosses or not self.both_signs)

    def formulas(self, span: Span, write: Callable[[str], str]) -> list[str]:
        """The terms with the range inserted; `write` formats a number."""
        return self._filled(self.terms, span, write)

    def named_parts(self, span: Span, write: Callable[[str], str]) -> list[tuple[str, str]]:
        """Names and formulas of the parts, in the same way."""
        made = self._filled([formula for _, formula in self.parts], span, write)
        return [(name, formula) for (name, _), formula in zip(self.parts, made, strict=True)]

    def _filled(
        self, formulas: Sequence[str], span: Span, write: Callable[[str], str]
    ) -> list[str]:
        known = {
            "low": literal(span.low), "high": literal(span.high),
            "begin": literal(span.begin),
            "middle": literal(span.middle), "width": literal(span.width),
            "edge": literal(0.01 * span.width),
        }  # fmt: skip
        names = {n.name: write(n.name) for n in self.numbers}
        return [t.format(**known, **names) for t in formulas]

    def values(
        self, span: Span, u: np.ndarray, numbers: Mapping[str, Any], time: np.ndarray | None = None
    ) -> np.ndarray:
        """All terms over u, (terms, ...)."""
        scope = {**NAMES, **numbers, "u": u, "time": time}
        for name, formula in self.named_parts(span, str):
            scope[name] = eval(formula, {"__builtins__": {}}, scope)
        made = [eval(f, {"__builtins__": {}}, scope) for f in self.formulas(span, str)]
        return np.stack([np.broadcast_to(m, np.shape(u)) for m in made])


def literal(value: float) -> str:
    """A number as written in a file, with four digits."""
    return f"({float(f'{value:.4g}')!r})" if value < 0.0 else repr(float(f"{value:.4g}"))


def play(u: np.ndarray, width: np.ndarray | float) -> np.ndarray:
    """Distance to a follower with play of this width behind u, divided by half of the width.

    -1 .. 1; it differs between rising and falling u (play operator).
    """
    half = 0.5 * np.asarray(width)
    u = np.broadcast_to(u, np.broadcast_shapes(np.shape(u), np.shape(half)))
    half = np.broadcast_to(half, (*u.shape[:-1], 1))
    rows = np.array(u, dtype=float).reshape(1, -1, u.shape[-1])
    out = np.empty_like(rows)
    play_distance(rows, half.reshape(1, -1), rows[..., 0].copy(), out)
    return out.reshape(u.shape) / half


def follow(u: np.ndarray, time: np.ndarray, lag: np.ndarray | float) -> np.ndarray:
    """First-order lag [s] of u, starting at the first value of u."""
    lag = np.asarray(lag)
    u = np.broadcast_to(u, np.broadcast_shapes(np.shape(u), np.shape(lag)))
    step = np.diff(time, axis=-1, prepend=time[..., :1])
    keep = np.exp(-step / np.maximum(lag, 1e-9))
    out = np.array(u, dtype=float)
    for n in range(1, u.shape[-1]):
        out[..., n] = u[..., n] + (out[..., n - 1] - u[..., n]) * keep[..., n]
    return out


NAMES: Mapping[str, Any] = {"np": np, "play": play, "follow": follow}
"""names that a formula may use"""
