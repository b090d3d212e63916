# SPDX-License-Identifier: Apache-2.0
"""Magic Formula 5.2 and 6.0 to 6.2 (Pacejka 2006, 2012, Besselink 2010), as in MF-Tyre; turn
slip is an option.

As in MF-Tyre: alpha itself instead of tan(alpha), digressive friction with A_mu = 1, curvature
factors of at most 1, sign(0) = +1, no reduction of slip at low speed. For other programs the first
three can be set (`SWITCHES`).
"""

from flatplank_tire.magic_formula.coefficients import (
    DEFAULTS,
    FORCES,
    LATEST,
    MOMENT,
    NOT_OF,
    OLD,
    OTHER_NAMES,
    PAC2002,
    REQUIRED,
    SECTION_OF,
    SECTIONS,
    SWITCHES,
    Coefficients,
)
from flatplank_tire.magic_formula.combined import SteadyForces, steady, steady_forces
from flatplank_tire.magic_formula.state import OperatingPoint, operating_point

__all__ = [
    "DEFAULTS",
    "FORCES",
    "LATEST",
    "MOMENT",
    "NOT_OF",
    "OLD",
    "OTHER_NAMES",
    "PAC2002",
    "REQUIRED",
    "SECTIONS",
    "SECTION_OF",
    "SWITCHES",
    "Coefficients",
    "OperatingPoint",
    "SteadyForces",
    "operating_point",
    "steady",
    "steady_forces",
]
