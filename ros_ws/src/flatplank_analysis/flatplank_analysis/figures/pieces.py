# SPDX-License-Identifier: Apache-2.0
"""Parts that several figures share."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from flatplank_analysis.figures.spec import Figure, Panel, Series
from flatplank_analysis.figures.style import slip_colors
from flatplank_analysis.models.magic_formula import (
    Coefficients,
    OperatingPoint,
    operating_point,
)
from flatplank_analysis.report.results import CampaignResult, ConditionResult, PointResult
from flatplank_data.condition import Condition

DISPLACEMENT = "road displacement [m]"
SINCE_STEP = "road displacement since the step [m]"
FX = "longitudinal force Fx [N]"
FY = "lateral force Fy [N]"
SPEED = 0.03
"""of the road, where a model wants one [m/s]"""

#: what is varied: field of the operating point -> (symbol, unit)
FACTORS = {
    "fz": ("Fz", "N"),
    "pressure": ("p", "bar"),
    "alpha_deg": ("α", "°"),
    "gamma_deg": ("γ", "°"),
}


def percent(kappa: float) -> str:
    """Slip as it is written beside a line."""
    return f"{100 * kappa:+.3g} %".replace("+0 %", "0 %").replace("-", "−")


def level(name: str, value: float) -> str:
    """A condition as it is written beside a line."""
    symbol, unit = FACTORS[name]
    gap = "" if unit == "°" else " "
    return f"{symbol} = {value:g}{gap}{unit}"


def slips(point: PointResult) -> list[ConditionResult]:
    """Conditions of a point in order of slip."""
    return sorted(point.conditions, key=lambda c: c.condition.kappa)


def colors(conditions: Sequence[ConditionResult]) -> dict[float, str]:
    """Colour of each slip level."""
    return slip_colors([c.condition.kappa for c in conditions])


def force_lines(
    conditions: Sequence[ConditionResult], name: str = "fx", since_step: bool = False
) -> list[Series]:
    """One line per slip level, labelled at its end."""
    tone = colors(conditions)
    return [
        Series(
            percent(c.condition.kappa),
            c.since_step if since_step else c.position,
            c.measured[name],
            color=tone[c.condition.kappa],
            end_label=True,
        )
        for c in conditions
        if name in c.measured
    ]


def varied(result: CampaignResult, factor: str) -> list[PointResult]:
    """Points that differ from the nominal one in one factor only, in its order."""
    nominal = result.nominal()
    if nominal is None:
        return []
    found = {
        getattr(p.point, factor): p
        for p in result.points
        if p.conditions and _same_but(p.point, nominal.point, factor)
    }
    return [found[key] for key in sorted(found)] if len(found) > 1 else []


def _same_but(one: Condition, other: Condition, factor: str) -> bool:
    names = ("tire", "fz", "pressure", "alpha_deg", "gamma_deg")
    return all(getattr(one, n) == getattr(other, n) for n in names if n != factor)


def at_slip(point: PointResult, kappa: float) -> ConditionResult | None:
    """The condition of a point with this desired slip."""
    return next((c for c in point.conditions if abs(c.condition.kappa - kappa) < 1e-6), None)


def step_window(conditions: Iterable[ConditionResult]) -> tuple[float, float]:
    """Road since the step that all lines share [m]."""
    ends = [c.since_step[np.isfinite(c.measured["fx"])][-1] for c in conditions]
    return (0.0, float(min(ends)))


def estimate_points(
    label: str, x: Sequence[float], estimates: Sequence, style: str = "joined", color: str = ""
) -> Series | None:
    """Fitted numbers with their standard errors; those that are not determined are left out."""
    rows = [
        (a, e.value, e.std_error)
        for a, e in zip(x, estimates, strict=True)
        if e.determined and math.isfinite(e.value)
    ]
    if not rows:
        return None
    array = np.array(sorted(rows))
    error = np.nan_to_num(array[:, 2])
    return Series(label, array[:, 0], array[:, 1], style, color, error=error)


def panel(x_label: str, y_label: str, series: Iterable[Series | None], **options) -> Panel | None:
    """A panel of what there is, or None."""
    there = [s for s in series if s is not None and len(s.x)]
    return Panel(x_label, y_label, there, **options) if there else None


def figure(
    name: str, title: str, caption: str, panels: Iterable[Panel | None], source: str = ""
) -> Iterator[Figure]:
    """A figure of the panels that there are; none without one."""
    there = [p for p in panels if p is not None]
    if there:
        yield Figure(name, title, caption, there, source)


def with_model(
    label: str,
    color: str,
    measured: tuple[np.ndarray, np.ndarray],
    reach: tuple[float, float],
    model: Callable[[np.ndarray], np.ndarray],
) -> list[Series]:
    """Measured points and the model's curve over `reach`, in one colour."""
    fine = np.linspace(*reach, 201)
    curve = np.broadcast_to(model(fine), fine.shape)
    return [
        Series(label, *measured, "points", color),
        Series(label, fine, curve, "curve", color, legend=False),
    ]


def at_point(
    c: Coefficients, fz: Any, kappa: Any, alpha_deg: Any, gamma_deg: float, bar: float
) -> OperatingPoint:
    """Operating point of the Magic Formula from what figures show: degrees and bar."""
    return operating_point(
        c, fz, kappa, np.radians(alpha_deg), math.radians(gamma_deg), 1e5 * bar, SPEED
    )


def scaled(series: Series | None, factor: float) -> Series | None:
    """A series in another unit."""
    if series is None:
        return None
    error = None if series.error is None else series.error * factor
    return replace(series, y=series.y * factor, error=error)
