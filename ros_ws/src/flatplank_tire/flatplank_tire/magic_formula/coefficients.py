# SPDX-License-Identifier: Apache-2.0
"""The coefficients of the Magic Formula 5.2 and 6.0 to 6.2: names, sections, defaults.

Names and sections are those of a `.tir` file (tire property file). A coefficient that is not in
the file has its null value: 1 for a scaling factor, 0 otherwise, with the exceptions `_NOT_ZERO`
and `_UNKNOWN`. Sources: Pacejka, Tire and Vehicle Dynamics (3rd ed., 2012) section 4.3.2;
Besselink, Schmeitz, Pacejka (2010), An improved Magic Formula/Swift tyre model.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import prod
from typing import Any

SECTIONS: dict[str, str] = {
    "MODEL": "LONGVL VXLOW",
    "DIMENSION": "UNLOADED_RADIUS WIDTH RIM_RADIUS RIM_WIDTH ASPECT_RATIO",
    "OPERATING_CONDITIONS": "INFLPRES NOMPRES",
    "VERTICAL": (
        "FNOMIN VERTICAL_STIFFNESS VERTICAL_DAMPING PFZ1 Q_FZ2 Q_FCX Q_FCY Q_V1 Q_V2 Q_RE0 "
        "BREFF DREFF FREFF MC_CONTOUR_A MC_CONTOUR_B"
    ),
    "STRUCTURAL": (
        "LONGITUDINAL_STIFFNESS LATERAL_STIFFNESS YAW_STIFFNESS "
        "PCFX1 PCFX2 PCFX3 PCFY1 PCFY2 PCFY3"
    ),
    "CONTACT_PATCH": "Q_RA1 Q_RA2 Q_RB1 Q_RB2",
    # Not in MF-Tyre: the thesis measured that R_e depends on side slip and camber (figures 7.30,
    # 7.31). Other tools ignore unknown sections.
    "FLATPLANK_RADIUS": "Q_REA Q_REG",
    "FLATPLANK_FORMULA": "TAN_ALPHA CAP_E A_MU",
    "SCALING_COEFFICIENTS": (
        "LFZO LCX LMUX LEX LKX LHX LVX LCY LMUY LEY LKY LHY LVY LKYC LKZC LTR LRES LXAL LYKA "
        "LVYKA LS LVMX LMX LMY LMP LGAX LGAY LGAZ LSGKP LSGAL"
    ),
    "LONGITUDINAL_COEFFICIENTS": (
        "PCX1 PDX1 PDX2 PDX3 PEX1 PEX2 PEX3 PEX4 PKX1 PKX2 PKX3 PHX1 PHX2 PVX1 PVX2 "
        "PPX1 PPX2 PPX3 PPX4 RBX1 RBX2 RBX3 RCX1 REX1 REX2 RHX1 PTX1 PTX2 PTX3"
    ),
    "OVERTURNING_COEFFICIENTS": (
        "QSX1 QSX2 QSX3 QSX4 QSX5 QSX6 QSX7 QSX8 QSX9 QSX10 QSX11 QSX12 QSX13 QSX14 PPMX1"
    ),
    "ROLLING_COEFFICIENTS": "QSY1 QSY2 QSY3 QSY4 QSY5 QSY6 QSY7 QSY8",
    "LATERAL_COEFFICIENTS": (
        "PCY1 PDY1 PDY2 PDY3 PEY1 PEY2 PEY3 PEY4 PEY5 PKY1 PKY2 PKY3 PKY4 PKY5 PKY6 PKY7 "
        "PHY1 PHY2 PHY3 PVY1 PVY2 PVY3 PVY4 PPY1 PPY2 PPY3 PPY4 PPY5 "
        "RBY1 RBY2 RBY3 RBY4 RCY1 REY1 REY2 RHY1 RHY2 RVY1 RVY2 RVY3 RVY4 RVY5 RVY6 PTY1 PTY2"
    ),
    "ALIGNING_COEFFICIENTS": (
        "QBZ1 QBZ2 QBZ3 QBZ4 QBZ5 QBZ9 QBZ10 QCZ1 QDZ1 QDZ2 QDZ3 QDZ4 QDZ6 QDZ7 QDZ8 QDZ9 "
        "QDZ10 QDZ11 QEZ1 QEZ2 QEZ3 QEZ4 QEZ5 QHZ1 QHZ2 QHZ3 QHZ4 PPZ1 PPZ2 SSZ1 SSZ2 SSZ3 SSZ4"
    ),
    "TURNSLIP_COEFFICIENTS": (
        "PDXP1 PDXP2 PDXP3 PKYP1 PDYP1 PDYP2 PDYP3 PDYP4 PHYP1 PHYP2 PHYP3 PHYP4 PECP1 PECP2 "
        "QDTP1 QCRP1 QCRP2 QBRP1 QDRP1 QDRP2"
    ),
}

SECTION_OF: dict[str, str] = {
    name: section for section, names in SECTIONS.items() for name in names.split()
}

REQUIRED = ("UNLOADED_RADIUS", "FNOMIN", "NOMPRES")
"""Required for forces; the vertical stiffness is needed only for R_e, a and rho."""
FORCES = {"Fx": ("PCX1", "PDX1", "PKX1"), "Fy": ("PCY1", "PDY1", "PKY1")}
"""force -> coefficients without which it is not known; a file has those of one force or both"""
MOMENT = (
    *(f"QDZ{n}" for n in (1, 2, 3, 4, 6, 7, 8, 9, 10, 11)), *(f"SSZ{n}" for n in range(1, 5)),
)  # fmt: skip
"""coefficients of which one is needed for Mz"""

_NOT_ZERO = {
    "Q_RE0": 1.0, "PKY4": 2.0, "QSY7": 1.0, "LONGVL": 16.7, "CAP_E": 1.0, "A_MU": 1.0,
}  # fmt: skip
_UNKNOWN = dict.fromkeys(
    ("VERTICAL_STIFFNESS", "LATERAL_STIFFNESS", "LONGITUDINAL_STIFFNESS"), float("nan")
)

LATEST, OLD, PAC2002 = "6.1", "5.2", "PAC2002"
"""laws: equations of 6.0 to 6.2 (2010, 2012), of 5.0 to 5.2 (2006), and of 5.2 with the inflation
pressure in friction, stiffness and trail (PAC2002 of Adams and Project Chrono)"""
_OF_ONE_LAW = {
    OLD: "LGAX LGAY LGAZ LSGKP LSGAL PTX1 PTX2 PTX3 PTY1 PTY2 PHY3",
    LATEST: (
        "PFZ1 PCFX1 PCFX2 PCFX3 PCFY1 PCFY2 PCFY3 LKYC LKZC PPX1 PPX2 PPX3 PPX4 RBX3 "
        "QSX4 QSX5 QSX6 QSX7 QSX8 QSX9 QSX10 QSX11 QSX12 QSX13 QSX14 PPMX1 QSY5 QSY6 QSY7 QSY8 "
        "LMP PDXP1 PDXP2 PDXP3 PKYP1 PDYP1 PDYP2 PDYP3 PDYP4 PHYP1 PHYP2 PHYP3 PHYP4 PECP1 "
        "PECP2 QDTP1 QCRP1 QCRP2 QBRP1 QDRP1 QDRP2 "
        "PEY5 PKY4 PKY5 PKY6 PKY7 PPY1 PPY2 PPY3 PPY4 PPY5 RBY4 QDZ10 QDZ11 PPZ1 PPZ2"
    ),
}
NOT_OF: dict[str, frozenset[str]] = {
    OLD: frozenset(_OF_ONE_LAW[LATEST].split()),
    LATEST: frozenset(_OF_ONE_LAW[OLD].split()),
}
BY_PRESSURE = {
    "PFZ1", "PPX1", "PPX2", "PPX3", "PPX4", "PPY1", "PPY2", "PPY3", "PPY4", "PPZ1",
}  # fmt: skip
"""coefficients by which the inflation pressure acts in PAC2002"""
NOT_OF[PAC2002] = NOT_OF[OLD] - BY_PRESSURE
"""law -> coefficients that it does not have; they keep their null values"""

OTHER_NAMES = {"IP": "INFLPRES", "IP_NOM": "NOMPRES", "QPZ1": "PPZ1", "QPFZ1": "PFZ1"}
"""name in files of PAC2002 -> name here"""

SWITCHES = {
    "TAN_ALPHA": "1: tan(alpha) is the slip of all curves, as in the book; 0: alpha itself",
    "CAP_E": "1: curvature factors are at most 1; 0: as they are",
    "A_MU": "digressive friction of the vertical shifts (4.E8): 1 none, the book uses 10",
}
"""Differences between programs; the defaults follow MF-Tyre."""

DEFAULTS: dict[str, float] = {
    name: 1.0 if section == "SCALING_COEFFICIENTS" else 0.0 for name, section in SECTION_OF.items()
} | (_NOT_ZERO | _UNKNOWN)

UNITS: dict[str, dict[str, float]] = {
    "LENGTH": {
        "meter": 1.0, "metre": 1.0, "m": 1.0, "mm": 1e-3, "millimeter": 1e-3, "cm": 1e-2,
        "centimeter": 1e-2, "km": 1e3, "inch": 0.0254, "in": 0.0254, "foot": 0.3048, "ft": 0.3048,
    },
    "FORCE": {
        "newton": 1.0, "n": 1.0, "kn": 1e3, "kilonewton": 1e3, "knewton": 1e3,
        "pound_force": 4.4482216152605, "lbf": 4.4482216152605, "kg_force": 9.80665,
        "kgf": 9.80665,
    },
    "ANGLE": {
        "radians": 1.0, "radian": 1.0, "rad": 1.0, "degrees": 1.0, "degree": 1.0, "deg": 1.0,
    },
    "MASS": {
        "kg": 1.0, "kilogram": 1.0, "gram": 1e-3, "g": 1e-3, "pound_mass": 0.45359237,
        "lbm": 0.45359237, "slug": 14.59390294,
    },
    "TIME": {
        "second": 1.0, "sec": 1.0, "s": 1.0, "millisecond": 1e-3, "ms": 1e-3, "minute": 60.0,
        "hour": 3600.0,
    },
    "PRESSURE": {
        "pascal": 1.0, "pa": 1.0, "kpa": 1e3, "kilopascal": 1e3, "mpa": 1e6, "bar": 1e5,
        "psi": 6894.757293168,
    },
}  # fmt: skip
"""quantity of [UNITS] -> name, in lower case, -> factor to SI"""
_BY_POWERS: tuple[tuple[dict[str, int], str], ...] = (
    ({"LENGTH": 1}, "UNLOADED_RADIUS WIDTH RIM_RADIUS RIM_WIDTH"),
    ({"LENGTH": 1, "TIME": -1}, "LONGVL VXLOW"),
    ({"PRESSURE": 1}, "INFLPRES NOMPRES PRESMIN PRESMAX"),
    ({"FORCE": 1}, "FNOMIN FZMIN FZMAX"),
    ({"FORCE": 1, "LENGTH": -1}, "VERTICAL_STIFFNESS LONGITUDINAL_STIFFNESS LATERAL_STIFFNESS"),
    ({"FORCE": 1, "LENGTH": 1}, "YAW_STIFFNESS"),
    ({"FORCE": 1, "TIME": 1, "LENGTH": -1}, "VERTICAL_DAMPING"),
)
DIMENSIONS = {key: powers for powers, keys in _BY_POWERS for key in keys.split()}
"""key -> powers of its units; a key that is not here is a pure number"""


def factor(key: str, units: Mapping[str, float]) -> float:
    """Factor from the number in the file to SI; `units`: factor of each quantity."""
    return prod(units.get(name, 1.0) ** power for name, power in DIMENSIONS.get(key, {}).items())


class Coefficients:
    """All coefficients as attributes, in SI; a value is a float or an array, such as (sets, 1).

    `law`: version of the equations, a key of NOT_OF. Names that it does not have are ignored.
    """

    def __init__(self, values: Mapping[str, Any], law: str = LATEST) -> None:
        foreign = NOT_OF[law]
        self.__dict__.update(DEFAULTS)
        self.__dict__.update(
            {k: v for k, v in values.items() if k in SECTION_OF and k not in foreign}
        )
        self.__dict__["law"] = law

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(f"the Magic Formula has no coefficient {name}")

    @property
    def has_moment(self) -> bool:
        """Whether one of the coefficients that Mz needs is given."""
        return any(getattr(self, name) for name in MOMENT)

    def replaced(self, values: Mapping[str, Any]) -> Coefficients:
        """A copy with some coefficients changed."""
        return Coefficients({**self.__dict__, **values}, self.law)
