# SPDX-License-Identifier: Apache-2.0
"""What a fitted output says: errors, bounds, rows of points that were not measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from idn_points import TIR, C, problem

from flatplank_analysis.identify.mf import fit, stages, statement
from flatplank_analysis.identify.mf.points import steady_points
from flatplank_analysis.identify.mf.problem import OutputProblem, Prior
from flatplank_analysis.identify.mf.stages import COEFFICIENTS
from flatplank_tire.magic_formula import operating_point, steady_forces


def test_a_bound_and_too_few_runs_have_no_error():
    one = problem()
    found = one.solve()
    edge = replace(found, at_upper=np.array([True, False]), at_lower=np.array([False, False]))
    told, held = statement.report("fx", one, edge, [])
    pkx, pex = told.estimates
    assert pkx.at_bound == "upper" and not pkx.determined and pkx.note == "rests on its bound"
    assert np.isnan(pkx.std_error) and pex.determined
    assert told.runs == 15 and told.model == "mf:fx"
    assert not held.run_contributions[:, 0].any() and held.run_contributions[:, 1].shape == (15,)
    low = replace(found, at_lower=np.array([True, False]), at_upper=np.array([False, False]))
    assert statement.report("fx", one, low, [])[0].estimates[0].at_bound == "lower"
    # as many coefficients as runs: nothing is left over for an error
    points_of_two = replace(one.points, run=np.arange(15) % 2)
    few = replace(one, points=points_of_two)
    told, _ = statement.report("fx", few, found, [])
    assert (
        np.isnan(told.estimates[0].std_error) and "as many coefficients" in told.estimates[0].note
    )
    three = replace(one, points=replace(one.points, run=np.arange(15) % 3))
    told, _ = statement.report("fx", three, found, [])
    assert np.isfinite(told.estimates[0].std_error) and told.runs == 3
    shifted = replace(found, residual=found.residual + 2.0)
    told, _ = statement.report("fx", one, shifted, [])
    wanted = np.sqrt(np.mean((0.02 * one.points.fz) ** 2))
    assert told.rmse == pytest.approx(wanted, rel=0.02)


def test_a_coefficient_without_influence_has_the_error_of_its_weak_prior():
    """Ten sizes that matter; a stated prior gives its own."""
    free = problem(free=("PKX1", "PPX1"))
    told, _ = statement.report("fx", free, free.solve(), [])
    assert told["PPX1"].std_error == pytest.approx(10.0 * COEFFICIENTS["PPX1"].size)
    assert not told["PPX1"].determined and told["PKX1"].determined
    stated = replace(free, priors={"PPX1": Prior(0.2, 0.07)})
    told, _ = statement.report("fx", stated, stated.solve(), [])
    assert told["PPX1"].value == pytest.approx(0.2)
    assert told["PPX1"].std_error == pytest.approx(0.07, rel=1e-3) and told["PPX1"].determined


def test_a_steering_zero_is_said_beside_what_it_shifts():
    """Without mirrored angles the cornering stiffness and its shifts carry the warning."""
    one_sided = [0.0, 1.0, 2.0, 4.0, 6.0, 9.0]
    for degrees, warned in ((one_sided, True), ([-4.0, 1.0, -1.0, 4.0, 6.0, 9.0], False)):
        alpha = np.radians(degrees)
        fy = steady_forces(C, np.full(6, 3700.0), 0.0, alpha, 0.0, 2.5e5, 0.03)[1]
        at = steady_points({"fy": fy}, fz=np.full(6, 3700.0), alpha=alpha, pressure=2.5e5)
        one = OutputProblem("fy", at, ("PKY1", "PDY1"), C)
        told, _ = statement.report("fy", one, one.solve(), [])
        assert ("steering zero" in told["PKY1"].note) is warned
        assert "steering zero" not in told["PDY1"].note


@pytest.mark.parametrize(("off", "determined"), [(0.0, True), (5e-4, False)])
def test_a_law_that_misses_another_pressure_does_not_determine_the_radius(off, determined):
    """r_e at 2 bar is 0.5 mm above the law, which has only C_z over pressure; the remark has the
    standard error."""
    bars, loads = (2.5e5, 2.0e5), (1850.0, 3700.0, 5550.0)
    fz, pressure, repeat = np.array([(f, p, r) for p in bars for f in loads for r in (-1, 1)]).T
    law = stages.PREDICTIONS["re"](C, operating_point(C, fz, 0.0, 0.0, 0.0, pressure, 0.03))
    measured = law + off * (pressure < 2.2e5) + 2e-5 * repeat
    wanted = ("BREFF", "DREFF", "FREFF")
    settings = fit.FitFile("mf", stages=("radius",), fixed={"Q_REA": 0.0, "Q_REG": 0.0})
    found = fit.fit_magic_formula(
        steady_points({"re": measured}, fz=fz, pressure=pressure), TIR, settings
    )
    for name in wanted:
        e = found.estimates[name]
        assert e.determined is determined, e
        assert (e.note == "") is determined
        assert determined or e.note.endswith(f"± {e.std_error:.2g}")
        assert determined or "since the law is off" in e.note
    if not determined:
        (told,) = found.fits["re"].confusions
        assert set(told.names) == set(wanted)
        assert "from 2.0 bar to 2.5 bar" in told.statement
        assert told.remedy == "fit the runs of one pressure alone (2.0 bar or 2.5 bar)"
    for bar in (2.5e5, 2.0e5):
        one = pressure == bar
        points = steady_points({"re": measured[one]}, fz=fz[one], pressure=pressure[one])
        alone = fit.fit_magic_formula(points, TIR, settings)
        assert all(alone.estimates[name].determined for name in wanted)
