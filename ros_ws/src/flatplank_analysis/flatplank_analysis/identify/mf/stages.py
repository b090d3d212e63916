# SPDX-License-Identifier: Apache-2.0
"""The ordered stages of a Magic Formula fit: free coefficients and the measurements they need.

`coefficients.csv` has start, bounds and size of every coefficient that can be identified. `size`
is a large change in the judgement of a tire engineer: a coefficient with an error of that size is
not determined by the data. Bounds enforce C > 0 and mu > 0; E <= 1 is a penalty, since E is a sum.
Sources: typical passenger tires in Pacejka (2012) appendix 3, and the thesis's Table I.1.
"""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib import resources
from typing import NamedTuple

import numpy as np

from flatplank_tire.magic_formula import Coefficients, OperatingPoint, combined, pure, steady
from flatplank_tire.magic_formula import structure as shape

from .points import SteadyPoints

Predict = Callable[[Coefficients, OperatingPoint], np.ndarray]

SMALL_ANGLE = np.radians(0.3)
SMALL_SLIP = 0.004
SMALL_PRESSURE = 0.02
"""Share of the nominal pressure up to which a run counts as being at nominal pressure."""


class Coefficient(NamedTuple):
    """Start value, lower and upper bound, size of a relevant change, unit."""

    start: float
    lower: float
    upper: float
    size: float
    unit: str = "-"


def _table() -> dict[str, Coefficient]:
    text = (resources.files(__package__) / "coefficients.csv").read_text(encoding="utf-8")
    _, *rows = csv.reader(text.splitlines())
    return {
        name: Coefficient(float(start), float(low), float(high), float(size), unit)
        for name, start, low, high, size, unit in rows
    }


COEFFICIENTS = _table()
GENERAL = ("PCX1", "PDX1", "PKX1", "PCY1", "PDY1", "PKY1", "BREFF", "DREFF", "FREFF")
"""Coefficients without which a tire has no force and no rolling radius."""


def general_start() -> dict[str, float]:
    """Start values for no particular tire, for a tire record without a start file."""
    return {name: COEFFICIENTS[name].start for name in GENERAL}


def predict_fx(c: Coefficients, o: OperatingPoint) -> np.ndarray:
    """Fx [N] at combined slip."""
    return pure.longitudinal(c, o).fx0 * combined.weight_x(c, o)


def predict_fy(c: Coefficients, o: OperatingPoint) -> np.ndarray:
    """Fy [N] at combined slip."""
    py = pure.lateral(c, o)
    return py.fy0 * combined.weight_y(c, o) + combined.side_force_by_kappa(c, o, py.mu_y)


PREDICTIONS: dict[str, Predict] = {
    "fx": predict_fx,
    "fy": predict_fy,
    "mz": lambda c, o: steady(c, o).mz,
    "re": lambda c, o: shape.effective_radius(c, o, 0.0),
    "a": shape.contact_half_length,
    "b": shape.contact_half_width,
    "rho": lambda c, o: shape.deflection(c, o, 0.0, 0.0, 0.0),
    "cx": shape.stiffness_x,
    "cy": shape.stiffness_y,
}

SCALE: dict[str, Callable[[SteadyPoints], np.ndarray]] = {
    "fx": lambda p: 0.01 * p.fz,
    "fy": lambda p: 0.01 * p.fz,
    "mz": lambda p: 4e-4 * p.fz,
    "re": lambda p: np.full(len(p), 2e-4),
    "a": lambda p: np.full(len(p), 1e-3),
    "b": lambda p: np.full(len(p), 1e-3),
    "rho": lambda p: np.full(len(p), 1e-4),
    "cx": lambda p: np.full(len(p), 5e3),
    "cy": lambda p: np.full(len(p), 5e3),
}
"""Output -> first guess of its scatter [SI], which the fit then replaces by its own estimate."""


