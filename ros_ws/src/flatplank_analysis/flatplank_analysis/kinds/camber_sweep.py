# SPDX-License-Identifier: Apache-2.0
"""Camber sweep: side force and aligning moment of a rolling tire whose road is tilted.

    Fy = F_0 - C_g (e g + (1 - e) g'),   sigma dg'/dx + g' = g
    Mz = M_0 + C_m (e_m g + (1 - e_m) g')

g: camber [rad]; e, e_m: shares of force and moment without lag. Source of the form: H. B. Pacejka,
Tire and Vehicle Dynamics, chapter 7 (non-lagging part of the camber thrust).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.identify.results import Estimate
from flatplank_analysis.kinds.record_fit import FitParameter, fit_record, relaxed
from flatplank_analysis.post.gridding import bin_means
from flatplank_data.errors import FlatplankError
from flatplank_data.table import MeasurementTable

SPACING = 0.005
"""spacing of the grid over travel [m]"""
LEAST_CAMBER = 2e-3
"""smallest change of camber that is fitted [rad]"""


@dataclass(frozen=True)
class CamberSweep:
    """Results of one sweep; arrays of shape (n,) over travel."""

    camber_stiffness: Estimate
    """C_g = -dFy/dgamma, steady [N/rad]"""
    relaxation_length: Estimate
    """sigma [m]"""
    direct_share: Estimate
    """e [-]"""
    moment_stiffness: Estimate
    """C_m = dMz/dgamma, steady [N m/rad]"""
    position: np.ndarray
    """[m]"""
    camber: np.ndarray
    """[rad]"""
    fy: np.ndarray
    fy_modelled: np.ndarray
    mz: np.ndarray
    mz_modelled: np.ndarray
    rmse: float
    """root mean square error of Fy [N]"""


def camber_sweep(table: MeasurementTable) -> CamberSweep:
    """Fit one run. Raises FlatplankError where the camber does not change."""
    name = "total_camber" if table.has("total_camber") else "road_camber"
    rows = np.vstack([table[name], table["fy"], table["mz"]])
    position, (camber, fy, mz) = bin_means(table["plank_position"], rows, SPACING)
    if np.ptp(camber) < LEAST_CAMBER:
        raise FlatplankError(
            "the camber does not change", table.info.file, "record total_camber [rad]"
        )
    unknowns = (
        FitParameter("C_g", "N/rad", float(np.ptp(fy) / np.ptp(camber)), -1e5, 1e5),
        FitParameter("sigma", "m", 0.3, 0.005, 5.0),
        FitParameter("e", "-", 0.1, -1.0, 1.0),
        FitParameter("C_m", "N m/rad", -float(np.ptp(mz) / np.ptp(camber)), -1e4, 1e4),
        FitParameter("e_m", "-", 0.5, -20.0, 20.0),
        FitParameter("F_0", "N", float(fy[0]), -1e4, 1e4),
        FitParameter("M_0", "N m", float(mz[0]), -1e3, 1e3),
    )

    def model(sets: np.ndarray) -> dict[str, np.ndarray]:
        c_g, sigma, e, c_m, e_m, f_0, m_0 = sets.T[:, :, None]
        late = relaxed(camber, SPACING, sigma[:, 0])
        return {
            "fy": f_0 - c_g * (e * camber + (1.0 - e) * late),
            "mz": m_0 + c_m * (e_m * camber + (1.0 - e_m) * late),
        }

    fit = fit_record(model, {"fy": fy, "mz": mz}, unknowns)
    found, out = fit.estimates, fit.modelled
    return CamberSweep(
        found["C_g"], found["sigma"], found["e"], found["C_m"],
        position, camber, fy, out["fy"], mz, out["mz"], fit.rmse["fy"],
    )  # fmt: skip
