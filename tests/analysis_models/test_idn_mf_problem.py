# SPDX-License-Identifier: Apache-2.0
"""Residuals of one output of the Magic Formula: errors, walls, priors, searches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from idn_points import TIR, C, problem

from flatplank_analysis.identify.mf import fit
from flatplank_analysis.identify.mf.stages import COEFFICIENTS


def test_a_search_from_several_shapes_finds_the_curve():
    off = TIR.replaced({"PKX1": 0.6 * C.PKX1, "PCX1": 1.05, "PEX1": -4.0}).coefficients
    one = problem(free=("PCX1", "PDX1", "PEX1", "PKX1"), base=off)
    found = one.solve(broadly=True)
    assert found.residual[:15] == pytest.approx(np.zeros(15), abs=0.05)
    assert found.x[3] == pytest.approx(C.PKX1, rel=0.01)
    scatter = fit._scatter(one, replace(found, residual=np.ones_like(found.residual)))
    assert scatter == pytest.approx(np.sqrt(15.0 / 11.0))
    assert fit._scatter(replace(one, weight=2.0), replace(found, residual=np.ones(15))) == (
        pytest.approx(2.0 * np.sqrt(15.0 / 11.0))
    )
    assert fit._scatter(one, replace(found, residual=np.zeros(15))) == 1e-3


def test_units_of_coefficients():
    """Angles of slip and camber are in their coefficients; stiffnesses are in N/m."""
    units = {"PKX1": "-", "PDX1": "-", "RBX1": "1/rad", "RHX1": "rad", "PKY1": "1/rad",
             "QDZ10": "1/rad2", "RBX3": "1/rad3", "VERTICAL_STIFFNESS": "N/m"}  # fmt: skip
    assert {name: COEFFICIENTS[name].unit for name in units} == units
    assert COEFFICIENTS["PDX3"][:4] == (0.0, -50.0, 50.0, 5.0)