ONLY: dict[str, Callable[[SteadyPoints, Coefficients], np.ndarray]] = {
    "straight": lambda p, c: np.abs(p.alpha) < SMALL_ANGLE,
    "free": lambda p, c: np.abs(p.kappa) < SMALL_SLIP,
    "upright": lambda p, c: np.abs(p.gamma) < SMALL_ANGLE,
    "nominal": lambda p, c: np.abs(p.pressure / c.NOMPRES - 1.0) < SMALL_PRESSURE,
}
"""Selections of points: without side slip, slip, or camber, or at the nominal pressure."""


@dataclass(frozen=True)
class Stage:
    """Coefficients that are free together, with the outputs and points of their fit."""

    name: str
    outputs: dict[str, str]
    """Output -> its free coefficients."""
    only: tuple[str, ...] = ()
    """Names of `ONLY`: selection of the points."""
    needs: tuple[str, ...] = ()
    """Axes of which the data must have more than one level."""
    each: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Output -> further axes of which its data must have more than one level: a stage that scales
    a curve needs the curve."""
    levels: dict[str, tuple[str, int]] = field(default_factory=dict)
    """Coefficient -> axis and its least number of levels; with fewer, the coefficient keeps its
    value. Outputs of a stage with such coefficients need only one point."""

    def select(self, points: SteadyPoints, c: Coefficients) -> np.ndarray:
        """Mask of the selected points (n,)."""
        return np.all([np.ones(len(points), bool), *(ONLY[n](points, c) for n in self.only)], 0)


STAGES: dict[str, Stage] = {
    s.name: s
    for s in (
        Stage(
            "pure_x",
            {"fx": "PCX1 PDX1 PDX2 PEX1 PEX2 PEX3 PEX4 PKX1 PKX2 PKX3 PHX1 PHX2 PVX1 PVX2"},
            ("straight", "upright", "nominal"),
            ("kappa",),
        ),
        Stage(
            "pure_y",
            {"fy": "PCY1 PDY1 PDY2 PEY1 PEY2 PEY3 PKY1 PKY2 PHY1 PHY2 PVY1 PVY2"},
            ("free", "upright", "nominal"),
            ("alpha",),
        ),
        Stage(
            "aligning",
            {"mz": "QBZ1 QBZ2 QCZ1 QDZ1 QDZ2 QEZ1 QEZ2 QHZ1 QHZ2 QDZ6 QDZ7"},
            ("free", "upright", "nominal"),
            ("alpha",),
        ),
        Stage(
            "combined",
            {
                "fx": "RBX1 RBX2 RCX1 REX1 RHX1",
                "fy": "RBY1 RBY2 RBY3 RCY1 RHY1",
                "mz": "SSZ1 SSZ2",
            },
            ("upright", "nominal"),
            ("kappa", "alpha"),
        ),
        Stage(
            "pressure",
            {"fx": "PPX1 PPX2 PPX3 PPX4", "fy": "PPY1 PPY2 PPY3 PPY4", "mz": "PPZ1"},
            ("upright",),
            ("pressure",),
            {"fx": ("kappa",), "fy": ("alpha",), "mz": ("alpha",)},
        ),
        Stage(
            "camber",
            {
                "fx": "PDX3",
                "fy": "PDY3 PEY4 PEY5 PHY3 PKY3 PKY5 PKY6 PKY7 PVY3 PVY4",
                "mz": "QBZ5 QDZ3 QDZ4 QDZ8 QDZ9 QHZ3",
            },
            needs=("gamma",),
        ),
        Stage("radius", {"re": "BREFF DREFF FREFF Q_REA Q_REG"}),
        Stage(
            "stiffness",
            {
                "rho": "VERTICAL_STIFFNESS PFZ1",
                "a": "Q_RA1 Q_RA2",
                "b": "Q_RB1 Q_RB2",
                "cx": "LONGITUDINAL_STIFFNESS PCFX1 PCFX2 PCFX3",
                "cy": "LATERAL_STIFFNESS PCFY1 PCFY2 PCFY3",
            },
            levels={
                f"PCF{axis}{number}": need
                for axis in "XY"
                for number, need in ((1, ("fz", 2)), (2, ("fz", 3)), (3, ("pressure", 2)))
            },
        ),
    )
}
"""Stages in the order of the fit; later ones hold the results of earlier ones."""
