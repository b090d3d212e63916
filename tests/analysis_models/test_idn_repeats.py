# SPDX-License-Identifier: Apache-2.0
"""Repeats: scatter from run to run, means of levels and of start angles."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from idn_runs import X, numbers, run

from flatplank_analysis.identify import repeats
from flatplank_analysis.identify import repeats as means
from flatplank_analysis.identify.linear import linear_run
from flatplank_analysis.identify.results import Estimate
from flatplank_analysis.identify.steady_curve import steady_curve


def test_mean_and_error_of_every_slip_level():
    runs = [run(0.02, name=f"{i}") for i in range(3)] + [run(-0.01)]
    runs[0] = replace(runs[0], kappa=0.023)
    forces = (1800.0, 1830.0, 1890.0, -900.0)
    fits = [SimpleNamespace(steady_force=SimpleNamespace(value=f)) for f in forces]
    curve = steady_curve(runs, fits)
    assert curve.kappa == pytest.approx([-0.01, 0.021]) and curve.repeats.tolist() == [1, 3]
    assert curve.force == pytest.approx([-900.0, 1840.0])
    assert np.isnan(curve.std_error[0])
    assert curve.std_error[1] == pytest.approx(np.std(forces[:3], ddof=1) / 3.0**0.5)


def fits_of(values, error=0.0, determined=True):
    """Linear fits with these steady forces."""
    one = Estimate("x", 1.0, "-", 0.01, 9.0)
    return [
        SimpleNamespace(steady_force=replace(one, value=v, std_error=error, determined=determined))
        for v in values
    ]


def test_scatter_from_run_to_run_is_relative_and_beyond_the_noise():
    fits = fits_of((90.0, 100.0, 110.0, 40.0, 60.0, 7.0), error=2.0)
    groups = [[0, 1, 2], [3, 4], [5]]
    squares = (200.0 - 2.0 * 4.0) / 100.0**2 + (200.0 - 4.0) / 50.0**2
    found = repeats._scatter(fits, groups, "steady_force")
    assert found == pytest.approx(np.sqrt(squares / 3.0))
    assert np.isnan(repeats._scatter(fits, [[0], [3], [5]], "steady_force"))
    assert np.isnan(
        repeats._scatter(fits_of((1.0, 2.0), determined=False), [[0, 1]], "steady_force")
    )
    assert repeats._scatter(fits_of((100.0, 101.0), 50.0), [[0, 1]], "steady_force") == 0.0


def test_fits_of_a_condition_carry_the_scatter_of_their_repeats():
    noise = numbers(9, 6, len(X))
    runs = [
        run(0.02, name=f"{i}", fx=g * run(0.02).fx + 2.0 * noise[i])
        for i, g in enumerate((0.9, 1.0, 1.1, 0.95, 1.05))
    ]
    found = repeats.fit_linear(runs)
    assert found.scatter["steady_force"] == pytest.approx(
        np.std([0.9, 1, 1.1, 0.95, 1.05], ddof=1), rel=0.02
    )
    (level,) = found.levels
    errors = [f.steady_force.std_error for f in found.fits]
    assert errors[0] == pytest.approx(0.079 * 1620.0, rel=0.03)
    assert level.steady_force.value == pytest.approx(1800.0, rel=2e-3)
    assert level.steady_force.std_error == pytest.approx(np.sqrt(np.sum(np.square(errors))) / 5.0)
    assert level.steady_force.dof == 4.0 and level.repeats == 5
    assert level.rmse == pytest.approx(np.sqrt(np.mean([f.rmse_transient**2 for f in found.fits])))
    assert found.noise.std == pytest.approx(2.0 / 2.0**0.5, rel=0.1)  # two samples a cell
    single = repeats.fit_linear(runs[:1])
    alone = linear_run(X, runs[0].fx, 0.02)
    assert single.fits[0].sigma.std_error == pytest.approx(alone.sigma.std_error)
    assert single.levels[0].sigma.dof == alone.sigma.dof
    assert single.levels[0].repeats == 1 and "no slip level" in single.confusions[0].statement


def test_repeats_of_several_starts_share_their_relaxation_length():
    """A run's own forces beside the mean's length; the error is what the runs pull."""
    runs = [run(0.02, start=s, fx=g * run(0.02).fx + b, name=f"{s}")
            for s, g, b in ((1, 0.9, 20.0), (2, 1.0, 0.0), (3, 1.1, -20.0))]  # fmt: skip
    found = means.shared_fits(runs)
    assert [f.sigma.value for f in found] == pytest.approx([0.4] * 3, rel=2e-3)
    assert means.asymptotes(runs) == pytest.approx([1640.0, 1800.0, 1960.0], rel=2e-3)
    assert [f.start_force.value for f in found] == pytest.approx([20.0, 0.0, -20.0], abs=1.0)
    mean = means.mean_response(runs)
    np.testing.assert_allclose(mean.std_error[1:], [160.0 / 3.0**0.5, 20.0 / 3.0**0.5], rtol=0.02)
    assert means.has_mean(runs) and not means.has_mean(runs[:1])
    assert not means.has_mean([replace(r, kappa=0.001) for r in runs])
    level = repeats.fit_linear(runs).levels[0]
    assert level.steady_force.dof == 2.0
    assert level.slip_stiffness.std_error == pytest.approx(level.steady_force.std_error / 0.02)


def test_derivatives_of_the_mean_response():
    fit = linear_run(X, run(0.02).fx + 50.0 - 30.0 * (X < 0.0), 0.02)
    x, weight = fit.distance, np.linspace(1.0, 2.0, len(fit.distance))
    found = means._jacobian(fit, x, weight)
    for i, name in enumerate(("sigma", "steady_force", "start_force")):
        one = getattr(fit, name)
        step = 1e-5 * abs(one.value)
        ends = [replace(fit, **{name: replace(one, value=one.value + d)}) for d in (step, -step)]
        slope = (ends[0].response(x) - ends[1].response(x)) / (2.0 * step)
        np.testing.assert_allclose(found[:, i], weight * slope, rtol=1e-4, atol=1e-6)


def test_starts_that_were_repeated_unevenly_are_averaged():
    long, short = X, X[(X > -0.05) & (X < 2.0)]
    uneven = [run(0.02, 1), run(0.02, 2), run(0.02, 1, distance=short, fx=0.0 * short)]
    uneven[2] = replace(uneven[2], kappa=0.03, name="again")
    one, two = means.with_equal_starts(uneven)
    assert (one.start, two.start) == (1, 2) and two is uneven[1]
    assert one.name == uneven[0].name != "again"
    np.testing.assert_array_equal(one.distance, long[(long >= short[0]) & (long <= short[-1])])
    np.testing.assert_allclose(one.fx, 0.5 * np.interp(one.distance, X, uneven[0].fx))
    assert one.kappa == 0.025
    even = [run(0.02, 1), run(0.02, 2)]
    assert means.with_equal_starts(even) == even


def test_weights_before_the_step_hold_in_the_error_of_the_mean():
    """The pull of a run is its weighted straight-line fit on the derivatives of the mean."""
    runs = [run(0.02, start=s, fx=run(0.02).fx + b * (X < 0.0) + 8.0 * numbers(s, len(X)))
            for s, b in ((1, 30.0), (2, 0.0), (3, -30.0))]  # fmt: skip
    found = means.mean_response(runs)
    x = X[X >= -0.1]
    weight = np.where(x < 0.0, 20.0**0.5, 1.0)
    jac = means._jacobian(found.fit, x, weight)
    rows = [weight * (r.fx[X >= -0.1] - found.fit.response(x)) for r in runs]
    pulls = np.array([np.linalg.lstsq(jac, row, rcond=None)[0] for row in rows])
    np.testing.assert_allclose(found.std_error, pulls.std(axis=0, ddof=1) / 3.0**0.5, rtol=1e-6)


def test_a_run_has_its_own_forces_beside_the_shared_length():
    """Weighted linear least squares; a start force that is given stays."""
    mean = linear_run(X, run(0.02).fx, 0.02)
    one = run(0.02, fx=1.1 * run(0.02).fx + 25.0 + 9.0 * numbers(5, len(X)) - 12.0 * (X < 0.0))
    own = means._own(one, mean)
    weight = np.where(X < 0.0, 20.0**0.5, 1.0)
    grown = -np.expm1(-np.maximum(X, 0.0) / mean.sigma.value)
    basis = weight[:, None] * np.column_stack([grown, 1.0 - grown])
    wanted = np.linalg.lstsq(basis, weight * one.fx, rcond=None)[0]
    assert (own.steady_force.value, own.start_force.value) == pytest.approx(tuple(wanted))
    assert own.sigma == mean.sigma
    given = linear_run(X[X > 0.0], run(0.02).fx[X > 0.0], 0.02)
    own = means._own(one, given)
    grown = -np.expm1(-np.maximum(X, 0.0) / given.sigma.value)
    steady = (weight * grown) @ (weight * one.fx) / np.sum((weight * grown) ** 2)
    assert own.start_force.value == 0.0 and own.steady_force.value == pytest.approx(steady)


@pytest.mark.parametrize(
    ("scatter", "dof", "freedom"),
    [(0.03, 4.0, 4.0), (0.0, 4.0, 4.0), (np.nan, 4.0, 9.0), (0.03, 0.0, 9.0)],
)
def test_freedom_of_a_level_is_that_of_its_scatter_where_it_is_known(scatter, dof, freedom):
    one = Estimate("x", 5.0, "-", 0.4, 9.0)
    estimates = [replace(one, value=v, std_error=e) for v, e in ((4.0, 0.3), (8.0, 0.4))]
    fits = [
        SimpleNamespace(sigma=e, slip_stiffness=e, steady_force=e, rmse_transient=r)
        for e, r in zip(estimates, (3.0, 4.0), strict=True)
    ]
    fits[1].sigma = replace(estimates[1], at_bound="upper")
    runs = [replace(run(0.02), kappa=k) for k in (0.019, 0.022)]
    told = dict.fromkeys(repeats.QUANTITIES, scatter)
    level = repeats._level(runs, fits, [0, 1], dof, told)
    assert level.sigma.dof == freedom and level.sigma.at_bound == "upper"
    assert (level.level, level.kappa, level.repeats) == (0.02, pytest.approx(0.0205), 2)
    assert level.steady_force.value == 6.0 and level.steady_force.at_bound == ""
    assert level.steady_force.std_error == pytest.approx(0.5 / 2.0)
    assert level.rmse == pytest.approx(12.5**0.5)


def test_an_estimate_that_is_not_determined_is_not_widened():
    one = Estimate("x", -5.0, "-", 0.3, 9.0)
    fit = linear_run(X, run(0.02).fx, 0.02)
    fit = replace(fit, sigma=one, slip_stiffness=one, steady_force=replace(one, determined=False))
    wide = repeats._widened(fit, {"sigma": 0.08, "slip_stiffness": np.nan, "steady_force": 0.08})
    assert wide.sigma.std_error == pytest.approx(0.5)
    assert wide.slip_stiffness.std_error == 0.3 == wide.steady_force.std_error


def test_runs_of_one_name_are_told_apart():
    """Two campaigns may have runs of one name, slip and start."""
    runs = [run(0.02), run(0.02, fx=1.1 * run(0.02).fx), run(0.01)]
    found = repeats.fit_linear(runs)
    assert [f.steady_force.value for f in found.fits] == pytest.approx(
        [1800.0, 1980.0, 900.0], rel=2e-3
    )
    assert [level.repeats for level in found.levels] == [1, 2]
    assert runs[0] == runs[0] and runs[0] != runs[1]


def test_levels_as_json():
    level = repeats.fit_linear([run(0.02), run(0.02, start=2)]).levels[0]
    plain = replace(level, rmse=math.nan, kappa=np.float64(0.02)).to_json()
    assert plain["rmse"] is None and type(plain["kappa"]) is float
    assert plain["repeats"] == 2 and plain["sigma"]["unit"] == "m"
