# SPDX-License-Identifier: Apache-2.0
"""Tables of the thesis as printed. Slips are those of `points.SLIPS`, -10 to +10 %."""

from __future__ import annotations

from functools import cache

from flatplank_tire.magic_formula import Coefficients
from flatplank_tire.tir import TirFile, shipped_tir

ACTUAL_SLIP = (-9.80, -4.85, -1.98, -1.05, -0.16, 0.78, 1.73, 4.66, 9.61)
LOAD_CHANGE = (-4.86, -3.36, -1.90, -1.41, -1.29, -0.80, -0.36, 0.12, 0.18)
"""Table 6.3 [%]"""
MAX_SCATTER = {1: 41.0, 2: 27.0, 3: 70.0, 4: 32.0}
"""largest standard deviation of the four conditions, section 6.3 [N]"""
PEAK_SCATTER = 6.8
"""peak of condition 4 at 1.84 m, section 6.3 [%]"""
PLATEAU = {0.01: 80.0, 0.02: 35.0}
"""constant part after the step, section 6.3 [mm]"""

LINEAR_RMSE = (154.0, 92.0, 41.0, 33.0, 24.0, 41.0, 88.0, 152.0, 270.0)
"""Table 7.1 [N]"""
REPAIRED_RMSE = (134.0, 81.0, 64.0, 79.0, 37.0, 67.0, 47.0, 64.0, 66.0)
"""Table 7.3, play reduced to 0.05 mm [N]"""
NONLINEAR_RMSE = {
    "F_z = 1850 N": (68.0, 50.0, 32.0, 42.0, 31.0, 69.0, 59.0, 28.0, 50.0),
    "nominal": (171.0, 139.0, 51.0, 38.0, 43.0, 108.0, 129.0, 78.0, 80.0),
    "F_z = 5550 N": (161.0, 167.0, 91.0, 73.0, 47.0, 95.0, 141.0, 131.0, 115.0),
    "p = 2 bar": (162.0, 140.0, 63.0, 55.0, 43.0, 98.0, 123.0, 98.0, 82.0),
    "γ = 5°": (213.0, 168.0, 63.0, 34.0, 33.0, 96.0, 144.0, 91.0, 96.0),
    "α = 1°": (161.0, 146.0, 57.0, 33.0, 38.0, 96.0, 136.0, 65.0, 82.0),
    "α = 5°": (146.0, 98.0, 40.0, 32.0, 28.0, 31.0, 42.0, 45.0, 89.0),
    "α = 10°": (68.0, 27.0, 28.0, 31.0, 22.0, 30.0, 31.0, 51.0, 85.0),
}
"""Table H.1, its repeated lines once [N]; the nominal line is Table 7.3, too"""
MAGIC_RMSE = {
    "F_z = 1850 N": (124.0, 45.0, 50.0, 68.0, 32.0, 49.0, 50.0, 52.0, 122.0),
    "nominal": (253.0, 179.0, 87.0, 40.0, 52.0, 101.0, 108.0, 106.0, 116.0),
    "F_z = 5550 N": (315.0, 259.0, 112.0, 206.0, 56.0, 119.0, 175.0, 165.0, 141.0),
    "p = 2 bar": (281.0, 208.0, 107.0, 46.0, 60.0, 75.0, 141.0, 129.0, 117.0),
    "γ = 5°": (216.0, 135.0, 63.0, 45.0, 54.0, 102.0, 118.0, 130.0, 241.0),
    "α = 1°": (168.0, 88.0, 41.0, 28.0, 46.0, 115.0, 152.0, 89.0, 183.0),
    "α = 5°": (235.0, 123.0, 65.0, 42.0, 39.0, 25.0, 51.0, 50.0, 133.0),
    "α = 10°": (371.0, 201.0, 69.0, 27.0, 24.0, 45.0, 70.0, 167.0, 265.0),
}
"""Table H.2 [N]; the nominal line is Table 7.4, too"""
WHERE: dict[str, dict[str, float]] = {
    "F_z = 1850 N": {"fz": 1850.0}, "nominal": {}, "F_z = 5550 N": {"fz": 5550.0},
    "p = 2 bar": {"bar": 2.0}, "γ = 5°": {"gamma": 5.0}, "α = 1°": {"alpha": 1.0},
    "α = 5°": {"alpha": 5.0}, "α = 10°": {"alpha": 10.0},
}  # fmt: skip
"""line of Tables H.1 and H.2 -> arguments of `points.point`"""
HALF_LENGTH = {1850.0: 0.0496, 3700.0: 0.0708, 5550.0: 0.0872}
"""a [m] over load [N], by (7.20) with Table 7.2"""
STIFFNESS = {2.5: 2.13e5, 2.0: 1.77e5}
"""C_z [N/m] over pressure [bar], Appendix G"""


@cache
def table_i_1() -> TirFile:
    """Table I.1, the Toyo's column."""
    return shipped_tir()


def coefficients() -> Coefficients:
    """Coefficients of Table I.1, the Toyo's column."""
    return table_i_1().coefficients
