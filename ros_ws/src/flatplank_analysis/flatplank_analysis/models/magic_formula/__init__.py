# SPDX-License-Identifier: Apache-2.0
"""Magic Formula 6.1/6.2 (Pacejka 2012, Besselink 2010), without turn slip, as MF-Tyre has it.

MF-Tyre's practice is followed: alpha itself instead of tan(alpha), digressive friction with
A_mu = 1, sign(0) = +1, curvature factors capped at 1, no reduction of slip at low speed.
"""

from .coefficients import DEFAULTS, REQUIRED, SECTION_OF, SECTIONS, Coefficients
from .forces import SteadyForces, steady, steady_forces
from .state import OperatingPoint, operating_point

__all__ = [
    "DEFAULTS",
    "REQUIRED",
    "SECTIONS",
    "SECTION_OF",
    "Coefficients",
    "OperatingPoint",
    "SteadyForces",
    "operating_point",
    "steady",
    "steady_forces",
]
