# SPDX-License-Identifier: Apache-2.0
"""Priors: how many effects a machine has, and how large they are."""

from __future__ import annotations

import math

import numpy as np

from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.fit import Term, scale_of
from flatplank_analysis.discovery.parameters import Parameter

EXPECTED = 1.0
"""expected number of effects among all of the library"""
USUAL = 3.0
"""scale of the prior of a size, in sizes of least consequence"""
FREEDOM = 2.0
"""degrees of freedom of that prior (Student): a large fault is rare, and not absurd"""


def of_set(count: int, library: float) -> float:
    """Logarithm of the prior odds of `count` given effects of a library against none."""
    share = min(EXPECTED / max(library, 1.0), 0.5)
    return count * math.log(share / (1.0 - share))


def scale_of_size(effect: type[Effect], p: Parameter) -> float:
    """Scale of the prior of one linear parameter, in its unit."""
    main = effect.main_parameter()
    if p.matters:
        return USUAL * p.matters
    share = abs(p.screen / main.screen) if main.screen else 1.0
    return USUAL * main.matters * share


def student(value: float, scale: float) -> float:
    """Logarithm of the density of a size (Student, `FREEDOM` = 2 in closed form)."""
    return -1.5 * math.log1p(0.5 * (value / scale) ** 2) - math.log(2.0 * math.sqrt(2.0) * scale)


def curvature(value: float, scale: float) -> float:
    """Inverse variance of the Gaussian that bounds the prior of a size at a value from below."""
    return (FREEDOM + 1.0) / (FREEDOM * scale**2 + value**2)


def is_one_sided(p: Parameter) -> bool:
    """True for a size that has one sign."""
    return p.null in (p.lower, p.upper)


def of_value(effect: type[Effect], p: Parameter, value: float) -> float:
    """Logarithm of the prior density of a fitted parameter, in units of the fit (`scale_of`)."""
    unit = math.log(scale_of(p))
    if p.screen:
        sides = math.log(2.0) if is_one_sided(p) else 0.0
        return student(value - p.null, scale_of_size(effect, p)) + sides + unit
    width = p.upper - p.lower
    return unit - math.log(width) if np.isfinite(width) else 0.0


def of_term(term: Term, scanned: int) -> float:
    """Logarithm of the prior density of the parameters of an effect, in units of the fit.

    A place or a period is a parameter like any other. Where a setting is held, each of the
    `scanned` ones has the same prior probability.
    """
    named = term.named()
    fitted = [p for p in term.effect.parameters() if p.name not in term.fixed]
    density = sum(of_value(term.effect, p, named[p.name]) for p in fitted)
    return density - (math.log(scanned) if term.fixed else 0.0)
