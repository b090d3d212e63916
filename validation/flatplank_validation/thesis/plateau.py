# SPDX-License-Identifier: Apache-2.0
"""The force right after a small step: how long it stays constant (figure 6.7), and how it follows
the load (figure 6.6)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from flatplank_analysis.figures import pieces
from flatplank_analysis.figures.spec import INK, PALETTE, Figure, Panel, Series
from flatplank_analysis.identify.linear import BEFORE
from flatplank_analysis.report.results import CampaignResult, ConditionResult

SMALL_STEPS = (0.01, 0.02)
SHOWN = 0.25
"""least road after the step that the figure shows [m]"""
SHARE = 0.5
"""share of the change of force up to which a constant part is looked for [-]"""


def constant_part(c: ConditionResult) -> tuple[float, float]:
    """First road after the step on which Fx rests: its begin and end [m].

    Constant: within the range that Fx has on the 0.1 m before the step, where only ripple moves
    it. Fx rests where it is constant for longer than twice the road on which the tire itself rises
    by that range: each of two plays makes a rest, and the first one follows the step. Where none
    is that long, the longest constant part; NaN without any.
    """
    x, force = c.since_step, c.measured["fx"]
    good = np.isfinite(force)
    x, force = x[good], force[good]
    before = force[(x >= -BEFORE) & (x < 0.0)]
    whole = c.linear.steady_force.value - before.mean()
    change = (force - before.mean()) / whole
    rest = 2.0 * np.ptp(before) * c.linear.sigma.value / abs(whole)
    reached = np.flatnonzero((x >= 0.0) & (change >= SHARE))
    last = int(reached[0]) if reached.size else len(x)
    first = int(np.searchsorted(x, 0.0))
    best, low = (first, first), first
    for high in range(first + 1, last):
        while np.ptp(force[low : high + 1]) > np.ptp(before):
            low += 1
        if x[best[1]] - x[best[0]] > rest and low > best[1]:
            break
        if high - low > best[1] - best[0]:
            best = (low, high)
    return (float(x[best[0]]), float(x[best[1]])) if best[1] > best[0] else (np.nan, np.nan)


def lost_travel(c: ConditionResult) -> float:
    """Length of the constant part [m]."""
    begin, end = constant_part(c)
    return end - begin


def plateaus(result: CampaignResult) -> Iterator[Figure]:
    """Figure 6.7: Fx around small driving steps, with the ends of the constant part."""
    point = result.nominal()
    found = [pieces.at_slip(point, kappa) for kappa in SMALL_STEPS] if point else []
    lines, told, end = [], [], SHOWN
    for c, color in zip([c for c in found if c is not None], PALETTE, strict=False):
        at = np.array(constant_part(c))
        label = pieces.percent(c.condition.kappa)
        end = np.fmax(end, 1.2 * at[1])
        told.append(f"{1e3 * np.ptp(at):.0f} mm at {label}")
        force = np.interp(at, c.since_step, c.measured["fx"])
        lines.append(Series(label, c.since_step, c.measured["fx"], color=color, end_label=True))
        lines.append(Series("constant part", at, force, "points", INK, legend=len(lines) < 2))
    panels = [pieces.panel(pieces.SINCE_STEP, pieces.FX, lines)]
    ranged = [
        Panel(p.x_label, p.y_label, p.series, (-0.2 * end, end), (0.0,)) for p in panels if p
    ]
    caption = (
        f"The force stays constant for {' and '.join(told)}: within the ripple that it has before "
        "the step. Dotted: the step."
    )
    yield from pieces.figure("plateau", "After a small step", caption, ranged, "6.7")


def fluctuations(result: CampaignResult, bearings: Sequence[float] = ()) -> Iterator[Figure]:
    """Figure 6.6: Fx and Fz of the 1 % step over the road; marks: bearings under the plank [m]."""
    point = result.nominal()
    c = pieces.at_slip(point, 0.01) if point else None
    if c is None or "fz" not in c.measured:
        return
    last = c.position[np.isfinite(c.measured["fx"])][-1]
    reach = (c.step_position, float(last))
    panels = [
        Panel(label, axis, [Series("", c.position, c.measured[name])], reach, bearings)
        for label, axis, name in (("", pieces.FX, "fx"), (pieces.ROAD, pieces.FZ, "fz"))
    ]
    caption = "κ = 1 %. Dotted: where the plank rolls onto or off a bearing that supports it."
    title = "Force and load over the road"
    yield Figure("fluctuations", title, caption, panels, "6.6", stacked=True)
