# SPDX-License-Identifier: Apache-2.0
"""Evidence of a linear model: against the exact marginal density, and against integrals by sums
over a grid."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.special import gammaln
from scipy.stats import multivariate_normal
from scipy.stats import t as student

from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.gram import Gram
from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.inference.errors import WithLawErrors
from flatplank_analysis.inference.evidence import Fixed, Random, evidence
from flatplank_analysis.inference.posterior import log_evidence
from flatplank_analysis.inference.priors import of_set, of_value

RUNS, SAMPLES = 6, 8
GROUP = np.array([0, 0, 1, 1, 2, 2])
FREE = np.full(2, np.inf)


@dataclass(frozen=True)
class Push(Effect):
    """An effect with a one-sided size."""

    identifier = "push"
    size_: float = param(0.0, unit="N", bounds=(0.0, 1e6), screen=1.0, matters=0.1)


class _Plain:
    """A metric of white noise of unit size."""

    whitener = scatter = None
    volume = 0.0

    def white(self, values: np.ndarray) -> np.ndarray:
        return values[:, 0]

    __call__ = white

    def beside_scatter(self, white: np.ndarray) -> np.ndarray:
        return white


def columns_and_residual(seed: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """Columns (runs, 3, samples): two fixed ones, one random one; residual (runs, samples)."""
    rng = np.random.default_rng(seed)
    columns = rng.standard_normal((RUNS, 3, SAMPLES))
    u = rng.standard_normal(3)[GROUP]
    y = 0.7 * columns[:, 0] - 0.4 * columns[:, 1] + 0.5 * u[:, None] * columns[:, 2]
    return columns, y + rng.standard_normal((RUNS, SAMPLES))


def test_evidence_is_the_marginal_density():
    columns, y = columns_and_residual()
    strength, spread = np.array([0.5, 2.0]), 0.6
    known = Fixed(strength, np.zeros(2), -FREE, FREE)
    random = Random(np.array([[0.0, 0.0, 1.0]]), GROUP, np.array([spread]))
    found = evidence(Gram.of(columns, y), known, [random])
    flat = np.moveaxis(columns, 1, 0).reshape(3, -1)
    grouped = [flat[2] * np.repeat(g == GROUP, SAMPLES) for g in range(3)]
    whole = np.array([*flat[:2], *grouped])
    variance = np.array([*1.0 / strength, *[spread**2] * 3])
    covariance = np.eye(y.size) + whole.T @ (variance[:, None] * whole)
    exact = multivariate_normal(np.zeros(y.size), covariance).logpdf(y.ravel())
    of_priors = 0.5 * float(np.sum(np.log(strength / (2.0 * np.pi))))
    constant = 0.5 * y.size * math.log(2.0 * math.pi)
    assert found.log + of_priors - constant == pytest.approx(exact, abs=1e-8)
    # the posterior of the coefficients is that of a Gaussian regression
    mean = np.linalg.solve(whole @ whole.T + np.diag(1.0 / variance), whole @ y.ravel())
    assert found.step == pytest.approx(mean, abs=1e-7)


def test_evidence_does_not_depend_on_the_point_of_the_expansion():
    """Linear in its coefficients, a model has the same evidence around every start."""
    columns, y = columns_and_residual()
    strength, start = np.array([0.5, 2.0]), np.array([0.3, -0.9])
    random = Random(np.array([[0.0, 0.0, 1.0]]), GROUP, np.array([0.6]))
    there = evidence(
        Gram.of(columns, y - np.einsum("k,rkn->rn", start, columns[:, :2])),
        Fixed(strength, -strength * start, -FREE, FREE, float(strength @ start**2)),
        [random],
    )
    here = evidence(Gram.of(columns, y), Fixed(strength, 0.0 * start, -FREE, FREE), [random])
    assert there.log == pytest.approx(here.log, abs=1e-7)


@pytest.mark.parametrize("factor", [1.0, 2.0, 4.0])
def test_model_errors_are_part_of_the_covariance(factor):
    """Down-weighted squares and volume are those of the density with these errors."""
    rng = np.random.default_rng(4)
    loose = rng.standard_normal((3, 1, RUNS, SAMPLES))
    loose[2] = 0.5 * loose[0]
    groups = [np.flatnonzero(g == GROUP) for g in range(3)]
    metric = WithLawErrors(_Plain(), groups, loose)
    y = rng.standard_normal((1, RUNS, SAMPLES))
    left = metric.down_weighted(y, factor)
    found = metric.volume_with(factor) - 0.5 * float(np.sum(left**2))
    exact = 0.0
    for rows in groups:
        columns = factor * loose[:, 0, rows].reshape(3, -1)
        covariance = np.eye(columns.shape[1]) + columns.T @ columns
        flat = y[0, rows].ravel()
        exact += multivariate_normal(np.zeros(len(flat)), covariance).logpdf(flat)
    constant = 0.5 * y.size * math.log(2.0 * math.pi)
    assert found == pytest.approx(exact + constant, abs=1e-8)


@pytest.mark.parametrize("size", [0.2, 1.0, 5.0])
def test_price_of_a_size_is_that_of_an_integral_over_its_prior(size):
    """A one-sided size with a Student prior, summed over a grid."""
    columns, _ = columns_and_residual()
    column = 4.0 * columns[:, :1]
    rng = np.random.default_rng(8)
    y = size * column[:, 0] + rng.standard_normal((RUNS, SAMPLES))
    grid = np.linspace(0.0, 12.0, 60001)
    left = y.ravel()[:, None] - np.outer(column.ravel(), grid)
    density = 2.0 * student.pdf(grid, 2.0, scale=0.3)
    chi2 = np.sum(left**2, axis=0)
    like = np.exp(-0.5 * (chi2 - chi2.min()))
    exact = math.log(float(np.trapezoid(like * density, grid))) - 0.5 * float(chi2.min())
    fixed = Fixed(np.array([1e-9]), np.zeros(1), -FREE[:1], FREE[:1])
    found = evidence(Gram.of(column, y), fixed)
    value = float(found.step[0])
    (p,) = Push.parameters()
    log = found.log + of_value(Push, p, value)
    assert log == pytest.approx(exact, abs=0.02)


@pytest.mark.parametrize("freedom", [4.0, 60.0])
@pytest.mark.parametrize("excess", [1.0, 30.0, 1e4])
def test_tails_are_the_integral_over_the_level_of_the_noise(excess, freedom):
    """The variance of the noise has an inverse gamma density of this freedom."""
    level = np.geomspace(1e-3, 1e6, 400001)
    half = 0.5 * freedom
    log = half * math.log(half) - gammaln(half) - (half + 1.0) * np.log(level) - half / level
    exact = math.log(float(np.trapezoid(np.exp(log - 0.5 * excess / level), level)))
    assert log_evidence(excess, 0.0, freedom, 1.0) == pytest.approx(exact, abs=1e-3)


def test_noise_that_is_known_well_gives_the_tails_of_gauss():
    assert log_evidence(7.0, -2.0, 1e9, 1.0) == pytest.approx(-5.5)


def test_one_effect_is_expected_in_a_library_of_any_size():
    for library in (10, 40, 160):
        odds = math.exp(of_set(1, library))
        assert library * odds / (1.0 + odds) == pytest.approx(1.0)
