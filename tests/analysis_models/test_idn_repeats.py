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
