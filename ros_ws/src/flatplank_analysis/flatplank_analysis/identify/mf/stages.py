# SPDX-License-Identifier: Apache-2.0
"""The ordered stages of a Magic Formula fit: what is free, and which measurements tell it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ...models.magic_formula import Coefficients, OperatingPoint, combined, moment, pure
from ...models.magic_formula import structure as shape
from .points import SteadyPoints

Predict = Callable[[Coefficients, OperatingPoint], np.ndarray]
Select = Callable[[SteadyPoints, Coefficients], np.ndarray]

SMALL_ANGLE = np.radians(0.3)
SMALL_SLIP = 0.004
SMALL_PRESSURE = 0.02
"""Share of the nominal pressure up to which a run counts as being at nominal pressure."""


def predict_fx(c: Coefficients, o: OperatingPoint) -> np.ndarray:
    """Fx [N] at combined slip."""
    return pure.longitudinal(c, o).fx0 * combined.weight_x(c, o)


def predict_fy(c: Coefficients, o: OperatingPoint) -> np.ndarray:
    """Fy [N] at combined slip."""
    py = pure.lateral(c, o)
    return py.fy0 * combined.weight_y(c, o) + combined.side_force_by_kappa(c, o, py.mu_y)


def predict_mz(c: Coefficients, o: OperatingPoint) -> np.ndarray:
    """Mz [Nm] at combined slip."""
    px, py, g = pure.longitudinal(c, o), pure.lateral(c, o), combined.weight_y(c, o)
    fx = px.fx0 * combined.weight_x(c, o)
    fy = py.fy0 * g + combined.side_force_by_kappa(c, o, py.mu_y)
    return moment.aligning(c, o, py, px.kxk, g, fx, fy)


PREDICTIONS: dict[str, Predict] = {
    "fx": predict_fx,
    "fy": predict_fy,
    "mz": predict_mz,
    "re": lambda c, o: shape.effective_radius(c, o, 0.0),
    "a": shape.contact_length,
    "b": shape.contact_width,
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
"""First guess of the scatter, which the fit then replaces by what it finds."""


@dataclass(frozen=True)
class Stage:
    """Coefficients that are free together, the outputs and the points that they are fitted to."""

    name: str
    outputs: dict[str, str]
    """Output -> its free coefficients."""
    select: Select
    needs: tuple[str, ...] = ()
    """Axes of which the data must hold more than one level."""
    each: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """The same for single outputs: pressure scales a curve, which must be there."""
    levels: dict[str, tuple[str, int]] = field(default_factory=dict)
    """Coefficient -> axis and number of its levels without which it stays as it is. Outputs of
    such a stage are told by one point."""


def _nominal(p: SteadyPoints, c: Coefficients) -> np.ndarray:
    return np.abs(p.pressure / c.NOMPRES - 1.0) < SMALL_PRESSURE


def _upright(p: SteadyPoints) -> np.ndarray:
    return np.abs(p.gamma) < SMALL_ANGLE


def _pure_x(p: SteadyPoints, c: Coefficients) -> np.ndarray:
    return (np.abs(p.alpha) < SMALL_ANGLE) & _upright(p) & _nominal(p, c)


def _pure_y(p: SteadyPoints, c: Coefficients) -> np.ndarray:
    return (np.abs(p.kappa) < SMALL_SLIP) & _upright(p) & _nominal(p, c)


def _combined(p: SteadyPoints, c: Coefficients) -> np.ndarray:
    return _upright(p) & _nominal(p, c)


def _pressure(p: SteadyPoints, c: Coefficients) -> np.ndarray:
    return _upright(p)


def _all(p: SteadyPoints, c: Coefficients) -> np.ndarray:
    return np.ones(len(p), bool)


STAGES: dict[str, Stage] = {
    s.name: s
    for s in (
        Stage(
            "pure_x",
            {"fx": "PCX1 PDX1 PDX2 PEX1 PEX2 PEX3 PEX4 PKX1 PKX2 PKX3 PHX1 PHX2 PVX1 PVX2"},
            _pure_x,
            ("kappa",),
        ),
        Stage(
            "pure_y",
            {"fy": "PCY1 PDY1 PDY2 PEY1 PEY2 PEY3 PKY1 PKY2 PHY1 PHY2 PVY1 PVY2"},
            _pure_y,
            ("alpha",),
        ),
        Stage(
            "aligning",
            {"mz": "QBZ1 QBZ2 QCZ1 QDZ1 QDZ2 QEZ1 QEZ2 QHZ1 QHZ2 QDZ6 QDZ7"},
            _pure_y,
            ("alpha",),
        ),
        Stage(
            "combined",
            {
                "fx": "RBX1 RBX2 RCX1 REX1 RHX1",
                "fy": "RBY1 RBY2 RBY3 RCY1 RHY1",
                "mz": "SSZ1 SSZ2",
            },
            _combined,
            ("kappa", "alpha"),
        ),
        Stage(
            "pressure",
            {"fx": "PPX1 PPX2 PPX3 PPX4", "fy": "PPY1 PPY2 PPY3 PPY4", "mz": "PPZ1"},
            _pressure,
            ("pressure",),
            {"fx": ("kappa",), "fy": ("alpha",), "mz": ("alpha",)},
        ),
        Stage(
            "camber",
            {
                "fx": "PDX3",
                "fy": "PDY3 PEY4 PEY5 PKY3 PKY5 PKY6 PKY7 PVY3 PVY4",
                "mz": "QBZ5 QDZ3 QDZ4 QDZ8 QDZ9 QHZ3",
            },
            _all,
            ("gamma",),
        ),
        Stage("radius", {"re": "BREFF DREFF FREFF Q_REA Q_REG"}, _all),
        Stage(
            "stiffness",
            {
                "rho": "VERTICAL_STIFFNESS PFZ1",
                "a": "Q_RA1 Q_RA2",
                "b": "Q_RB1 Q_RB2",
                "cx": "LONGITUDINAL_STIFFNESS PCFX1 PCFX2 PCFX3",
                "cy": "LATERAL_STIFFNESS PCFY1 PCFY2 PCFY3",
            },
            _all,
            levels={
                f"PCF{axis}{number}": need
                for axis in "XY"
                for number, need in ((1, ("fz", 2)), (2, ("fz", 3)), (3, ("pressure", 2)))
            },
        ),
    )
}
"""In the order in which they are fitted; later ones hold what earlier ones found."""
