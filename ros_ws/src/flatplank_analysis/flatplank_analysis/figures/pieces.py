# SPDX-License-Identifier: Apache-2.0
"""Parts that several figures share."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from flatplank_analysis.figures.spec import INK, PALETTE, Figure, Panel, Series
from flatplank_analysis.models.base import SPEED
from flatplank_analysis.report.results import CampaignResult, ConditionResult, PointResult
from flatplank_tire.magic_formula import Coefficients, OperatingPoint, operating_point

ROAD = "road displacement [m]"
SINCE_STEP = "road displacement since the step [m]"
FX = "longitudinal force Fx [N]"
FY = "lateral force Fy [N]"
FZ = "vertical force Fz [N]"
SLIP = "slip κ [%]"
ALPHA = "side slip angle α [°]"
RADIUS = "effective rolling radius [mm]"

#: what is varied: field of the operating point -> (symbol, unit)
FACTORS = {
    "fz": ("Fz", "N"),
    "pressure": ("p", "bar"),
    "alpha_deg": ("α", "°"),
    "gamma_deg": ("γ", "°"),
}
_BRAKING = ("#8fbfe8", "#5a9bd5", "#2a72b5", "#124a80")
_DRIVING = ("#f3b48b", "#e5864e", "#c65a22", "#8c3a10")
_NEUTRAL = "#5b6672"


def percent(kappa: float) -> str:
    """Slip as the label of a line."""
    return f"{100 * kappa:+.3g} %".replace("+0 %", "0 %").replace("-", "−")


def level(point: PointResult, factor: str) -> str:
    """Value of the varied factor as the label of a line."""
    symbol, unit = FACTORS[factor]
    gap = "" if unit == "°" else " "
    return f"{symbol} = {getattr(point.point, factor):g}{gap}{unit}"


def slips(point: PointResult) -> list[ConditionResult]:
    """Conditions of a point in order of slip."""
    return sorted(point.conditions, key=lambda c: c.condition.kappa)


def slip_colors(conditions: Sequence[ConditionResult]) -> dict[float, str]:
    """Blue for braking, orange for driving, darker for larger slip; grey for zero slip."""
    levels = [c.condition.kappa for c in conditions]
    out = {level: _NEUTRAL for level in levels}
    for scale, chosen in (
        (_BRAKING, sorted((v for v in levels if v < 0), reverse=True)),
        (_DRIVING, sorted(v for v in levels if v > 0)),
    ):
        steps = max(len(chosen) - 1, 1)
        for i, kappa in enumerate(chosen):
            place = i * (len(scale) - 1) / steps if len(chosen) > 1 else len(scale) - 1
            out[kappa] = scale[round(place)]
    return out


def force_lines(conditions: Sequence[ConditionResult], since_step: bool = False) -> list[Series]:
    """Fx, one line per slip level, labelled at its end."""
    tone = slip_colors(conditions)
    return [
        Series(
            percent(c.condition.kappa),
            c.since_step if since_step else c.position,
            c.measured["fx"],
            color=tone[c.condition.kappa],
            end_label=True,
        )
        for c in conditions
        if "fx" in c.measured
    ]


class Variation(NamedTuple):
    """Points that differ from the nominal one in one factor only, in the order of that factor."""

    factor: str
    points: list[PointResult]

    @property
    def name(self) -> str:
        """Name of the factor in a file name."""
        return self.factor.removesuffix("_deg")

    @property
    def symbol(self) -> str:
        return FACTORS[self.factor][0]

    @property
    def axis(self) -> str:
        """Label of the axis of the factor."""
        symbol, unit = FACTORS[self.factor]
        return f"{symbol} [{unit}]"

    @property
    def labelled(self) -> list[tuple[PointResult, str]]:
        return [(p, level(p, self.factor)) for p in self.points]

    def at_slip(self, kappa: float) -> list[tuple[float, ConditionResult]]:
        """Value of the factor, and condition, of the points that have this slip."""
        there = ((getattr(p.point, self.factor), at_slip(p, kappa)) for p in self.points)
        return [(x, c) for x, c in there if c is not None]


def variations(result: CampaignResult, *factors: str) -> list[Variation]:
    """Variations of these factors, by default of all, that were measured."""
    nominal = result.nominal()
    out = []
    for factor in factors or FACTORS:
        others = [n for n in ("tire", *FACTORS) if n != factor]
        found = {
            getattr(p.point, factor): p
            for p in result.points
            if p.conditions and nominal is not None
            if all(getattr(p.point, n) == getattr(nominal.point, n) for n in others)
        }
        if len(found) > 1:
            out.append(Variation(factor, [found[key] for key in sorted(found)]))
    return out


def crossed(result: CampaignResult) -> dict[float, list[PointResult]]:
    """Points at nominal load and pressure by camber [deg], each in the order of side slip, where
    both angles were varied together; empty otherwise."""
    nominal = result.nominal()
    groups: dict[float, dict[float, PointResult]] = {}
    for p in result.points:
        same = nominal and all(
            getattr(p.point, n) == getattr(nominal.point, n) for n in ("tire", "fz", "pressure")
        )
        if same and p.conditions:
            groups.setdefault(p.point.gamma_deg, {})[p.point.alpha_deg] = p
    if len(groups) < 2 or min(len(g) for g in groups.values()) < 2:
        return {}
    return {
        gamma: [members[alpha] for alpha in sorted(members)]
        for gamma, members in sorted(groups.items())
    }


def loads(result: CampaignResult) -> list[PointResult]:
    """Points with different loads, otherwise the nominal one, if it exists."""
    for varied in variations(result, "fz"):
        return varied.points
    nominal = result.nominal()
    return [] if nominal is None else [nominal]


def at_slip(point: PointResult, kappa: float) -> ConditionResult | None:
    """The condition of a point with this desired slip."""
    return next((c for c in point.conditions if abs(c.condition.kappa - kappa) < 1e-6), None)


def step_window(conditions: Iterable[ConditionResult]) -> tuple[float, float]:
    """Road since the step that all lines share [m]."""
    ends = [c.since_step[np.isfinite(c.measured["fx"])][-1] for c in conditions]
    return (0.0, float(min(ends)))


def estimate_points(
    label: str, x: Sequence[float], estimates: Sequence, factor: float = 1.0
) -> Series | None:
    """Fitted numbers with their standard errors, without undetermined ones."""
    rows = [
        (a, e.value, e.std_error)
        for a, e in zip(x, estimates, strict=True)
        if e.determined and math.isfinite(e.value)
    ]
    if not rows:
        return None
    x, y, error = np.array(sorted(rows)).T
    return Series(label, x, factor * y, "joined", error=factor * np.nan_to_num(error))


def estimates(
    x_label: str,
    groups: Sequence[tuple[str, Sequence[tuple[float, Any]]]],
    quantities: Sequence[tuple[str, str, float]],
) -> list[Panel | None]:
    """A panel per quantity (label, attribute of a fit, factor), a line per group of (x, fit)."""
    return [
        panel(
            x_label,
            y_label,
            [
                estimate_points(
                    label, [x for x, _ in members], [getattr(f, name) for _, f in members], factor
                )
                for label, members in groups
            ],
        )
        for y_label, name, factor in quantities
    ]


def panel(x_label: str, y_label: str, series: Iterable[Series | None]) -> Panel | None:
    """A panel of the existing series; None without any."""
    there = [s for s in series if s is not None and len(s.x)]
    return Panel(x_label, y_label, there) if there else None


def figure(
    name: str, title: str, caption: str, panels: Iterable[Panel | None], source: str = ""
) -> Iterator[Figure]:
    """A figure of the existing panels; no figure without any."""
    there = [p for p in panels if p is not None]
    if there:
        yield Figure(name, title, caption, there, source)


def pair(
    x_label: str, y_label: str, x: np.ndarray, y: np.ndarray, model: np.ndarray,
    title: str = "model", x_range: tuple[float, float] | None = None,
) -> Panel:  # fmt: skip
    """A measured and a modelled line, and their residual below."""
    lines = [Series("measured", x, y, color=PALETTE[0]), Series(title, x, model, "model", INK)]
    panel = Panel(x_label, y_label, lines, x_range)
    return with_residual(panel, [residual(x, y, x, model, PALETTE[0])])


def residual(
    x: np.ndarray, y: np.ndarray, model_x: np.ndarray, model: np.ndarray, color: str
) -> Series:
    """Measured less modelled values where there is a model, as a line of the strip."""
    there = (model_x >= x[0]) & (model_x <= x[-1])
    at = model_x[there]
    return Series("", at, np.interp(at, x, y) - model[there], color=color, legend=False)


def with_residual(panel: Panel, left: Sequence[Series]) -> Panel:
    """A panel with the residuals of its lines in a strip below, in its unit."""
    unit = panel.y_label[panel.y_label.rindex("[") :]
    strip = Panel(panel.x_label, f"residual {unit}", left, panel.x_range, panel.marks)
    return replace(panel, x_label="", strip=strip)


def with_model(
    label: str,
    color: str,
    measured: tuple[np.ndarray, np.ndarray],
    reach: tuple[float, float],
    model: Callable[[np.ndarray], np.ndarray],
    error: np.ndarray | None = None,
) -> list[Series]:
    """Measured points, with error bars if known, and the model's curve over `reach`, in one
    colour."""
    fine = np.linspace(*reach, 201)
    curve = np.broadcast_to(model(fine), fine.shape)
    return [
        Series(label, *measured, "points", color, error=error),
        Series(label, fine, curve, "curve", color, legend=False),
    ]


def at_point(
    c: Coefficients, fz: Any, kappa: Any, alpha_deg: Any, gamma_deg: float, bar: float
) -> OperatingPoint:
    """Operating point of the Magic Formula from degrees and bar."""
    return operating_point(
        c, fz, kappa, np.radians(alpha_deg), math.radians(gamma_deg), 1e5 * bar, SPEED
    )
