# SPDX-License-Identifier: Apache-2.0
"""Sites of the search: hook x coordinate x modulator, as far as the runs can show them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from flatplank_analysis.contact_patch.tire_runs import TireRuns
from flatplank_analysis.discovery.runs import Coordinate
from flatplank_analysis.effects.grammar.hooks import HOOKS, NONE, Hook
from flatplank_analysis.effects.grammar.modulators import BY_NAME
from flatplank_analysis.effects.grammar.sentence import Site, SiteCoordinate
from flatplank_analysis.effects.grammar.shapes.base import ANGLE, LEVEL, PLACE, SIGNAL, Span

SAME = 0.999
"""likeness of two courses above which they count as the same"""
WITHIN = 0.1
"""share of a coordinate's spread within runs below which it counts as set per run"""
LAWS = ("slip level", "slip travel", "alpha", "fx", "kappa", "fz", "rate")
"""coordinates of the force law itself: deviations over them belong to the law"""
EVENT = "distance since the step"
ORDER, MIXED = "run order", 0.25
"""least share of the spread of the run order that lies within conditions; below it the conditions
were made one after the other, and their differences would look like a change with time"""


def varying_coordinates(data: TireRuns) -> list[SiteCoordinate]:
    """Coordinates that vary, each once, without those of the force law."""
    out = [SiteCoordinate("", Span(0.0, 1.0, NONE), np.zeros(data.position.shape))]
    for name, c in data.coordinates.items():
        values = np.asarray(c.values, dtype=float)
        if name in LAWS or not np.isfinite(values).all() or np.ptp(values) <= 1e-9:
            continue
        if name == ORDER and _mixed(data, values) < MIXED:
            continue
        coordinate = SiteCoordinate(name, _span(name, c, values), values)
        twin = next((i for i, o in enumerate(out) if _same(o, coordinate)), None)
        if twin is None:
            out.append(coordinate)
        elif name == "plank position":
            # the plank position gives the name, the distance since the step is an alias
            out[twin] = replace(coordinate, alias=(out[twin].name, *out[twin].alias))
        else:
            out[twin] = replace(out[twin], alias=(*out[twin].alias, name))
    return out


def _mixed(data: TireRuns, values: np.ndarray) -> float:
    """Share of the spread of a setting within conditions."""
    level = values.mean(axis=1)
    within = sum(float(np.sum((level[g] - level[g].mean()) ** 2)) for g in data.runs.groups)
    return within / max(float(np.sum((level - level.mean()) ** 2)), 1e-300)


def _span(name: str, c: Coordinate, values: np.ndarray) -> Span:
    digits = 4 - int(np.floor(np.log10(np.ptp(values))))  # of the range, which stands in a file
    low, high = round(float(values.min()), digits), round(float(values.max()), digits)
    within = float(np.mean(values.std(axis=1)))
    if c.period:
        return Span(0.0, c.period, ANGLE, c.unit)
    if within < WITHIN * float(values.std()):
        return Span(low, high, LEVEL, c.unit)
    even = float(np.mean(np.abs(np.corrcoef(values, np.arange(values.shape[1]))[-1, :-1])))
    monotone = bool((np.diff(values, axis=1) >= -1e-9).all()) and even > 0.8
    return Span(low, high, PLACE if monotone else SIGNAL, c.unit, name == EVENT)


def _same(one: SiteCoordinate, other: SiteCoordinate) -> bool:
    if not one.name or one.span.kind != other.span.kind or one.span.kind == ANGLE:
        return False
    a, b = one.values - one.values.mean(), other.values - other.values.mean()
    return float(np.sum(a * b)) > SAME * float(np.sqrt(np.sum(a**2) * np.sum(b**2)))


def event_coordinate(data: TireRuns) -> SiteCoordinate:
    """Distance since the step, even where another coordinate is the same."""
    c = data.runs.coordinates[EVENT]
    return SiteCoordinate(EVENT, _span(EVENT, c, c.values), c.values)


def sites_of(
    data: TireRuns, coordinates: Sequence[SiteCoordinate], hooks: Sequence[Hook] = HOOKS
) -> list[Site]:
    """All sites of these hooks that these runs can show."""
    channels = data.runs.channels
    return [
        Site(hook, coordinate, BY_NAME[name])
        for hook in hooks
        if hook.needs is None or hook.needs in channels
        for coordinate in coordinates
        if coordinate.span.kind in hook.kinds and coordinate.name != hook.needs
        for name in _modulators(hook, coordinate, data)
    ]


def _modulators(hook: Hook, coordinate: SiteCoordinate, data: TireRuns) -> Iterator[str]:
    """Modulators for a hook that vary between runs and differ from each other."""
    seen: list[np.ndarray] = []
    for name in hook.modulators:
        if name == coordinate.name:
            continue  # the base takes a constant, and load over load is a power
        m = BY_NAME[name].values(data).ravel()
        size = float(np.linalg.norm(m))
        alike = any(abs(float(m @ o)) > SAME * size * float(np.linalg.norm(o)) for o in seen)
        if size > 0.0 and not alike:
            seen.append(m)
            yield name
