# SPDX-License-Identifier: Apache-2.0
"""Free curves over a coordinate: they show a shape and set the test level; none is proposed.

A curve is a sum of hat functions; the model's responses to them give its response to any shape.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

from flatplank_analysis.contact_patch.tire_runs import TireRuns
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.grammar.sentence import Site, method_of
from flatplank_analysis.effects.grammar.shapes.base import ANGLE, LEVEL, PLACE, Span

COARSE = {PLACE: 14, LEVEL: 5}
FINE = {PLACE: 72, LEVEL: 24}
"""number of knots of a free curve by kind of coordinate: for the ranking, and for the forms"""
OTHER_COARSE, OTHER_FINE = 6, 24
"""the same numbers for all other kinds"""
ORDERS = 4
"""highest order per turn in a curve over an angle"""


def knots_of(values: np.ndarray, span: Span, fine: bool) -> np.ndarray:
    """Knots of the hats: evenly over a place, at the values of a setting, otherwise half-way
    between an even grid and the quantiles of the values."""
    count = (FINE if fine else COARSE).get(span.kind, OTHER_FINE if fine else OTHER_COARSE)
    if span.kind == PLACE:
        return np.linspace(span.low, span.high, count)
    seen = np.unique(np.round(values.mean(axis=1), 9)) if span.kind == LEVEL else values.ravel()
    if span.kind == LEVEL and len(seen) <= count:
        return seen
    even = np.linspace(span.low, span.high, count)
    spread = np.quantile(seen, np.linspace(0.0, 1.0, count))
    return np.unique(np.round(0.5 * (even + spread), 12))


def hat_functions(values: np.ndarray, knots: np.ndarray) -> np.ndarray:
    """Hat functions (knots, runs, samples): one at their own knot, zero at the others."""
    eye = np.eye(len(knots))
    return np.stack([np.interp(values, knots, row) for row in eye])


def harmonics(values: np.ndarray) -> np.ndarray:
    """cos and sin of the orders over an angle (2 orders, runs, samples)."""
    orders = range(1, ORDERS + 1)
    return np.stack([f(n * values) for n in orders for f in (np.cos, np.sin)])


def basis_of(site: Site, fine: bool, u: np.ndarray | None = None) -> np.ndarray:
    """Basis functions of a site's curve (k, runs, samples), or at other values u."""
    coordinate = site.coordinate
    u = coordinate.values if u is None else u
    if not coordinate.name:
        return np.ones((1, *u.shape))
    if coordinate.span.kind == ANGLE:
        return harmonics(u)
    return hat_functions(u, knots_of(coordinate.values, coordinate.span, fine))


def effect_of_curve(site: Site, basis: np.ndarray) -> type[Effect]:
    """An effect at a site, for searches; its sizes are the coefficients of the basis functions."""
    hook = site.hook
    flat = basis.reshape(len(basis), -1)

    def number() -> Any:
        ends = (-np.inf, np.inf)
        return param(0.0, unit=hook.unit, bounds=ends, screen=hook.screen, matters=1e-30)

    names = [f"c{i}" for i in range(len(basis))]

    def change(effect: Any, _data: TireRuns) -> np.ndarray:
        sizes = np.stack([np.ravel(getattr(effect, n)) for n in names], axis=-1)
        return (sizes @ flat).reshape(len(sizes), *basis.shape[1:])

    facts: Mapping[str, Any] = {
        "identifier": "curve", "coordinate": site.coordinate.name, "kind": hook.kind,
        "order": hook.order, hook.method: method_of(hook, site.modulator, change),
    }  # fmt: skip
    fields = [(n, float, number()) for n in names]
    return dataclasses.make_dataclass(
        "Curve", fields, bases=(hook.base,), frozen=True, namespace=dict(facts)
    )
