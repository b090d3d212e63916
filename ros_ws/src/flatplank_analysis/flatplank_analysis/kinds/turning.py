# SPDX-License-Identifier: Apache-2.0
"""Impulse turning: side force and aligning moment of a rolling tire with a steering impulse.

The heading psi over travel is side slip and, by its slope, turn slip. The model is a linear brush
of half length a on a lateral carcass spring, which sticks everywhere (H. B. Pacejka, Tire and
Vehicle Dynamics, chapters 3 and 5): a tread element at xi from the middle is deflected by

    dv = -psi dx + xi dpsi - du,      Fy = C/(2 a^2) integral v dxi = c_y u,
    Mz = C/(2 a^2) integral xi v dxi

so that the steady side force is -C psi, and c_y = C / (sigma - a).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from flatplank_analysis.identify.results import Estimate
from flatplank_analysis.kinds.record_fit import FitParameter, fit_record
from flatplank_analysis.post.gridding import bin_means
from flatplank_data.errors import FlatplankError
from flatplank_data.table import MeasurementTable

SPACING = 0.004
"""spacing of the grid over travel [m]"""
LEAST_ANGLE = 1e-3
"""smallest angle that is fitted [rad]"""
ELEMENTS = 24
"""number of tread elements"""


@dataclass(frozen=True)
class Turning:
    """Results of one impulse; arrays of shape (n,) over travel."""

    cornering_stiffness: Estimate
    """C = -dFy/dalpha at 0 [N/rad]"""
    relaxation_length: Estimate
    """sigma [m]"""
    half_length: Estimate
    """a [m]"""
    remaining_angle: Estimate = field(metadata={"json": "angle_left"})
    """heading that remains after the impulse, relative to the encoder reading [rad]"""
    position: np.ndarray
    """[m]"""
    angle: np.ndarray
    """[rad]"""
    fy: np.ndarray
    fy_modelled: np.ndarray
    mz: np.ndarray
    mz_modelled: np.ndarray
    rmse: float
    """root mean square error of Fy [N]"""
    rmse_moment: float
    """root mean square error of Mz [N m]"""


def turning(table: MeasurementTable) -> Turning:
    """Fit one run. Raises FlatplankError where the wheel was not steered.

    After the impulse the steering may rest at another angle than its encoder reads (one count,
    play of the worm gear). This difference is fitted within two counts.
    """
    rows = np.vstack([table["steer_angle"], table["fy"], table["mz"]])
    position, (angle, fy, mz) = bin_means(table["plank_position"], rows, SPACING)
    if np.ptp(angle) < LEAST_ANGLE:
        raise FlatplankError(
            "the steering angle does not move", table.info.file, "record steer_angle [rad]"
        )
    turned = np.cumsum(np.abs(np.diff(angle, prepend=angle[0])))
    share = turned / turned[-1]
    count = _resolution(table["steer_angle"])
    unknowns = (
        FitParameter("C", "N/rad", 5e4, 1e3, 1e6),
        FitParameter("sigma", "m", 0.4, 0.02, 3.0),
        FitParameter("a", "m", 0.07, 0.02, 0.2),
        FitParameter("psi_r", "rad", 0.0, -2.0 * count, 2.0 * count),
        FitParameter("F_0", "N", float(fy[0]), -1e4, 1e4),
        FitParameter("M_0", "N m", float(mz[0]), -1e3, 1e3),
    )

    def model(sets: np.ndarray) -> dict[str, np.ndarray]:
        stiffness, sigma, half, left, f_0, m_0 = sets.T
        heading = (angle - angle[0]) + left[:, None] * share
        force, moment = brush(position, heading, stiffness, sigma, half)
        return {"fy": f_0[:, None] + force, "mz": m_0[:, None] + moment}

    fit = fit_record(model, {"fy": fy, "mz": mz}, unknowns)
    found, out = fit.estimates, fit.modelled
    return Turning(
        found["C"], found["sigma"], found["a"], found["psi_r"],
        position, angle, fy, out["fy"], mz, out["mz"], fit.rmse["fy"], fit.rmse["mz"],
    )  # fmt: skip


def brush(
    position: np.ndarray,
    heading: np.ndarray,
    stiffness: np.ndarray,
    sigma: np.ndarray,
    half: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Fy [N] and Mz [N m] (sets, n) of the linear brush over travel (n,) [m].

    heading (sets, n) [rad]; cornering stiffness [N/rad], relaxation length and half contact
    length [m] of shape (sets,). Each set steps over its own elements, one element per step.
    """
    sets = len(half)
    step = 2.0 * half / ELEMENTS
    length = float(position[-1] - position[0])
    grids = position[0] + np.arange(int(np.ceil(length / step.min())) + 1) * step[:, None]
    psi = np.array([np.interp(g, position, h) for g, h in zip(grids, heading, strict=True)])
    xi = (0.5 - (np.arange(ELEMENTS) + 0.5) / ELEMENTS) * 2.0 * half[:, None]
    spring = stiffness / (2.0 * half**2) * step
    carcass = stiffness / np.maximum(sigma - half, 0.01 * half)
    # an element that enters within a step is in contact for half of the step
    part = np.ones(ELEMENTS)
    part[0] = 0.5
    v = np.zeros((sets, ELEMENTS))
    u = np.zeros(sets)
    force, moment = np.zeros_like(grids), np.zeros_like(grids)
    for i in range(1, grids.shape[1]):
        v[:, 1:], v[:, 0] = v[:, :-1].copy(), 0.0
        turn = psi[:, i] - psi[:, i - 1]
        side = -0.5 * (psi[:, i] + psi[:, i - 1]) * step
        v += part * (side[:, None] + xi * turn[:, None])
        # the carcass deflects until it balances the tread: c_y (u + du) = spring sum(v - part du)
        du = (spring * v.sum(axis=1) - carcass * u) / (carcass + spring * part.sum())
        v -= part * du[:, None]
        u += du
        force[:, i] = carcass * u
        moment[:, i] = spring * np.sum(xi * v, axis=1)
    back = [
        [np.interp(position, g, y) for g, y in zip(grids, rows, strict=True)]
        for rows in (force, moment)
    ]
    return np.array(back[0]), np.array(back[1])


def _resolution(angle: np.ndarray) -> float:
    """Resolution of the encoder, from the smallest change in the record [rad]."""
    steps = np.diff(np.unique(np.round(angle[np.isfinite(angle)], 9)))
    return float(np.min(steps[steps > 1e-8], initial=1e-2))
