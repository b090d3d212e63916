# SPDX-License-Identifier: Apache-2.0
"""Text alternatives of charts: what is drawn, for those who do not see it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any


def described(options: Mapping[str, Any]) -> str:
    """Axes of a chart, and each series with its bars or its range; empty without data."""
    xs, ys = _listed(options.get("xAxis")), _listed(options.get("yAxis"))
    told: dict[str, list[float]] = {}
    bars: dict[str, str] = {}
    for s in options.get("series", ()):
        x, y = xs[s.get("xAxisIndex", 0)], ys[s.get("yAxisIndex", 0)]
        names = x.get("data") or y.get("data") or ()
        # of a pair, that which is not on an axis of names; of a cell of a map, its value
        place = 2 if s["type"] == "heatmap" else 0 if "data" in y else 1
        values = [_value(point, place) for point in s["data"]]
        told.setdefault(s["name"], []).extend(v for v in values if v is not None)
        if s["type"] == "bar":
            bars[s["name"]] = ", ".join(f"{n} {v:g}" for n, v in zip(names, values, strict=True))
    parts = [
        f"{name}: {bars.get(name) or f'{min(of):.4g} to {max(of):.4g}'}"
        for name, of in told.items()
        if of
    ]
    named = (axis["name"] for axis in (ys[0], xs[-1]) if axis.get("name"))
    return f"{' over '.join(named)}; {'; '.join(parts)}" if parts else ""


def _listed(axes: Any) -> list[Mapping[str, Any]]:
    return axes if isinstance(axes, list) else [axes or {}]


def _value(point: Any, place: int) -> float | None:
    """The drawn number of a point: a number, a pair, a cell, or a mapping with one."""
    if isinstance(point, Mapping):
        return _value(point["value"], place)
    return point[place] if isinstance(point, Sequence) else point
