# SPDX-License-Identifier: Apache-2.0
"""Parts of the fits, each against numbers that are known without it."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import t as student

from flatplank_analysis.identify import (
    carcass_joint,
    carcass_problem,
    grid,
    least_squares,
    repeats,
)
from flatplank_analysis.identify import information as info
from flatplank_analysis.identify import linear as linear_fit
from flatplank_analysis.identify import mean_response as means
from flatplank_analysis.identify.lateral import lateral_run
from flatplank_analysis.identify.linear import linear_run
from flatplank_analysis.identify.noise import ARNoise, _stable, fit_noise, repeat_differences
from flatplank_analysis.identify.quality import transient_end
from flatplank_analysis.identify.results import Confusion, Estimate, Fit, to_plain
from flatplank_analysis.identify.runs import StepRun, actual_slip, by_condition, by_level
from flatplank_analysis.identify.steady_curve import steady_curve
from flatplank_analysis.identify.steering_zero import (
    NAMES,
    _solved,
    lack_of_mirrors,
    steering_zero,
)
from flatplank_analysis.identify.uncertainty import Carried, run_covariance
from flatplank_data.errors import FlatplankError
from flatplank_data.info import RunInfo
from flatplank_data.table import MeasurementTable
from flatplank_validation.fits.campaigns import Truth, simulate_runs

X = np.arange(-0.0995, 2.5, 0.001)


def numbers(seed: int, *size: int) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal(size)


def run(kappa: float = 0.02, start: int = 1, fx=None, name: str = "r", **more) -> StepRun:
    """A slip step with an exponential Fx; 900 N per hundredth of slip, 0.4 m."""
    x = more.pop("distance", X)
    fx = 9e4 * kappa * -np.expm1(-np.maximum(x, 0.0) / 0.4) if fx is None else fx
    zero = np.zeros_like(x)
    slip = kappa * np.maximum(x, 0.0)
    columns = {"fy": zero, "mz": zero, "fz": zero + 3700.0, "slip": slip}
    columns |= {k: more.pop(k) for k in columns if k in more}
    return StepRun(name, "one", kappa, kappa, x, fx, start=start, **columns, **more)


def test_an_even_grid_stays_as_it_is():
    x = 0.002 * np.arange(50)
    values = numbers(1, 2, 50)
    centres, found = grid.bin_means(x, values)
    np.testing.assert_array_equal(centres, x)
    np.testing.assert_array_equal(found, values)


def test_cells_begin_at_the_step_and_gaps_are_filled():
    x = np.array([-0.0005, 0.0002, 0.0012, 0.0015, 0.0045, 0.0061, 0.0063, 0.0079, 0.009])
    values = np.where(x == 0.0012, np.nan, 10.0 * x)
    centres, found = grid.bin_means(x, values)
    np.testing.assert_allclose(centres, 0.002 * np.arange(-1, 5) + 0.001)
    # of a straight line every cell has its own value, the empty one between 2 and 4 mm, too
    np.testing.assert_allclose(found[1:-1], 10.0 * centres[1:-1])
    assert found.shape == centres.shape


def test_covariance_of_a_mean_is_that_of_the_means_of_runs():
    """CR2: unbiased where all runs are alike, with one degree of freedom less than runs."""
    runs, each = 7, 5
    y = numbers(2, runs, 1) + 0.1 * numbers(3, runs, each)
    jac = np.ones((runs * each, 1))
    index = np.repeat(np.arange(runs), each)
    found = run_covariance(jac, (y - y.mean()).ravel(), index)
    own = y.mean(axis=1)
    assert found.matrix[0, 0] == pytest.approx(own.var(ddof=1) / runs)
    assert found.dof[0] == pytest.approx(runs - 1.0)
    assert found.information[0, 0] == runs * each
    np.testing.assert_allclose(found.brought[:, 0] ** 2 @ np.ones(runs), found.matrix[0, 0])
    assert found.correlation == pytest.approx(np.eye(1))
    # a prior that knows as much as the data halves the pull and has an error of its own
    prior = np.array([[float(runs * each)]])
    halved = run_covariance(jac, (y - y.mean()).ravel(), index, prior)
    assert halved.information[0, 0] == 2.0 * runs * each
    pulls = (own - y.mean()) * each / (2.0 * runs * each) / np.sqrt(1.0 - 0.5 / runs)
    assert halved.matrix[0, 0] == pytest.approx(pulls @ pulls + 0.25 / (runs * each))
    # what an earlier fit brought to a row comes with its run
    carried = Carried(np.array([0, 9]), np.ones((2, runs * each)) * [[0.3], [2.0]])
    both = run_covariance(jac, (y - y.mean()).ravel(), index, None, carried)
    pulls = (own - y.mean()) / runs / np.sqrt(1.0 - 1.0 / runs)
    pulls[0] -= 0.3
    assert both.matrix[0, 0] == pytest.approx(pulls @ pulls + 2.0**2)
    assert both.runs.tolist() == [*range(runs), 9]


def test_two_parameters_are_as_correlated_as_their_errors():
    index = np.repeat(np.arange(4000), 2)
    jac = np.column_stack([np.ones(8000), np.tile([0.0, 1.0], 4000)])
    noise = numbers(4, 8000)
    noise -= jac @ np.linalg.lstsq(jac, noise, rcond=None)[0]
    found = run_covariance(jac, noise, index)
    np.testing.assert_allclose(found.matrix, np.linalg.inv(jac.T @ jac), rtol=0.1)
    assert found.correlation[0, 1] == pytest.approx(-(0.5**0.5), abs=0.05)
    np.testing.assert_allclose(found.dof, 3998.0)
    # a direction that the rows do not have stays out; a run that is alone in one tells nothing
    flat = run_covariance(np.column_stack([jac[:, 0], 0.0 * jac[:, 0]]), noise, index)
    assert flat.std_error[1] == 0.0 and flat.std_error[0] > 0.0


def test_numbers_of_a_first_order_noise():
    noise = ARNoise((0.8,), 3.0, 1000)
    assert noise.gain == pytest.approx(5.0)
    assert noise.std == pytest.approx(3.0 / 0.6)
    assert noise.effective_samples == pytest.approx(1000.0 * 0.2 / 1.8)
    white = numbers(5, 2, 400)
    np.testing.assert_allclose(noise.whiten(noise.colour(white)), white / 3.0)
    assert ARNoise((), 0.0, 50).effective_samples == 50.0
    assert ARNoise((1.0,), 1.0, 9).gain == 1e3
    # an endless memory is cut, a short one stays
    np.testing.assert_allclose(_stable(np.array([1.1])), [0.999])
    np.testing.assert_allclose(_stable(np.array([0.5, 0.2])), [0.5, 0.2])
    assert _stable(np.zeros(0)) == ()
    found = fit_noise([noise.colour(3.0 * w) for w in numbers(6, 20, 2000)])
    assert found.coefficients[0] == pytest.approx(0.8, abs=0.02)
    assert found.innovation == pytest.approx(3.0, rel=0.02) and found.samples == 40000
    assert (
        len(fit_noise([noise.colour(w) for w in numbers(6, 5, 2000)], order=2).coefficients) == 2
    )
    short = fit_noise([np.array([3.0, -4.0])])
    assert (short.coefficients, short.samples) == ((), 2)
    assert short.innovation == pytest.approx(12.5**0.5)
    assert fit_noise([]).samples == 1


def test_differences_between_repeats_have_the_variance_of_one_run():
    group = numbers(7, 3, 5000) + 50.0
    found = repeat_differences([group, group[:1]])
    assert len(found) == 3
    assert np.mean(np.square(found)) == pytest.approx(1.0, rel=0.05)
    two = repeat_differences([group[:2]])
    np.testing.assert_allclose(two[0], (group[0] - group[1]) / 2.0**0.5)


def test_a_run_without_slip_has_the_error_of_a_mean():
    force = 33.0 + np.where(X < 0.0, 500.0, 0.0) + 2.0 * numbers(8, len(X))
    white = ARNoise((), 2.0, 1000)
    found = linear_run(X, force, 0.0, noise=white, spacing=0.001)
    after = X >= 0.0
    assert found.steady_force.value == pytest.approx(force[after].mean())
    assert found.steady_force.std_error == pytest.approx(2.0 / np.sqrt(after.sum()))
    assert found.steady_force.dof == pytest.approx(999.0)
    assert found.rmse_total == pytest.approx(force[after].std())
    assert found.settled and found.transient_end == X[-1]
    own = linear_run(X, force, 0.0019, spacing=0.001)
    assert own.kappa == 0.0019 and own.steady_force.std_error == pytest.approx(
        2.0 / np.sqrt(after.sum()), rel=0.3
    )


def test_numbers_of_a_first_order_response():
    force = -100.0 + 1900.0 * -np.expm1(-np.maximum(X, 0.0) / 0.4)
    found = linear_run(X, force, 0.02, spacing=0.001)
    assert found.reached_force == pytest.approx(force[-1], abs=0.1)
    assert found.rmse_transient < 0.05 and found.rmse_total < 0.05
    # slope over steady force: 1900/1800 exp(-x/0.4)/0.4 = 0.05
    assert found.transient_end == pytest.approx(0.4 * np.log(1900 / 1800 / 0.4 / 0.05), abs=0.003)
    assert found.settled and len(found.distance) == len(found.residual) == len(X)
    assert not linear_run(X, force, 0.02, start_force=-100.0).start_force.std_error
    given = linear_run(X[X > 0.0], force[X > 0.0], 0.02, start_force=-100.0)
    assert given.start_force.fixed and given.start_force.value == -100.0
    assert given.sigma.value == pytest.approx(0.4, rel=2e-3)
    # without samples before the step the thesis takes zero
    zero = linear_run(X[X > 0.0], force[X > 0.0] + 100.0, 0.02)
    assert zero.start_force.fixed and zero.start_force.value == 0.0
    assert zero.slip_stiffness.value == pytest.approx(9.5e4, rel=2e-3)
    # a run of three relaxation lengths has settled
    for reach, settled in ((1.25, True), (1.15, False)):
        assert linear_run(X[reach > X], force[reach > X], 0.02).settled is settled
    # a hard spring rests on its bound, and is no measurement
    hard = linear_run(X, np.where(X < 0.0, 0.0, 1800.0), 0.02)
    assert hard.sigma.at_bound == "lower" and not hard.sigma.determined
    assert "lower bound" in hard.sigma.note and hard.steady_force.determined


def test_errors_of_a_first_order_response_are_those_of_many_draws():
    truth = 1800.0 * -np.expm1(-np.maximum(X, 0.0) / 0.4)
    found = [
        linear_run(X, truth + 20.0 * numbers(100 + i, len(X)), 0.02, spacing=0.001)
        for i in range(60)
    ]
    for name in ("sigma", "steady_force", "slip_stiffness", "start_force"):
        values = [getattr(f, name).value for f in found]
        errors = [getattr(f, name).std_error for f in found]
        assert np.median(errors) == pytest.approx(np.std(values), rel=0.35), name
    pairs = np.array([(f.sigma.value, f.steady_force.value) for f in found])
    wanted = np.corrcoef(pairs.T)[0, 1]
    assert np.median([f.correlation for f in found]) == pytest.approx(wanted, abs=0.3)


def test_best_of_the_ladder_where_a_search_starts():
    x = np.linspace(-0.1, 2.5, 600)
    force = 60.0 + 900.0 * -np.expm1(-np.maximum(x, 0.0) / 0.43)
    sigma, steady, first = linear_fit._start(x, force, None)
    assert sigma == pytest.approx(0.43, rel=0.2)
    assert (steady, first) == (pytest.approx(960.0, rel=0.05), pytest.approx(60.0, abs=25.0))
    fixed = linear_fit._start(x, force, 60.0)
    assert fixed[:2] == pytest.approx([sigma, 960.0], rel=0.05)


def test_the_transient_ends_after_the_steepest_place():
    x = np.arange(0.0, 3.0, 0.001)
    late = np.where(x < 0.5, 0.0, 1000.0 * -np.expm1(-(x - 0.5) / 0.4))
    assert transient_end(x, late, 1000.0) == pytest.approx(0.5 + 0.4 * np.log(50.0), abs=0.003)
    assert transient_end(x, late, 1e-12) == x[-1] == transient_end(x, late, np.nan)
    assert (
        transient_end(x[:2], late[:2], 10.0) == x[1] and transient_end(-1.0 - x, late, 1.0) == 0.0
    )
    assert transient_end(x, 400.0 * x, 1000.0) == x[-1]


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
    assert not means.has_mean(runs, "fy")
    lateral = [replace(r, alpha=0.02, fy=r.fx) for r in runs]
    assert means.has_mean(lateral, "fy")
    assert means.asymptotes(lateral, "fy") == pytest.approx([1640.0, 1800.0, 1960.0], rel=2e-3)
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
    uneven[2] = replace(uneven[2], kappa=0.03)
    one, two = means.balanced(uneven)
    assert (one.start, two.start) == (1, 2) and two is uneven[1]
    np.testing.assert_array_equal(one.distance, long[(long >= short[0]) & (long <= short[-1])])
    np.testing.assert_allclose(one.fx, 0.5 * np.interp(one.distance, X, uneven[0].fx))
    assert one.kappa == 0.025
    even = [run(0.02, 1), run(0.02, 2)]
    assert means.balanced(even) == even


def test_inputs_of_the_model_from_a_run():
    alpha = 0.1
    bare = run(0.02, alpha=alpha, gamma=0.03, distance=X + 0.01)
    x = np.array([0.1, 0.4, 3.0])
    found = bare.inputs_at(x, -5.0, 7.0)
    travel = np.array([0.1, 0.3, 2.6])
    np.testing.assert_allclose(found.travel[0], travel * np.cos(alpha))
    np.testing.assert_allclose(found.slip_y[0], travel * np.sin(alpha))
    np.testing.assert_allclose(found.dt[0], travel / 0.03)
    # beyond the end of the record the slip goes on
    assert found.slip_x.sum() == pytest.approx(0.02 * 3.0, rel=0.01)
    assert (found.start_fx[0], found.start_fy[0]) == (-5.0, 7.0)
    assert (found.alpha[0, 1], found.gamma[0, 2], found.pressure[0, 0]) == (alpha, 0.03, 250e3)
    assert bare.inputs(0.01).shape[1] == pytest.approx(251, abs=1)
    with pytest.raises(FlatplankError, match="pressure not said"):
        replace(bare, pressure=np.nan).inputs_at(x)
    fz = np.where(X < 0.0, 9e3, 3000.0)
    assert run(fz=fz).mean_load == 3000.0
    slip = 0.02 * np.cos(alpha) * X + np.where(X < 0.02, 0.3, 0.0)
    assert actual_slip(X, slip, alpha) == pytest.approx(0.02)
    # a saw of 0.1 mm is smoothed away
    saw = 1e-4 * (np.arange(len(X)) % 10) / 10.0
    rough = run(0.02, slip=0.02 * np.maximum(X, 0.0) + saw)
    steps = rough.inputs_at(X[X > 0.3]).slip_x[0][1:]
    assert np.ptp(steps) < 0.2e-5
    runs = [run(0.02, name="b"), run(-0.01, name="a"), run(0.02, name="c")]
    assert [[r.name for r in g] for g in by_level(runs).values()] == [["a"], ["b", "c"]]
    assert list(by_condition(runs)) == ["one"]


def test_cells_of_a_carcass_fit_grow_to_their_limits():
    edges = carcass_problem._cells(2500, 0.001)
    width = np.diff(edges)
    assert edges[0] == 0 and 2480 <= edges[-1] <= 2500
    assert width[0] == 1 and width.max() == 20
    inner = edges[1:] < 800
    assert width[inner].max() == 8 and np.all(np.diff(width[width < 8][:8]) >= -1)
    np.testing.assert_allclose(
        np.cumsum(0.001 * 1.06 ** np.arange(20))[-1], 1e-3 * edges[20], atol=2e-3
    )
    sums = carcass_problem._cell_sums(np.arange(10.0), np.array([0, 2, 5, 9]))
    assert sums.tolist() == [1.0, 9.0, 26.0]


def test_data_of_a_carcass_fit():
    """Means and summed weights of cells; 100 in the transient part, 1 after it."""
    runs = [run(0.02), run(0.02, distance=X[X < 1.6])]
    fits = [r.linear() for r in runs]
    x, force, weight, settled = carcass_problem._measured(runs, fits)
    np.testing.assert_allclose(force[0], np.interp(x, X, runs[0].fx), atol=2.0)
    end = fits[0].transient_end
    early, late = x < end - 0.05, x > end + 0.05
    assert np.sum(weight[0, early] ** 2) == pytest.approx(100.0 * 1e3 * (end - 0.05), rel=0.03)
    assert np.sum(weight[0, late] ** 2) == pytest.approx(1e3 * (X[-1] - end - 0.05), rel=0.03)
    assert np.sum(weight[0] ** 2) == pytest.approx(1e3 * (99.0 * end + X[-1]), rel=0.01)
    assert not weight[1, x > 1.61].any() and not force[1, x > 1.61].any()
    # settled from the end of the transient part, or from 70 % of the record on
    first = x[np.flatnonzero(settled[0])[0]]
    assert first == pytest.approx(min(end, 0.7 * X[-1]), abs=0.03)
    assert x[np.flatnonzero(settled[1])[0]] == pytest.approx(0.7 * 1.6, abs=0.03)
    assert settled[0].sum() == pytest.approx(1e3 * (X[-1] - min(end, 0.7 * X[-1])), rel=0.02)


@pytest.mark.parametrize("begin", [0.7, 1.4])
def test_stiffness_and_curve_are_solved_from_both_sides(begin):
    still = Truth(noise=1e-6, gain_scatter=0.0, slip_scatter=0.0, carcass_scatter=0.0)
    runs = simulate_runs(still, np.random.default_rng(0))
    problem = carcass_problem.carcass_problem(runs)
    state, done = carcass_joint.solve_jointly(problem, begin * still.c_cx, (2e4, 5e6))
    assert done and state.c_cx == pytest.approx(still.c_cx, rel=5e-3)
    assert np.abs(state.scores()[1:]).max() < 1.0
    # some of the runs alone say the same, to first order
    assert state.stiffness_of(problem.level < 3) == pytest.approx(still.c_cx, rel=0.02)
    # and each error's pull on c_cx is what the equations say
    gradient = np.zeros(len(state.matrix))
    gradient[0] = 1.0
    pull = state.sensitivity(gradient)
    moved = replace(state, error=state.error + 1e-3 * numbers(12, *pull.shape))
    change = -np.linalg.solve(state.matrix, moved.scores() - state.scores())[0]
    assert change == pytest.approx(np.sum(pull * (moved.error - state.error)), rel=1e-6)
    first, kept = carcass_joint.solve_jointly(problem, 2e5, (2e4, 5e6), refine=False)
    assert kept and first.c_cx == 2e5


def test_noise_of_a_quantity_is_summed_over_cells():
    """A mean over n samples of white noise: s/sqrt(n), whatever the cells."""
    centres = np.cumsum(np.linspace(0.002, 0.02, 150))
    one = run(distance=np.arange(0.0005, centres[-1], 0.001))
    count = len(one.distance)
    cells = np.gradient(centres)
    state = SimpleNamespace(problem=SimpleNamespace(distance=centres))
    sensitivity = (cells / 0.001 / count)[None]
    found = carcass_joint.noise_error([one], state, sensitivity, ARNoise((), 2.0, 9))
    assert found == pytest.approx(2.0 / np.sqrt(count), rel=0.02)
    two = carcass_joint.noise_error([one] * 2, state, np.vstack([sensitivity] * 2),
                                    ARNoise((), 2.0, 9))  # fmt: skip
    assert two == pytest.approx(found * 2.0**0.5)


def test_directions_that_rows_leave_open():
    jac = np.array([[4.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    (worst, other) = info.undetermined(jac, np.array([1.0, 1.5, 1.0]))
    np.testing.assert_allclose(np.abs(worst), [0.0, 0.0, 1.0], atol=1e-9)
    np.testing.assert_allclose(np.abs(other), [0.0, 1.0, 0.0], atol=1e-9)
    assert len(info.undetermined(jac, np.array([1.0, 2.5, 1.0]))) == 1
    assert len(info.undetermined(np.zeros((0, 3)), np.ones(3))) == 3
    assert info.members(np.array([1.0, -0.3, 0.2, -0.26])).tolist() == [0, 1, 3]
    # two open directions in few parameters each
    turn = np.array([[0.6, 0.6, 0.5, 0.0], [0.6, 0.6, -0.5, 0.1]])
    sparse = info._sparse(list(turn))
    assert min(np.count_nonzero(np.abs(row) > 0.2) for row in sparse) == 1
    space = np.linalg.svd(turn)[2][:2]
    for row in sparse:
        assert np.linalg.norm(space @ row) == pytest.approx(1.0) == np.linalg.norm(row)
    weak = info._weakest(
        np.array([[1.0, 1.0, 0.0], [0.0, 0.0, 3.0]]), np.ones(3), np.array([0, 1])
    )
    np.testing.assert_allclose(np.abs(weak), [0.5**0.5, 0.5**0.5, 0.0], atol=1e-9)
    assert weak[0] * weak[1] < 0.0
    pairs = np.array([[1.0, -0.985, 0.99], [-0.985, 1.0, 0.97], [0.99, 0.97, 1.0]])
    assert info._pairs(pairs, np.zeros(3, bool)) == [(0, 1), (0, 2)]
    assert info._pairs(pairs, np.array([False, True, False])) == [(0, 2)]


def test_the_run_that_tells_most_is_proposed_when_it_tells_enough():
    jac, sizes = np.array([[1.0, 0.0]]), np.array([1.0, 2.0])
    offers = [info.Candidate(t, "h", np.array([[a, b]])) for t, a, b in
              (("a", 0.0, 0.3), ("b", 0.0, 1.0), ("c", 2.0, 0.2))]  # fmt: skip
    open_one = np.array([0.0, 1.0])
    assert info._best_run(open_one, sizes, offers, jac).text == "b"
    assert info._best_run(open_one, sizes, offers[:1], jac) is None
    known = np.array([1.0, 0.0])
    assert info._best_run(known, sizes, offers, jac) is None  # 4 < 8 times what is known
    assert info._best_run(0.5 * known, sizes, [replace(offers[2], rows=3.0 * offers[2].rows)],
                          jac).text == "c"  # fmt: skip
    assert info._best_run(known, sizes, [], jac) is None
    # eight times what is known cuts the error to a third
    for slip, told in ((8.1**0.5, True), (7.9**0.5, False)):
        one = info.Candidate("d", "h", np.array([[slip, 0.0]]))
        assert (info._best_run(known, sizes, [one], jac) is not None) is told


def test_wide_errors_and_strong_pairs_are_said():
    names, sizes = ("A", "B", "C", "D"), np.ones(4)
    jac = 10.0 * np.eye(4)
    correlation = np.eye(4)
    correlation[0, 1] = correlation[1, 0] = 0.99
    errors = np.array([0.1, 0.1, 1.1, 1.2])
    found, mask = info.confusions(names, jac, sizes, correlation, list, errors)
    assert mask.tolist() == [False, False, True, True]
    assert [c.names for c in found] == [("C", "D"), ("A", "B")]
    assert found[0].statement == "C and D are not determined by these data"
    assert found[1].statement == "A and B are hard to tell apart with these data"
    assert found[1].correlation == 0.99 and "no single setting" in found[1].remedy
    assert info.confusions(names, jac, sizes, np.eye(4), list)[0] == []
    one = Confusion(("A",), 1.0, "A is not determined by 2 loads", "x")
    other = Confusion(("B",), 1.0, "B is not determined by 2 slips", "y")
    third = Confusion(("C",), 1.0, "C is not determined by 2 loads", "z")
    merged = info._merged([one, other, third, replace(one, names=("D",), remedy="z")])
    assert [(c.names, c.remedy) for c in merged] == [(("A", "C", "D"), "z"), (("B",), "y")]


def test_steps_of_a_bounded_search():
    """Of the trials those that differ; a parameter at its wall that pulls outwards is held."""
    trials = np.array([[1.0, 0.0], [0.99, 0.0], [0.9, 0.0], [0.0, 0.5]])
    kept = least_squares._different(trials, np.zeros(2), np.ones(2))
    assert kept.tolist() == [0, 2, 3]
    x, low, high = np.array([0.0, 1.0, 0.5]), np.zeros(3), np.ones(3)
    jac, r = np.eye(3)[:, [0, 1, 2]], np.array([1.0, -1.0, 1.0])
    assert least_squares._free(x, r, jac, low, high).tolist() == [2]
    assert least_squares._free(x, -r, jac, low, high).tolist() == [0, 1, 2]
    assert least_squares._free(x, -r, jac * [1, 0, 1], low, high).tolist() == [0, 2]
    scale = np.ones(3)
    assert not least_squares._is_stationary(x, r, jac, low, high, scale)
    assert least_squares._is_stationary(x, r * [1, 1, 0], jac, low, high, scale)
    lanes, width = least_squares._stencil(x, low, high, np.array([1.0, 2.0, 0.1]))
    np.testing.assert_allclose(lanes[1:4].diagonal() - x, [1e-4, 0.0, 5e-5])
    np.testing.assert_allclose(x - lanes[4:].diagonal(), [0.0, 2e-4, 5e-5])
    np.testing.assert_allclose(width, [1e-4, 2e-4, 1e-4])
    residuals, jacobian = least_squares.linearise(
        lambda z: np.column_stack([z[:, 0] ** 2, z[:, 1] * z[:, 2]]), x, low, high, scale
    )
    np.testing.assert_allclose(residuals, [0.0, 0.5])
    np.testing.assert_allclose(jacobian, [[0.0, 0.0, 0.0], [0.0, 0.5, 1.0]], atol=1e-3)


def test_intervals_and_json_of_estimates():
    one = Estimate("c", 10.0, "N", 2.0, dof=4.0)
    reach = student.ppf(0.95, 4.0) * 2.0
    assert one.interval() == pytest.approx((10.0 - reach, 10.0 + reach))
    assert one.interval(0.5)[1] == pytest.approx(10.0 + student.ppf(0.75, 4.0) * 2.0)
    assert replace(one, dof=0.1).interval()[1] == pytest.approx(
        10.0 + student.ppf(0.95, 1.0) * 2.0
    )
    assert replace(one, determined=False).interval() == (-math.inf, math.inf)
    assert replace(one, std_error=math.nan).interval() == (-math.inf, math.inf)
    assert (one.times(-2.0).value, one.times(3.0).std_error) == (-20.0, 6.0)
    assert one.with_note("a").with_note("b").note == "a; b" and one.with_note("").note == ""
    assert one.to_json()["interval90"] == pytest.approx([10.0 - reach, 10.0 + reach])
    assert Fit("m", (one,), np.eye(1)).values == {"c": 10.0}
    mixed = {1: (np.float64(2.0), np.int64(3)), "b": np.array([np.inf]), "c": np.bool_(True)}
    assert to_plain(mixed) == {"1": [2.0, 3], "b": [None], "c": True}
    assert repeats.plain_condition("3000 N") == "3000 N"


def lateral_table(alpha_deg: float, kappa: float = 0.01, step: float = 1.5, end: float = 3.0):
    """Rest, then a run at a slip angle with a slip step."""
    x = np.concatenate([np.zeros(40), np.arange(0.0, end, 0.001)])
    after = x > step
    columns = {
        "plank_position": x + 0.2,
        "fy": -800.0 * -np.expm1(-x / 0.3),
        "fx": 25.0 + 700.0 * after + 900.0 * ((x > step + 0.3) & (x < end - 0.31)),
        "mz": 12.0 * (x > 0.5),
        "fz": np.full_like(x, 3700.0),
    }
    info_ = RunInfo("a.parquet", kappa=kappa, fz=3700.0, pressure=2.4, alpha_deg=alpha_deg,
                    gamma_deg=1.5, start=3, step_position=0.2 + step)  # fmt: skip
    return MeasurementTable(columns, info_)


def test_a_start_at_a_slip_angle_is_a_step_in_side_slip():
    found = lateral_run(lateral_table(3.0))
    assert found.kappa == pytest.approx(math.tan(math.radians(3.0))) and found.level == 3.0
    assert found.distance[0] == pytest.approx(0.0, abs=0.003)
    assert found.distance[-1] == pytest.approx(1.5 * math.cos(math.radians(3.0)), abs=0.004)
    middle = np.searchsorted(found.distance, 0.6)
    x = found.distance[middle] / math.cos(math.radians(3.0))
    assert found.fx[middle] == pytest.approx(800.0 * -math.expm1(-x / 0.3), rel=0.01)
    assert (found.fy[middle], found.mz[middle]) == pytest.approx((25.0, 12.0))
    np.testing.assert_allclose(found.slip, found.kappa * found.distance)
    assert (found.pressure, found.start) == (2.4e5, 3) and found.alpha == 0.0
    assert found.gamma == pytest.approx(math.radians(1.5))
    # last 0.3 m less 0.3 m before the step, over the slip
    assert found.slip_stiffness == pytest.approx(700.0 / 0.01)
    for changed in (lateral_table(3.0, kappa=0.03), lateral_table(3.0, end=2.05),
                    lateral_table(3.0, kappa=0.0)):  # fmt: skip
        assert math.isnan(lateral_run(changed).slip_stiffness)
    assert lateral_run(lateral_table(3.0, kappa=0.0)).distance[-1] > 2.9
    with pytest.raises(FlatplankError, match="does not move"):
        still = lateral_table(3.0)
        columns = {k: v for k, v in still.columns.items() if k != "plank_position"}
        lateral_run(MeasurementTable({**columns, "plank_position": 0.0 * still["fx"]}, still.info))


def cornering(zero: float, ply: float, level: float, start: int, slope: float) -> StepRun:
    """Steady -Fy, Mz and Fx at an angle of a tire that is odd in the angle it feels."""
    alpha = math.radians(level)
    felt = math.tan(alpha + zero + ply)
    side = 3700.0 * 0.95 * math.sin(1.4 * math.atan(12.0 * felt))
    drag = slope * (math.cos(alpha) / math.cos(alpha + zero) - 1.0) if slope == slope else 0.0
    x = np.arange(0.001, 1.5, 0.002)
    own = 1.0 * (x > 1.1)  # the last 0.3 m
    columns = {"mz": -0.03 * side * math.cos(1.15 * math.atan(8.0 * felt)) * own, "fy": drag * own}
    return run(math.tan(alpha), start, fx=side * own, distance=x, **columns,
               slip_stiffness=slope)  # fmt: skip


@pytest.mark.parametrize(("zero", "ply"), [(-0.015, 0.003), (0.01, -0.004)])
def test_steering_zero_and_ply_steer_of_known_curves(zero, ply):
    def runs(slope):
        return [
            replace(cornering(zero, ply, level, start, slope), level=level)
            for level in (-8.0, -3.0, -1.0, 1.0, 3.0, 8.0) for start in (1, 2)
        ]  # fmt: skip

    found = steering_zero(runs(6e4))
    assert math.radians(found.zero.value) == pytest.approx(zero, abs=8e-4)
    assert math.radians(found.ply.value) == pytest.approx(ply, abs=8e-4)
    assert found.shift == pytest.approx(zero + ply, abs=2e-4) and found.ply.determined
    moved = found.corrected(replace(run(0.05), level=2.0))
    assert moved.kappa == pytest.approx(math.tan(math.radians(2.0) + found.shift))
    np.testing.assert_allclose(moved.slip, moved.kappa * moved.distance)
    both = steering_zero(runs(math.nan))
    assert math.radians(both.zero.value) == pytest.approx(zero + ply, abs=4e-4)
    assert not both.ply.determined and "with ply steer" in both.zero.note
    assert steering_zero(runs(6e4)[:8]) is None
    # two angles and straight ahead do not tell how the curve bends: e stays where it is
    few = [r for r in runs(6e4) if abs(r.level) < 4.0]
    straight = replace(cornering(zero, ply, 0.0, 1, 6e4), level=0.0)
    assert _solved([*few, straight])[0][NAMES.index("e")] == 0.0
    assert _solved(runs(6e4))[0][NAMES.index("e")] != 0.0
    assert lack_of_mirrors([-1.0, 1.0, 3.0]) and not lack_of_mirrors([-1, 1, 3, -3, 0])
