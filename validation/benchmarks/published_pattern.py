# SPDX-License-Identifier: Apache-2.0
"""Compares the simulated machine of the thesis with published results: relaxation lengths of
Figure 7.3, and the change of the errors of Table 7.3 when the play of the road is reduced to 0.05
mm.

The thesis explains the two errors that rise (-1 and -2 %) by the constant part after the step,
"present to a greater extent" in the later runs. Both readings are printed: with the lost motion
as it was, and with a larger one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.report.results import PointResult
from plant_points import SLIPS, analyse_runs, simulate_point

PRESET = "thesis2023"
TABLE_7_3 = (171, 139, 51, 38, 43, 108, 129, 78, 80)
TABLE_7_3_CUT = (134, 81, 64, 79, 37, 67, 47, 64, 66)
"""RMSE of the nonlinear model over SLIPS, before and after the play was reduced [N]"""
RADIUS_SCALE = 0.9983
"""ratio of r_e from the controller at +50 N to r_e at Fx = 0 [-]: 50 N and more over C_Fk, and the
road of the preset runs 0.13 % faster than its encoder"""
WITHOUT_SCATTER = {
    "travel_scatter": {"tooth": 0.0},
    "step_delay": {"most": 0.0},
    "mesh_ripple": {"tooth": 20.0e-6, "turn": 40.0e-6},
}
"""the preset without what is fitted to the scatter of repeats: with three runs per condition the
scatter hides changes of a few newtons"""
CUT = {"road_play": {"gap": 0.05e-3}}
LARGER_PLATEAU = {
    "rack_backlash": {"gap": 1.3e-3, "friction": 20.0},
    "wheel_backlash": {"half_angle": math.radians(150.0)},
}
"""lost motion of 1.3 mm at the rack and 1.1 mm in the wheel drive (at the road), instead of 0.64
and 0.11 mm"""


@dataclass(frozen=True)
class Pattern:
    """Quantities compared with the thesis; arrays over SLIPS."""

    sigma: np.ndarray
    """relaxation length before the play is reduced [m]"""
    before: np.ndarray
    """RMSE of the nonlinear model before the play is reduced [N]"""
    cut: np.ndarray
    """RMSE with reduced play and unchanged lost motion [N]"""
    larger: np.ndarray
    """RMSE with reduced play and larger lost motion [N]"""

    def signs(self, after: np.ndarray) -> np.ndarray:
        """True where the error changes in the direction of Table 7.3."""
        published = np.subtract(TABLE_7_3_CUT, TABLE_7_3)
        return np.sign(after - self.before) == np.sign(published)


def measure(seed: int = 0) -> Pattern:
    """Three campaigns of nine slips x three starts."""
    first = _point({}, seed)
    linear = {c.condition.kappa: c.linear.sigma.value for c in first.conditions}
    return Pattern(
        np.array([linear[k] for k in SLIPS]),
        _errors(first),
        _errors(_point(CUT, seed)),
        _errors(_point(CUT | LARGER_PLATEAU, seed)),
    )


def _point(defects: Mapping, seed: int) -> PointResult:
    made = simulate_point(PRESET, WITHOUT_SCATTER | defects, radius_scale=RADIUS_SCALE, seed=seed)
    return analyse_runs(made)


def _errors(point: PointResult) -> np.ndarray:
    found = {c.kappa: value for c, value in point.models["nonlinear"].rmse.items()}
    return np.array([found[k] for k in SLIPS])


def main() -> None:
    """Print the rows beside those of the thesis."""
    p = measure()
    rows = {
        "slip [%]": [f"{100 * k:g}" for k in SLIPS],
        "sigma_x, linear model [m]": [f"{v:.2f}" for v in p.sigma],
        "RMSE nonlinear [N]": [f"{v:.0f}" for v in p.before],
        "  Table 7.3": [str(v) for v in TABLE_7_3],
        "play cut, change [N]": [f"{v:+.0f}" for v in p.cut - p.before],
        "  sign of Table 7.3": ["yes" if s else "NO" for s in p.signs(p.cut)],
        "and larger plateau [N]": [f"{v:+.0f}" for v in p.larger - p.before],
        "  sign as in Table 7.3": ["yes" if s else "NO" for s in p.signs(p.larger)],
        "  Table 7.3, change": [
            f"{b - a:+d}" for a, b in zip(TABLE_7_3, TABLE_7_3_CUT, strict=True)
        ],
    }
    for name, cells in rows.items():
        print(f"{name:26s}" + "".join(f"{c:>7s}" for c in cells))


if __name__ == "__main__":
    main()
