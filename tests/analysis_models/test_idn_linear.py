# SPDX-License-Identifier: Apache-2.0
"""Linear transient fit of one run against the response that it was made from."""

from __future__ import annotations

import numpy as np
import pytest
from idn_runs import X, numbers

from flatplank_analysis.identify.linear import linear_run, transient_end
from flatplank_analysis.identify.noise import ARNoise


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
    # without samples before the step the thesis takes zero
    zero = linear_run(X[X > 0.0], force[X > 0.0] + 100.0, 0.02)
    assert zero.start_force.fixed and zero.start_force.value == 0.0
    assert zero.slip_stiffness.value == pytest.approx(9.5e4, rel=2e-3)
    # a run of three relaxation lengths has settled
    for reach, settled in ((1.25, True), (1.15, False)):
        short = linear_run(X[reach > X], force[reach > X], 0.02)
        assert short.settled is settled and abs(short.correlation) < 0.95
        said = [c.remedy for c in short.confusions]
        assert said == (
            [] if settled else ["step earlier, so that 1.20 m of travel follow the step"]
        )
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
    known = linear_run(X, truth, 0.02, spacing=0.001, noise=ARNoise((), 20.0, 500))
    assert {known.sigma.dof, known.steady_force.dof, known.start_force.dof} == {497.0}
    given = linear_run(X[X > 0.0], truth[X > 0.0], 0.02, noise=ARNoise((), 20.0, 3))
    assert given.sigma.dof == 2.0 and given.start_force.std_error == 0.0
    assert linear_run(X, truth, 0.0, noise=ARNoise((), 20.0, 2)).steady_force.dof == 2.0
    pairs = np.array([(f.sigma.value, f.steady_force.value) for f in found])
    wanted = np.corrcoef(pairs.T)[0, 1]
    assert np.median([f.correlation for f in found]) == pytest.approx(wanted, abs=0.3)


def test_the_transient_ends_after_the_steepest_place():
    x = np.arange(0.0, 3.0, 0.001)
    late = np.where(x < 0.5, 0.0, 1000.0 * -np.expm1(-(x - 0.5) / 0.4))
    assert transient_end(x, late, 1000.0) == pytest.approx(0.5 + 0.4 * np.log(50.0), abs=0.003)
    assert transient_end(x, late, 1e-12) == x[-1] == transient_end(x, late, np.nan)
    assert (
        transient_end(x[:2], late[:2], 10.0) == x[1] and transient_end(-1.0 - x, late, 1.0) == 0.0
    )
    assert transient_end(x, 400.0 * x, 1000.0) == x[-1]
