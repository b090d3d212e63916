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
from flatplank_analysis.identify.mf.stages import COEFFICIENTS, general_start
from flatplank_analysis.models.magic_formula import operating_point, steady_forces
from flatplank_analysis.models.magic_formula import structure as shape
from flatplank_data.errors import FlatplankError

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


def test_what_becomes_of_the_coefficients_of_a_stage():
    stage = stages.STAGES["stiffness"]
    p = points(4, fz=np.array([2e3, 2e3, 4e3, 4e3]))
    free = stage.outputs["cx"].split()
    kept, lines = fit._determined(stage, free, p)
    assert kept == ["LONGITUDINAL_STIFFNESS", "PCFX1"]
    assert lines == [
        "PCFX2 not determined by 2 loads (2000 N, 4000 N); left at the start",
        "PCFX3 not determined by 1 pressure (2.5 bar); left at the start",
    ]
    obstacle = fit._obstacle
    assert obstacle(stage, "cx", [], p) == "all coefficients of cx are fixed"
    assert obstacle(stage, "cx", kept, p.rows([])) == "no measurement of cx"
    assert obstacle(stage, "cx", kept, p.rows([0])) == ""
    pure = stages.STAGES["pure_x"]
    assert obstacle(pure, "fx", ["PKX1"], p.rows([0])) == "one measurement of fx"
    assert "1 slip (+0 %)" in obstacle(pure, "fx", ["PKX1"], p)
    assert obstacle(pure, "fx", ["PKX1"], points(2, kappa=np.array([0.0, 0.1]))) == ""
    pressure = stages.STAGES["pressure"]
    two = points(2, pressure=np.array([2e5, 3e5]))
    assert "slip" in obstacle(pressure, "fx", ["PPX1"], two)
    settings = FitFile(fixed={"PKX2": 0.0}, free=("PHX1", "RBX3", "PKY4"))
    names = ["PKX1", "PKX2", "PKX3"]
    assert fit._free(names, "fx", settings, {}) == ["PKX1", "PKX3", "PHX1", "RBX3"]
    assert fit._free(names, "fx", settings, {"fx": ["PKX3"]}) == ["PKX1"]
    outputs = {"PKX1": "fx", "RBX1": "fx", "RBX3": "fx", "PKY4": "fy", "QDZ1": "mz",
               "Q_FZ2": "rho", "Q_RE0": "re", "BREFF": "re"}  # fmt: skip
    assert {name: fit._output_of(name) for name in outputs} == outputs
    with pytest.raises(FlatplankError, match="FNOMIN cannot be fitted"):
        fit._output_of("FNOMIN")
    limit = fit._limit("PKX1", FitFile(bounds={"PKX1": (2.0, 3.0)}))
    assert (limit.lower, limit.upper, limit.start) == (2.0, 3.0, 3.0)
    assert fit._limit("PKX1", FitFile(bounds={"PKX1": (90.0, 95.0)})).start == 90.0
    assert fit._limit("PKX1", FitFile()) is COEFFICIENTS["PKX1"]
    assert general_start()["PKX1"] == COEFFICIENTS["PKX1"].start


def test_every_coefficient_belongs_to_the_output_that_it_changes():
    """A free one that no stage has joins that output's first stage."""
    base = whole_tire()
    axes = LOADS, np.array([0.05, -0.02, 0.03]), np.array([0.08, 0.05, -0.1]), 0.05, 2.2e5

    def of(output, tir):
        c = tir.coefficients
        return stages.PREDICTIONS[output](c, operating_point(c, *axes, 0.03))

    for name in COEFFICIENTS:
        output, more = fit._output_of(name), base.coefficients.__dict__[name] + 0.01
        before, after = of(output, base), of(output, base.replaced({name: more}))
        assert np.any(np.abs(after - before) > 1e-12), (name, output)


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
