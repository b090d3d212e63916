# SPDX-License-Identifier: Apache-2.0
"""A shape: a closed formula over a coordinate u, its numbers with their ranges, and its words."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

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
    def edge(self) -> float:
        """Width of a step that stays smooth enough for derivatives."""
        return 0.01 * self.width

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


Terms: TypeAlias = "np.ndarray | tuple[np.ndarray, ...]"
"""one term of a shape, or several"""


@dataclass(frozen=True)
class Shape:
    """One form: a sum of terms, each multiplied by a size of its own."""

    name: str
    words: str
    """what the effect does, after "that"; behind a semicolon, what its size means"""
    formula: Callable[..., Terms]
    """the terms, given u, its `Span`, and the numbers in their order; behind them the time [s]
    where the shape has `memory`"""
    kinds: tuple[str, ...]
    numbers: tuple[Number, ...] = ()
    sizes: tuple[str, ...] = ("amount",)
    """names of the sizes of the terms"""
    both_signs: bool = False
    """True when it needs a range on both sides of zero"""
    memory: bool = False
    """True when it depends on the course along the run, not only on u"""
    after_event: bool = False
    """True when it may begin at an event: over a place it is also tried from the step on"""
    where: str = ""
    """where to look, with its numbers by name; empty: they are listed one by one"""

    @property
    def price(self) -> int:
        """Number of parameters that are penalised."""
        return len(self.sizes) + len(self.numbers)

    def suits(self, span: Span) -> bool:
        """Whether it is tried over such a coordinate."""
        return span.kind in self.kinds and (span.crosses or not self.both_signs)

    def terms(
        self, span: Span, u: np.ndarray, numbers: Mapping[str, Any], time: np.ndarray | None = None
    ) -> tuple[np.ndarray, ...]:
        """Its terms over u; numbers and time broadcast against u."""
        own = [numbers[n.name] for n in self.numbers]
        made = self.formula(u, span, *own, *([time] if self.memory else []))
        return made if isinstance(made, tuple) else (made,)

    def values(
        self, span: Span, u: np.ndarray, numbers: Mapping[str, Any], time: np.ndarray | None = None
    ) -> np.ndarray:
        """Its terms over u, (terms, ...)."""
        made = self.terms(span, u, numbers, time)
        return np.stack([np.broadcast_to(m, np.shape(u)) for m in made])


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
