# SPDX-License-Identifier: Apache-2.0
"""Sets of coefficients: any one but the switches may differ, and each is a tire of its own."""

from __future__ import annotations

import numpy as np
import pytest

from flatplank_tire.magic_formula import (
    DEFAULTS,
    LATEST,
    NOT_OF,
    OLD,
    SWITCHES,
    Coefficients,
    operating_point,
    steady,
    steady_forces,
    turn_slip,
)
from flatplank_tire.magic_formula import structure as shape
from flatplank_tire.tir import shipped_tir

VALUES = shipped_tir().values | {
    "LATERAL_STIFFNESS": 1e5, "QDZ1": 0.1, "QBZ1": 9.0, "QCZ1": 1.1, "RBX1": 9.0, "RCX1": 1.0,
    "RBY1": 8.0, "RCY1": 1.0, "RVY4": 5.0, "RVY5": 1.9, "RVY6": 9.0,
}  # fmt: skip
TURNING = {
    "PDXP1": 0.4, "PDXP2": 0.1, "PDXP3": 0.3, "PKYP1": 1.2, "PDYP1": 0.4, "PDYP2": 0.1,
    "PDYP3": 0.2, "PDYP4": 0.3, "PHYP1": 1.1, "PHYP2": 0.15, "PHYP3": 0.05, "PHYP4": -4.0,
    "PECP1": 0.5, "QDTP1": 10.0, "QCRP1": 0.2, "QCRP2": 0.1, "QBRP1": 0.1, "QDRP1": 0.8,
}  # fmt: skip
AT = (np.array([2500.0, 5200.0]), 0.03, np.array([-0.05, 0.08]), 0.04, 2.2e5, 20.0)


@pytest.mark.parametrize(("law", "turn_slip"), [(LATEST, None), (LATEST, 0.1), (OLD, None)])
def test_any_coefficient_may_differ_between_lanes(law, turn_slip):
    base = VALUES | ({} if turn_slip is None else TURNING)
    names = DEFAULTS.keys() - NOT_OF[law] - SWITCHES.keys()
    for name in names:
        first = base.get(name, DEFAULTS[name])
        pair = [first, 1.1 * first + 0.01]
        sets = Coefficients(base | {name: np.array([[v] for v in pair])}, law)
        o = operating_point(sets, *AT)
        both, radius = steady(sets, o, turn_slip), shape.effective_radius(sets, o, 0.0)
        for i, value in enumerate(pair):
            c = Coefficients(base | {name: value}, law)
            own = operating_point(c, *AT)
            for many, alone in zip((*both, radius), (*steady(c, own, turn_slip),
                                   shape.effective_radius(c, own, 0.0)), strict=True):  # fmt: skip
                full = np.broadcast_to(many, (2, 2))[i]
                np.testing.assert_allclose(
                    full, np.broadcast_to(alone, 2), rtol=1e-12, err_msg=name
                )


def test_forces_of_arrays_of_any_shape_are_those_of_their_points():
    c = Coefficients(VALUES)
    fz, kappa, alpha = np.array([[2e3], [4e3]]), np.array([-0.02, 0.0, 0.05]), 0.03
    many = steady_forces(c, fz, kappa, alpha, vx=20.0)
    for force in many:
        assert force.shape == (2, 3)
    for i in range(2):
        for j in range(3):
            one = steady_forces(c, fz[i, 0], kappa[j], alpha, vx=20.0)
            np.testing.assert_allclose([f[i, j] for f in many], [float(f) for f in one])


def test_a_quotient_of_nothing_is_nothing():
    found = turn_slip._over(np.array([0.0, 6.0]), np.array([0.0, -2.0]))
    assert found.tolist() == [0.0, -3.0]
