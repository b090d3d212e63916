# SPDX-License-Identifier: Apache-2.0
"""Linear and nonlinear fits: known truth back, bounds, and what a fit says it cannot know."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from flatplank_analysis.identify.campaign import FitFile, fit_campaign
from flatplank_analysis.identify.carcass import brush_bias, fit_carcass
from flatplank_analysis.identify.lateral import fit_lateral_carcass, lateral_run
from flatplank_analysis.identify.linear import linear_run
from flatplank_analysis.identify.repeats import asymptotes, fit_linear, with_equal_starts
from flatplank_analysis.identify.runs import StepRun, step_run
from flatplank_analysis.identify.steady_curve import (
    SteadyCurve,
    curve_law,
    slope_lack,
    slope_weights,
)
from flatplank_analysis.models.base import TOYO, slip_inputs
from flatplank_analysis.models.nonlinear import NonlinearX, table_law
from flatplank_data.errors import FlatplankError
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_validation.fits.campaigns import Truth, simulate_linear, simulate_runs

QUIET = Truth(noise=1e-6, gain_scatter=0.0, slip_scatter=0.0, carcass_scatter=0.0)
X = np.arange(-0.1, 2.6, 0.001)


def response(sigma: float, steady: float, start: float = 0.0, reach: float = 2.6) -> np.ndarray:
    x = X[reach > X]
    return start + (steady - start) * -np.expm1(-np.maximum(x, 0.0) / sigma)


def quiet_runs() -> list[StepRun]:
    return simulate_runs(QUIET, np.random.default_rng(0))


@pytest.mark.parametrize(("sigma", "kappa", "start"), [(0.45, 0.01, -140.0), (0.12, -0.1, 60.0)])
def test_linear_run_finds_the_response(sigma: float, kappa: float, start: float) -> None:
    found = linear_run(X, response(sigma, 9e4 * kappa, start), kappa)
    assert found.sigma.value == pytest.approx(sigma, rel=3e-3)
    assert found.slip_stiffness.value == pytest.approx(9e4, rel=1e-3)
    assert found.start_force.value == pytest.approx(start, abs=2.0)
    assert found.settled
    assert found.confusions == ()
    np.testing.assert_allclose(
        found.response(X), response(sigma, 9e4 * kappa, start), atol=0.02 * 9e4 * abs(kappa)
    )


def test_linear_run_in_y_over_the_slip_angle() -> None:
    found = linear_run(X, response(0.5, -5e4 * 0.03), 0.03)
    assert found.steady_force.value == pytest.approx(-1500.0, rel=1e-3)
    assert found.slip_stiffness.value == pytest.approx(-5e4, rel=1e-3)
    assert found.slip_stiffness.at_bound == ""


def test_linear_run_without_slip_is_a_mean() -> None:
    found = linear_run(X, np.full_like(X, 33.0), 0.0)
    assert found.steady_force.value == pytest.approx(33.0)
    assert not found.sigma.determined
    assert found.sigma.interval() == (-math.inf, math.inf)
    assert found.to_json()["sigma"]["value"] is None
    np.testing.assert_allclose(found.response(X), 33.0)


def test_linear_run_that_ends_early_says_so() -> None:
    x = X[X < 0.5]
    rng = np.random.default_rng(1)
    force = response(0.6, 1800.0, reach=0.5) + 8.0 * rng.standard_normal(len(x))
    found = linear_run(x, force, 0.02)
    assert not found.settled
    assert found.correlation > 0.9
    assert "step earlier" in found.confusions[0].remedy
    whole = linear_run(X, response(0.6, 1800.0) + 8.0 * rng.standard_normal(len(X)), 0.02)
    assert found.sigma.std_error > 10.0 * whole.sigma.std_error


def test_linear_error_counts_correlated_samples_as_few() -> None:
    rng = np.random.default_rng(2)
    truth = {0.02: (0.4, 9e4)}
    white = simulate_linear(truth, rng, noise=12.0, scatter=0.0)[0]
    slow = linear_run(white.distance, white.fx, 0.02)
    mixed = white.fx.copy()
    after = white.distance > 0
    mixed[after] = slow.response(white.distance[after]) + rng.permutation(slow.residual[after])
    fast = linear_run(white.distance, mixed, 0.02)
    assert slow.sigma.std_error > 3.0 * fast.sigma.std_error


def test_linear_condition_knows_its_scatter() -> None:
    truth = {-0.02: (0.4, 9e4), 0.02: (0.4, 9e4), 0.01: (0.45, 9.5e4)}
    runs = simulate_linear(truth, np.random.default_rng(3), starts=6, noise=3.0, scatter=0.03)
    found = fit_linear(runs)
    assert found.scatter["sigma"] == pytest.approx(0.03, rel=0.5)
    level = {lv.level: lv for lv in found.levels}[0.02]
    assert level.repeats == 6
    assert level.sigma.std_error == pytest.approx(0.4 * 0.03 / math.sqrt(6), rel=0.6)
    json.dumps(found.to_json())


def test_linear_condition_statement_changes_with_the_starts() -> None:
    runs = simulate_linear({-0.02: (0.4, 9e4), 0.02: (0.4, 9e4)}, np.random.default_rng(4))
    assert fit_linear(runs).confusions == ()
    one = fit_linear([r for r in runs if r.start == 1])
    assert "no slip level was repeated" in one.confusions[0].statement
    assert "another start angle" in one.confusions[0].remedy
    same = fit_linear([replace(r, start=1) for r in runs])
    assert "one start angle only" in same.confusions[0].statement
    assert "a start angle of 120 deg" in same.confusions[0].remedy
    assert one.confusions[0].correlation == 1.0 == same.confusions[0].correlation
    assert one.confusions[0].names == ("run-to-run scatter", "noise")
    assert same.confusions[0].names == ("steady_force", "once-per-turn error")


def test_carcass_of_quiet_runs() -> None:
    found = fit_carcass(quiet_runs())
    truth = QUIET
    slope = truth.stiffness()
    a = float(TOYO.half_length(truth.fz, truth.pressure))
    assert found.converged
    assert found.c_cx.value == pytest.approx(truth.c_cx, rel=3e-3)
    assert found.slip_stiffness.value == pytest.approx(slope, rel=2e-3)
    assert found.sigma_x.value == pytest.approx(slope / truth.c_cx + a, rel=5e-3)
    assert max(found.rmse.values()) < 3.0
    assert found.confusions == ()
    json.dumps(found.to_json())


def test_carcass_interval_follows_the_scatter() -> None:
    calm = fit_carcass(simulate_runs(Truth(noise=2.0), np.random.default_rng(5)))
    wild = fit_carcass(
        simulate_runs(Truth(noise=2.0, carcass_scatter=0.1), np.random.default_rng(5))
    )
    assert wild.c_cx.std_error > 2.0 * calm.c_cx.std_error
    low, high = wild.c_cx.interval(0.99)
    assert low < 2.4e5 < high


def test_carcass_statement_changes_with_the_starts() -> None:
    runs = simulate_runs(Truth(), np.random.default_rng(6))
    one = fit_carcass([r for r in runs if r.start == 2])
    assert "one start angle only" in one.confusions[0].statement
    assert one.c_cx.std_error > 0.0
    two = fit_carcass([r for r in runs if r.start != 2])
    assert two.confusions == ()


def test_carcass_on_a_bound_is_not_determined() -> None:
    found = fit_carcass(quiet_runs(), bounds=(3e5, 4e5))
    assert found.c_cx.at_bound == "lower"
    assert not found.c_cx.determined
    assert "rests on its lower bound" in found.confusions[-1].statement


def test_carcass_with_runs_of_different_length() -> None:
    runs = quiet_runs()
    keep = runs[3].distance < 1.9
    names = ("distance", "fx", "fy", "mz", "fz", "slip")
    runs[3] = replace(runs[3], **{n: getattr(runs[3], n)[keep] for n in names})
    assert fit_carcass(runs).c_cx.value == pytest.approx(QUIET.c_cx, rel=4e-3)


def test_carcass_needs_slip_levels() -> None:
    with pytest.raises(FlatplankError, match="three or more slip levels"):
        fit_carcass(simulate_runs(QUIET, np.random.default_rng(0), slips=(0.0, 0.02)))


def _table(kappa: float, step: float = 1.5) -> MeasurementTable:
    x = np.linspace(0.0, 4.1, 4000)
    after = np.maximum(x - step, 0.0)
    columns = {
        "plank_position": x,
        "wheel_angle": (x + kappa * after) / 0.31,
        "fx": 9e4 * kappa * -np.expm1(-after / 0.45),
        "fz": np.full_like(x, 3700.0),
    }
    info = RunRecord("a.parquet", kappa=kappa, fz=3700.0, pressure=2.5, step_position=1.5,
                   effective_rolling_radius=0.31)  # fmt: skip
    return MeasurementTable(columns, info)


def test_step_run_from_a_table() -> None:
    run = step_run(_table(0.0213))
    assert run.kappa == pytest.approx(0.0213, rel=1e-3)
    assert run.level == 0.0213
    assert run.pressure == 2.5e5
    assert run.mean_load == pytest.approx(3700.0)
    assert run.linear().sigma.value == pytest.approx(0.45, rel=3e-3)
    with pytest.raises(FlatplankError, match="no step_position"):
        table = _table(0.02)
        step_run(MeasurementTable(table.columns, replace(table.info, step_position=math.nan)))
    with pytest.raises(FlatplankError, match="ends before the step"):
        step_run(MeasurementTable(table.columns, replace(table.info, step_position=4.099)))


def _start_at_angle(alpha_deg: float, number: int) -> MeasurementTable:
    """A tire that rolls from rest at a slip angle, by the nonlinear model in y."""
    x = np.linspace(0.0, 2.0, 2001)
    tangent = math.tan(math.radians(alpha_deg))
    slips = np.tan(np.radians(np.linspace(-9.0, 9.0, 19)))
    law = table_law(slips, 3300.0 * np.sin(1.4 * np.arctan(13.0 * slips)))
    model = NonlinearX(lambda _: law, friction=0.97, longitudinal=False)
    force = -model.simulate(np.array([[1.2e5]]), slip_inputs(x, tangent, 3700.0))[0, 0]
    rest = np.zeros(50)
    columns = {
        "plank_position": np.concatenate([rest, x]),
        "fy": np.concatenate([rest, force]) + 0.5 * np.sin(np.arange(2051) + number),
        "fz": np.full(2051, 3700.0),
    }
    info = RunRecord(f"y{number}.parquet", fz=3700.0, pressure=2.5, alpha_deg=alpha_deg,
                   start=1 + number % 3, step_position=1.9)  # fmt: skip
    assert tangent * force[-1] <= 0.0
    return MeasurementTable(columns, info)


def test_lateral_carcass_and_relaxation_from_the_start_of_rolling() -> None:
    angles = (-8.0, -4.0, -2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 4.0, 8.0)
    runs = [lateral_run(_start_at_angle(a, i)) for a in angles for i in range(3)]
    found = fit_lateral_carcass(runs)
    assert found.c_cx.name == "c_cy"
    assert found.c_cx.value == pytest.approx(1.2e5, rel=0.02)
    stiffness = 3300.0 * 1.4 * 13.0
    assert found.slip_stiffness.value == pytest.approx(stiffness, rel=0.03)
    assert found.slip_stiffness.unit == "N/rad"
    linear = {lv.level: lv for lv in fit_linear(runs).levels}
    sigma = stiffness / 1.2e5 + float(TOYO.half_length(3700.0, 250e3))
    assert linear[1.0].sigma.value == pytest.approx(sigma, rel=0.12)


def test_campaign_fits_go_on_past_a_bad_condition() -> None:
    good = quiet_runs()
    bad = simulate_runs(Truth(fz=2000.0, noise=1.0), np.random.default_rng(1), slips=(0.0, 0.02))
    found = fit_campaign([*good, *bad], FitFile("nonlinear"))
    assert len(found.fits) == 1
    assert "three or more slip levels" in found.problems[0]
    json.dumps(found.to_json())
    assert len(fit_campaign([*good, *bad], FitFile("linear")).fits) == 2
    words = "no model cubic; choose one of linear, nonlinear, lateral, mf"
    with pytest.raises(FlatplankError, match=words):
        fit_campaign(good, FitFile("cubic"))
    with pytest.raises(FlatplankError, match="three or more slip levels"):
        fit_campaign(bad, FitFile("nonlinear"))


def brush_curve(slips: np.ndarray, q: float = 8.0) -> np.ndarray:
    """Steady force of a brush with parabolic pressure, 95 kN, all sliding beyond 1/q."""
    part = np.minimum(q * np.abs(slips), 1.0)
    return np.sign(slips) * 9.5e4 / (3.0 * q) * (1.0 - (1.0 - part) ** 3)


@pytest.mark.parametrize("q", [0.0001, 8.0, 23.0, 40.0])
def test_slope_at_zero_of_a_curve_that_bends_from_the_start(q: float) -> None:
    slips = np.array([-0.05, -0.02, -0.01, 0.0, 0.01, 0.02, 0.05])
    force = brush_curve(slips, q)
    assert slope_weights(slips, force) @ force == pytest.approx(9.5e4)
    law = curve_law(slips, force)
    secant = brush_curve(np.array([0.005]), q)[0] / 0.005
    assert law.stiffness().item() == pytest.approx(secant, rel=0.01)
    np.testing.assert_allclose(law.force(slips[None])[0][0], force, atol=2.0)
    two = curve_law(slips, np.vstack([force, 2.0 * force]))
    np.testing.assert_allclose(two.values[1], 2.0 * two.values[0], rtol=1e-12, atol=1e-9)
    # With one pair of levels only the slope between them is known.
    pair, own = slips[2:5], force[2:5]
    assert slope_weights(pair, own) @ own == pytest.approx(own[2] / 0.01)
    assert slope_lack(slips, force) == ""
    assert slope_lack(pair, own).startswith("a second pair of slips")


def test_weights_of_the_slope_are_its_derivative() -> None:
    slips = np.array([-0.05, -0.021, -0.01, 0.001, 0.011, 0.02, 0.05])
    force = brush_curve(slips, 23.0) + 30.0

    def slope(values: np.ndarray) -> float:
        return float(slope_weights(slips, values) @ values)

    numeric = [(slope(force + d) - slope(force - d)) / 2.0 for d in np.eye(len(slips))]
    np.testing.assert_allclose(slope_weights(slips, force), numeric, atol=1e-3)


def test_slips_at_which_all_slides_do_not_tell_the_slope() -> None:
    slips = np.array([-0.05, -0.02, -0.01, 0.0, 0.01, 0.02, 0.05])
    assert slope_lack(slips, brush_curve(slips, 49.0)) == ""
    assert "at 2 % the whole contact slides" in slope_lack(slips, brush_curve(slips, 70.0))


def test_error_of_the_slope_holds_the_form_of_the_curve() -> None:
    """A third of what the last term of the brush moves; nothing where the curve is straight."""
    slips = np.array([-0.05, -0.02, -0.01, 0.0, 0.01, 0.02, 0.05])
    force = brush_curve(slips, 23.0)
    near, far = force[4] / 0.01, force[5] / 0.02
    curve = SteadyCurve(slips, force, np.zeros(7), np.ones(7))
    assert curve.slope().form == pytest.approx((9.5e4 - (2.0 * near - far)) / 3.0)
    straight = SteadyCurve(slips, 9.5e4 * slips, np.zeros(7), np.ones(7))
    assert straight.slope().form == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("side", [slice(3, None), slice(None, 4)])
def test_slope_at_zero_of_one_sign_of_slip(side: slice) -> None:
    slips = np.array([-0.05, -0.02, -0.01, 0.0, 0.01, 0.02, 0.05])[side]
    force = 40.0 + brush_curve(slips)
    assert slope_weights(slips, force) @ force == pytest.approx(9.5e4)
    assert slope_lack(slips, force) == ""
    np.testing.assert_allclose(curve_law(slips, force).force(slips[None])[0][0], force, atol=2.0)
    three = np.array([0.01, 0.02, 0.05])
    assert slope_lack(three, brush_curve(three)).startswith("a run without slip")


def test_carcass_of_one_pair_of_slips_says_what_it_does_not_know() -> None:
    runs = simulate_runs(Truth(), np.random.default_rng(5), slips=(-0.05, 0.0, 0.05))
    found = fit_carcass(runs)
    for estimate in (found.c_cx, found.slip_stiffness, found.sigma_x):
        assert not estimate.determined and "a second pair of slips" in estimate.note
    said = next(c for c in found.confusions if "slip_stiffness" in c.names)
    assert said.statement.startswith("3 slip levels") and said.remedy.startswith("add a second")


def test_model_bias_on_bristles_is_stated() -> None:
    bias = brush_bias(2.56e5, 9.5e4, 0.0708)
    assert bias["c_cx"] == pytest.approx(0.0636, abs=1e-3)
    assert bias["sigma_x"] == pytest.approx(-0.0511, abs=1e-3)


def test_what_turns_with_the_wheel_cancels_in_the_mean_of_three_starts() -> None:
    """At small slip a single run follows the wave to an absurd relaxation length."""
    truth = {-0.01: (0.5, 9e4), 0.01: (0.5, 9e4)}
    quiet = simulate_linear(truth, np.random.default_rng(8), noise=2.0, scatter=0.0)
    runs = []
    for run in quiet:
        turn = run.distance / 0.311 + 2.0 * math.pi * (run.start - 1) / 3.0
        runs.append(replace(run, fx=run.fx + 250.0 * np.sin(turn)))
    alone = [run.linear().steady_force.value for run in runs if run.level > 0.0]
    assert max(alone) - min(alone) > 300.0
    level = {lv.level: lv for lv in fit_linear(runs).levels}[0.01]
    assert level.sigma.value == pytest.approx(0.5, rel=0.1)
    assert level.sigma.interval()[1] > level.sigma.value + 0.1  # the runs disagree
    assert np.mean(asymptotes([r for r in runs if r.level > 0.0])) == pytest.approx(
        900.0, rel=0.05
    )


def test_a_start_angle_that_was_repeated_more_often_counts_once() -> None:
    truth = {-0.02: (0.4, 9e4), -0.01: (0.4, 9e4), 0.01: (0.4, 9e4), 0.02: (0.4, 9e4)}
    quiet = simulate_linear(truth, np.random.default_rng(9), starts=12, noise=2.0, scatter=0.0)
    runs = []
    for run in quiet:
        start = 1 if run.start > 3 else run.start
        turn = run.distance / 0.311 + 2.0 * math.pi * (start - 1) / 3.0
        runs.append(replace(run, start=start, fx=run.fx + 250.0 * np.sin(turn)))
    assert len(with_equal_starts(runs)) == 12
    level = {lv.level: lv for lv in fit_linear(runs).levels}[0.02]
    assert level.steady_force.value == pytest.approx(1800.0, rel=0.02)
    assert level.steady_force.dof == 2.0
