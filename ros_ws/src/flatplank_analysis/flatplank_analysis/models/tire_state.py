# SPDX-License-Identifier: Apache-2.0
"""All results of the Magic Formula for one operating point of a tire."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from pathlib import Path

from flatplank_data.errors import FlatplankError
from flatplank_tire.magic_formula import (
    FORCES,
    LATEST,
    Coefficients,
    moment,
    operating_point,
    steady,
)
from flatplank_tire.magic_formula import structure as shape
from flatplank_tire.tir import TirFile, read_tir

from .base import SPEED


@dataclass(frozen=True)
class TireState:
    """Steady state of a rolling tire. SI, ISO W; NaN where coefficients are missing.

    fx, kx, sigma_x need the coefficients of Fx; fy, ky, sigma_y, mz those of Fy.
    """

    fx: float
    """Longitudinal force [N]."""
    fy: float
    """Lateral force [N]."""
    mz: float
    """Aligning moment [Nm]; NaN when the file has none of its coefficients."""
    mx: float
    """Overturning moment [Nm]; NaN when the file has none of its coefficients."""
    my: float
    """Rolling resistance moment [Nm], negative forward; NaN without its coefficients."""
    re: float
    """Effective rolling radius [m]."""
    a: float
    """Half contact length [m]; NaN when the file has none of its coefficients."""
    sigma_x: float
    """Longitudinal relaxation length [m]."""
    sigma_y: float
    """Lateral relaxation length [m]."""
    kx: float
    """Longitudinal slip stiffness [N]."""
    ky: float
    """Cornering stiffness [N/rad]; negative in ISO W."""

    def to_json(self) -> dict[str, float | None]:
        """Values for programs; None where a value is not known."""
        return {k: v if math.isfinite(v) else None for k, v in asdict(self).items()}


def tire_state(
    tir: TirFile | Coefficients | str | Path,
    fz: float,
    kappa: float = 0.0,
    alpha: float = 0.0,
    gamma: float = 0.0,
    pressure: float | None = None,
    vx: float = SPEED,
    turn_slip: float | None = None,
) -> TireState:
    """State at load fz [N], kappa [-], alpha, gamma [rad], pressure [Pa], speed vx [m/s].

    pressure: None for that of the file (INFLPRES, IP), or its nominal one without it.
    turn_slip: curvature of the path [1/m], positive to the left; None: left out.
    """
    if isinstance(tir, (str, Path)):
        tir = read_tir(tir)
    c = tir.coefficients if isinstance(tir, TirFile) else tir
    bar = (c.INFLPRES or c.NOMPRES) if pressure is None else pressure
    o = operating_point(c, fz, kappa, alpha, gamma, bar, vx)
    if turn_slip is not None:
        _refuse_without_turn_slip(c)
    forces = steady(c, o, turn_slip)

    def any_given(keys: str, numbers: range) -> bool:
        return any(getattr(c, f"{keys}{n}") for n in numbers)

    has_x, has_y = (any(getattr(c, k) for k in keys) for keys in FORCES.values())
    has_z = has_y and c.has_moment
    mx = moment.overturning(c, o, forces.fy) if any_given("QSX", range(1, 15)) else math.nan
    my = moment.rolling_resistance(c, o, forces.fx) if any_given("QSY", range(1, 7)) else math.nan
    return TireState(
        fx=float(forces.fx) if has_x else math.nan,
        fy=float(forces.fy) if has_y else math.nan,
        mz=float(forces.mz) if has_z else math.nan,
        mx=float(mx),
        my=float(my),
        re=float(shape.rolling(c, o, vx)[0]),
        a=float(shape.contact_half_length(c, o)) if c.Q_RA1 or c.Q_RA2 else math.nan,
        sigma_x=float(shape.relaxation_x(c, o)) if has_x else math.nan,
        sigma_y=float(shape.relaxation_y(c, o)) if has_y else math.nan,
        kx=float(forces.kxk) if has_x else math.nan,
        ky=float(forces.kya) if has_y else math.nan,
    )


def _refuse_without_turn_slip(c: Coefficients) -> None:
    if c.law != LATEST:
        remedy = "leave the turn slip out, or give a file of FITTYP 60 to 62"
        raise FlatplankError(f"Magic Formula {c.law} has no turn slip", "turn slip", remedy)
    missing = [k for k in ("PHYP1", "PHYP2", "QCRP1", "QDRP1") if not getattr(c, k)]
    if missing:
        what = f"{', '.join(missing)} missing or zero"
        raise FlatplankError(what, "turn slip", "add to section [TURNSLIP_COEFFICIENTS]")
