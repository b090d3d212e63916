# SPDX-License-Identifier: Apache-2.0
"""Stages of a Magic Formula fit: points, predictions, coefficients, refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from idn_points import LOADS, TIR, C, points, whole_tire

from flatplank_analysis.identify.mf import fit, stages
from flatplank_analysis.identify.mf.fit import FitFile, fit_magic_formula
from flatplank_analysis.identify.mf.points import steady_points
from flatplank_data.errors import FlatplankError
from flatplank_tire.magic_formula import operating_point, steady_forces
from flatplank_tire.magic_formula import structure as shape

CLOSED = {
    "pure_x": ("alpha", "gamma", "pressure"), "pure_y": ("kappa", "gamma", "pressure"),
    "aligning": ("kappa", "gamma", "pressure"), "combined": ("gamma", "pressure"),
    "pressure": ("gamma",), "camber": (), "radius": (), "stiffness": (),
}  # fmt: skip
"""stage -> axes along which it takes no points away from zero, or from the nominal pressure"""


def test_points_of_runs_that_a_stage_takes():
    p = points(
        5, kappa=np.array([0.0, 0.05, 0.0, 0.0, 0.0]),
        alpha=np.array([0.0, 0.0, 0.1, 0.0, 0.0]), gamma=np.array([0.0, 0.0, 0.0, 0.1, 0.0]),
        pressure=C.NOMPRES * np.array([1.0, 1.019, 1.0, 1.0, 1.021]),
    )  # fmt: skip
    wanted = {
        "pure_x": [0, 1], "pure_y": [0, 2], "combined": [0, 1, 2], "pressure": [0, 1, 2, 4],
        "camber": [0, 1, 2, 3, 4],
    }  # fmt: skip
    for name, rows in wanted.items():
        mask = stages.STAGES[name].select(p, C)
        assert np.flatnonzero(mask).tolist() == rows, name
    for sign in (1.0, -1.0):
        off = {"kappa": 0.0041, "alpha": np.radians(0.31), "gamma": np.radians(0.31),
               "pressure": 0.021}  # fmt: skip
        for axis, value in off.items():
            for share, outside in ((1.0, True), (0.9, False)):
                moved = sign * share * value
                axes = {axis: C.NOMPRES * (1.0 + moved) if axis == "pressure" else moved}
                near = points(1, **({"pressure": C.NOMPRES} | axes))
                for name, closed in CLOSED.items():
                    taken = bool(stages.STAGES[name].select(near, C)[0])
                    assert taken is not (outside and axis in closed), (name, axes)
    scale = {k: stages.SCALE[k](p)[0] for k in ("fx", "fy", "mz", "re", "cx", "rho")}
    assert scale == pytest.approx({"fx": 37.0, "fy": 37.0, "mz": 1.48, "re": 2e-4, "cx": 5e3,
                                   "rho": 1e-4})  # fmt: skip


def test_predictions_are_those_of_the_law():
    c = whole_tire().coefficients
    axes = LOADS, np.array([0.05, -0.02, 0.0]), np.array([0.0, 0.05, -0.1]), 0.01, 2.4e5
    o = operating_point(c, *axes, 0.03)
    for name, wanted in zip(("fx", "fy", "mz"), steady_forces(c, *axes, 0.03), strict=True):
        np.testing.assert_allclose(stages.PREDICTIONS[name](c, o), wanted)
    still = operating_point(c, LOADS, 0.0, 0.0, 0.0, 2.5e5, 0.03)
    rho = stages.PREDICTIONS["rho"](c, still)
    np.testing.assert_allclose(rho, shape.deflection(c, still, 0.0, 0.0, 0.0))
    np.testing.assert_allclose(stages.PREDICTIONS["re"](c, still),
                               shape.effective_radius(c, still, 0.0))  # fmt: skip


def test_a_fit_without_its_points_is_refused():
    p = points(
        4,
        kappa=np.array([-0.1, 0.0, 0.1, 0.2]),
        pressure=np.array([3.2004e5, 3.1996e5, 3.2e5, 3.2e5]),
    )
    with pytest.raises(FlatplankError, match=r"nominal pressure of 2.5 bar \(runs are at 3.2 bar"):
        fit_magic_formula(p, TIR, FitFile(stages=("pure_x",)))
    near = replace(p, pressure=np.full(4, 2.54e5), alpha=np.full(4, 0.1))
    with pytest.raises(FlatplankError) as error:
        fit_magic_formula(near, TIR, FitFile(stages=("pure_x",)))
    assert "no steady Fx or Fy to fit" in str(error.value) and "(runs" not in str(error.value)
    bare = replace(p, pressure=np.full(4, np.nan))
    with pytest.raises(FlatplankError, match="pressure not stated"):
        fit_magic_formula(bare, TIR)
    radius = steady_points({"re": 0.3 + 1e-6 * LOADS}, fz=LOADS, pressure=2.5e5)
    found = fit_magic_formula(radius, TIR, FitFile(stages=("radius",)))
    assert set(found.fits) == {"re"}
    assert found.cx_source.startswith("not measured: the start value of")
    none = TIR.replaced({"LONGITUDINAL_STIFFNESS": float("nan")})
    assert fit._start_cx(none) == "not known: no fit and no start file tells it"
