# SPDX-License-Identifier: Apache-2.0
"""Smallest size of every effect that the posterior would name in these runs."""

from __future__ import annotations

import math

import numpy as np
from scipy.stats import norm

from flatplank_analysis.discovery.screen import ScreenResult, best_per_effect
from flatplank_analysis.inference import priors
from flatplank_analysis.inference.posterior import NAMED
from flatplank_analysis.inference.weigh import Scales

POWER = 0.8
"""share of the campaigns in which an effect of the stated size is named"""


def detectable_sizes(scales: Scales) -> dict[str, tuple[float, str]]:
    """Smallest size that is named in most campaigns (`POWER`) and its unit, by effect; an effect
    that needs more than its range is left out."""
    out = {}
    for item in best_per_effect(scales.ranked(scales.state.whitened.fit)[1]):
        size = detectable_size(scales, item)
        p = item.candidate.effect.main_parameter()
        if size <= max(abs(p.lower - p.null), abs(p.upper - p.null)):
            out[item.identifier] = (size, p.unit)
    return out


def detectable_size(scales: Scales, item: ScreenResult) -> float:
    """Size whose evidence, of its largest parameter alone, reaches `NAMED` against its price.

    The drop of chi2 of a size is noncentral; the size must exceed the one of least consequence,
    too, as surely as its error allows.
    """
    effect = item.candidate.effect
    p = effect.main_parameter()
    row = next((i for i, q in enumerate(effect.linear()) if q.name == p.name), 0)
    info = float(item.information[row, row]) / max(scales.dispersion, 1.0)
    if info <= 0.0:
        return math.inf
    error = abs(p.screen) / math.sqrt(info)
    price = -priors.of_set(1, scales.library) + math.log(effect.scanned(scales.state.runs))
    price -= priors.of_value(effect, p, p.null) + 0.5 * math.log(2.0 * math.pi / info)
    # three probabilities make one: of the set, of consequence, and of no unknown fault
    each = NAMED ** (1.0 / 3.0)
    wanted = max(math.log(each / (1.0 - each)) + price, 0.0)
    freedom = scales.freedom
    drop = freedom * math.expm1(2.0 * wanted / freedom)
    above = float(norm.ppf(POWER))
    sure = p.matters + (float(norm.ppf(each)) + above) * error
    return max((math.sqrt(drop) + above) * error, sure) if np.isfinite(drop) else math.inf
