# SPDX-License-Identifier: Apache-2.0
"""Residuals of one output of the Magic Formula: errors, walls, priors, searches."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from idn_points import LOADS, TIR, C, problem

from flatplank_analysis.identify.mf import fit
from flatplank_analysis.identify.mf import problem as problems
from flatplank_analysis.identify.mf.problem import _CURVATURES, Prior
from flatplank_analysis.identify.mf.stages import COEFFICIENTS


def test_curvatures_over_load_and_camber():
    """Polynomials of the load: both signs of the slip, and that of the combined weight."""
    names = {f"PEX{i}": v for i, v in ((1, 0.4), (2, -0.3), (3, 0.2), (4, 0.1))}
    names |= {"LEX": 0.9, "REX1": 0.7, "REX2": -0.5, "LEY": 0.8, "REY1": 0.3, "REY2": 0.6}
    names |= {f"PEY{i}": v for i, v in ((1, 0.5), (2, -0.2), (3, 0.3), (4, 0.4), (5, 2.0))}
    names |= {f"QEZ{i}": v for i, v in ((1, 0.6), (2, -0.1), (3, 0.2), (4, 0.3), (5, 0.5))}
    c, dfz, gamma = TIR.replaced(names).coefficients, np.array([-0.5, 0.4]), np.array([-0.1, 0.2])

    def of(output):
        return np.array(_CURVATURES[output](c, dfz, gamma))

    e = 0.9 * np.polyval([0.2, -0.3, 0.4], dfz)
    np.testing.assert_allclose(of("fx"), [0.9 * e, 1.1 * e, np.polyval([-0.5, 0.7], dfz)])
    e = 0.8 * np.polyval([-0.2, 0.5], dfz)
    tilt, skew = 1.0 + 2.0 * gamma**2, 0.3 + 0.4 * gamma
    np.testing.assert_allclose(of("fy"), [e * (tilt - skew), e * (tilt + skew),
                                          np.polyval([0.6, 0.3], dfz)])  # fmt: skip
    e = np.polyval([0.2, -0.1, 0.6], dfz)
    skew = 0.3 + 0.5 * gamma
    np.testing.assert_allclose(of("mz"), [e * (1.0 - skew), e * (1.0 + skew)])


def test_rows_of_a_problem():
    """Errors over a hundredth of the load; a wall where a curvature passes one; priors."""
    one = problem()
    x = np.array([[C.PKX1, C.PEX1], [1.1 * C.PKX1, 1.5]])
    rows = one.residuals(x)
    np.testing.assert_allclose(rows[0, :15], 0.0, atol=1e-9)
    np.testing.assert_allclose(one.error_scale(), 0.01 * one.points.fz)
    np.testing.assert_allclose(replace(one, weight=2.0, scatter=3.0).error_scale(),
                               0.015 * one.points.fz)  # fmt: skip
    assert not rows[0, 15:-2].any()
    dfz = np.array([LOADS[0], LOADS[-1]]) / (C.LFZO * C.FNOMIN) - 1.0
    e = (1.5 + C.PEX2 * dfz + C.PEX3 * dfz**2) * C.LEX
    wall = np.concatenate([e * (1.0 - C.PEX4), e * (1.0 + C.PEX4)]) - 1.0
    np.testing.assert_allclose(rows[1, 15:19], 1e3 * np.maximum(wall, 0.0))
    np.testing.assert_allclose(rows[1, -2:], (x[1] - x[0]) / (10.0 * one.sizes))
    known = replace(one, priors={"PEX1": Prior(0.3, 0.05)})
    assert known.residuals(x)[1, -1] == pytest.approx((1.5 - 0.3) / 0.05)
    np.testing.assert_allclose(known.prior_information(np.array([False, False])),
                               np.diag([0.0, 400.0]))  # fmt: skip
    assert known.prior_information(np.array([True, False])).tolist() == [[pytest.approx(400.0)]]
    assert one.limit("PKX1") is COEFFICIENTS["PKX1"]
    tight = replace(one, limits={"PKX1": COEFFICIENTS["PKX1"]._replace(upper=5.0)})
    assert tight.start()[0] == 5.0 and one.start().tolist() == x[0].tolist()
    zero = replace(one, base=TIR.replaced({"PKX1": 0.0}).coefficients)
    assert zero.start()[0] == COEFFICIENTS["PKX1"].start


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


def test_every_start_is_searched_from_and_the_best_is_taken(monkeypatch):
    """Shapes of the curve that are not free stay; starts stay inside of their bounds."""
    seen = []

    def search(residuals, start, low, high, sizes, tolerance, iterations):
        seen.append((start.tolist(), tolerance))
        return SimpleNamespace(x=start + 0.01, cost=abs(start[0] - 1.55), low=low, high=high)

    monkeypatch.setattr(problems, "solve", search)
    base = TIR.replaced({"PCX1": 1.2, "PEX1": -4.0, "PKX1": 21.0}).coefficients
    one = problem(free=("PCX1", "PKX1", "PEX1"), base=base)
    found = one.solve(broadly=True)
    rough = [[1.2, 21.0, -4.0], [1.3, 21.0, -1.5], [1.6, 21.0, 0.0]]
    assert seen[:3] == [(s, 1e-3) for s in rough]
    assert seen[3] == (pytest.approx([1.61, 21.01, 0.01]), 1e-8) and len(seen) == 4
    assert (found.low[1], found.high[1]) == (2.0, 150.0)
    seen.clear()
    one.solve()
    assert seen == [(rough[0], 1e-8)]
    seen.clear()
    narrow = {"PCX1": COEFFICIENTS["PCX1"]._replace(upper=1.4)}
    problem(free=("PCX1", "PKX1"), base=base, limits=narrow).solve(broadly=True)
    assert [s for s, _ in seen] == [[1.2, 21.0], [1.3, 21.0], [1.4, 21.0],
                                    pytest.approx([1.41, 21.01])]  # fmt: skip
    seen.clear()
    problem(free=("PKX1",), base=base).solve(broadly=True)  # no shape is free: one search
    assert seen == [([21.0], 1e-8)]


def test_units_of_coefficients():
    """Angles of slip and camber are in their coefficients; stiffnesses are in N/m."""
    units = {"PKX1": "-", "PDX1": "-", "RBX1": "1/rad", "RHX1": "rad", "PKY1": "1/rad",
             "QDZ10": "1/rad2", "RBX3": "1/rad3", "VERTICAL_STIFFNESS": "N/m"}  # fmt: skip
    assert {name: COEFFICIENTS[name].unit for name in units} == units
    assert COEFFICIENTS["PDX3"][:4] == (0.0, -50.0, 50.0, 5.0)
