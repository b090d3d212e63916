# SPDX-License-Identifier: Apache-2.0
"""The whitened fit, the dispersions and the noise that decisions stand on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from ball import TIME, Ball, Drag, Wind, throw
from scipy.signal import lfilter
from scipy.stats import f as f_distribution

from flatplank_analysis.discovery.dispersion import (
    MOST_FREEDOM,
    TypicalDispersion,
    typical_dispersion,
)
from flatplank_analysis.discovery.fit import Fitter, Term, fit_whitened
from flatplank_analysis.discovery.noise import fit_noise


def _plain(ball: Ball, terms=()):
    fitter = Fitter(ball, np.ones((1, 1, 1)))
    return fitter, fitter.fit(np.array([9.0, 0.0]), terms)


def _metric(weights: np.ndarray):
    """One weight per run."""
    return lambda values: values * np.sqrt(weights)[:, None]


def test_settles_where_the_weighted_sum_is_smallest():
    ball = throw(7, 0.02)
    fitter, fit = _plain(ball, (Term(Drag, np.array([0.005])),))
    weights = np.geomspace(1.0, 1e4, ball.runs.runs)
    found = fit_whitened(_metric(weights), fitter, fit)

    def chi2(base, k):
        one = fit.parameter_set()
        at = replace(one, base=np.array(base), effects=((Drag, np.array([k])),))
        e = ball.runs.measured - ball.predict([at])[0]
        return float(np.sum(weights[None, :, None] * e**2))

    base, k = found.fit.base, found.fit.terms[0].values[0]
    assert found.chi2 == pytest.approx(chi2(base, k), rel=1e-9)
    for moved in ((base + [1e-3, 0.0], k), (base + [0.0, 1e-4], k), (base, 1.01 * k)):
        assert chi2(*moved) > found.chi2
    # and it is another place than that of the plain fit
    assert abs(k - fit.terms[0].values[0]) > 1e-5


def test_growing_and_shrinking_a_fit_keeps_its_rows():
    ball = throw(8, 0.02)
    fitter, fit = _plain(ball)
    grown = fitter.with_term(fit, Term(Wind, np.array([0.1])))
    assert grown.free == (*fit.free, (0, "a"))
    fresh = fitter.derivative(grown)
    # exact for the rows that an acceleration more does not change
    assert np.allclose(fresh.jacobian[-1], grown.jacobian[-1])
    assert np.allclose(grown.predicted, ball.predict([grown.parameter_set()])[0])
    back = fitter.without_term(grown, 0)
    assert back.free == fit.free and not back.terms
    assert np.allclose(back.predicted, fit.predicted)


@pytest.mark.parametrize(("freedom", "low", "high"), [(4.0, 2.0, 9.0), (1e6, 12.0, MOST_FREEDOM)])
def test_usual_dispersion_knows_how_far_single_ones_lie_from_it(freedom, low, high):
    rng = np.random.default_rng(3)
    own = np.full(60, 10.0)
    found = []
    for _ in range(40):
        kappas = 1.5 * f_distribution.rvs(own, freedom, random_state=rng)
        found.append(typical_dispersion(kappas, own))
    assert low <= np.median([u.freedom for u in found]) <= high
    assert np.median([u.dispersion for u in found]) == pytest.approx(1.5, rel=0.15)


def test_a_dispersion_is_drawn_towards_the_typical_and_never_below_one():
    kappa, freedom = TypicalDispersion(1.2, 8.0).shrink(6.0, 4.0)
    assert freedom == 12.0 and kappa == pytest.approx((4.0 * 6.0 + 8.0 * 1.2) / 12.0)
    assert TypicalDispersion(1.0, 8.0).shrink(0.1, 4.0)[0] == 1.0
    assert typical_dispersion([1.0, 2.0], [4.0, 4.0]) == TypicalDispersion()


def _red(rng, shape, size, constant, dt):
    keep = np.exp(-dt / constant)
    push = size * np.sqrt(1.0 - keep**2) * rng.standard_normal(shape)
    push[:, 0] = size * rng.standard_normal(shape[0])
    return lfilter([1.0], [1.0, -keep], push)


def test_scatter_of_the_gain_is_no_noise():
    """A gain that differs from run to run leaves the noise as it is."""
    ball = throw(9, 0.0, repeats=6)
    runs = ball.runs
    rng = np.random.default_rng(5)
    dt = float(TIME[1] - TIME[0])
    noise = _red(rng, (runs.runs, runs.samples), 0.02, 0.2, dt)
    # what a gain does: nothing in the first half, a step in the second
    step = np.broadcast_to(TIME > 1.0, noise.shape).astype(float)
    stiff = step[None, None]
    levels = []
    for gain in (0.0, 0.5):
        residual = (noise + gain * rng.standard_normal((runs.runs, 1)) * step)[None]
        contrasts = runs.contrast(residual)
        (found,) = fit_noise(runs, contrasts, np.zeros_like(residual), stiff)
        levels.append(float(np.sqrt(found.weights.sum())))
    assert levels[0] == pytest.approx(0.02, rel=0.25)
    assert levels[1] == pytest.approx(levels[0], rel=0.05)
