# SPDX-License-Identifier: Apache-2.0
"""Scatter of the tire from run to run: its size from repeats, and beside a gap of the machine."""

import numpy as np
import pytest
from bristles import Truth, campaign

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery.gram import Gram
from flatplank_analysis.discovery.scatter import likeliest_deviations

CONDITIONS, REPEATS = 9, 3
TRUE = np.array([0.03, 0.0003])


def drawn(rng: np.random.Generator, true: np.ndarray) -> tuple[Gram, np.ndarray, np.ndarray]:
    """Sums of repeats whose amounts scatter; the conditions show them with unlike precision."""
    products, scores, order = [], [], rng.permutation(CONDITIONS * REPEATS).astype(float)
    for condition in range(CONDITIONS):
        known = 10.0 ** rng.uniform([1.7, 3.5], [2.5, 4.5])
        h = np.outer(known, known) * [[1.0, 0.3], [0.3, 1.0]]
        amounts = true * rng.standard_normal((REPEATS, 2))
        noise = rng.standard_normal((REPEATS, 2)) @ np.linalg.cholesky(h).T
        score = amounts @ h + noise
        scores.append(score - score.mean(axis=0))
        products.append(np.stack([h] * REPEATS))
        own = slice(condition * REPEATS, (condition + 1) * REPEATS)
        order[own] -= order[own].mean()
    share = np.full(len(order), 1.0 - 1.0 / REPEATS)
    return (
        Gram(np.concatenate(products), np.concatenate(scores), np.zeros(len(order))),
        share,
        order,
    )


def test_the_variance_of_the_scatter_is_right_in_the_mean():
    """By the most precise runs alone the estimate had six degrees of freedom, not eighteen."""
    rng = np.random.default_rng(7)
    found = np.array([likeliest_deviations(*drawn(rng, TRUE)) for _ in range(60)])
    assert np.sqrt(np.mean(found**2, axis=0)) == pytest.approx(TRUE, rel=0.15)
    assert np.all(np.std(found, axis=0) < 0.25 * TRUE)


def test_noise_is_no_scatter():
    """What is found without any is below the standard error of the most precise run."""
    rng = np.random.default_rng(8)
    found = np.array([likeliest_deviations(*drawn(rng, 0.0 * TRUE)) for _ in range(60)])
    assert np.all(np.sqrt(np.mean(found**2, axis=0)) < [10.0**-2.5, 10.0**-4.5])


@pytest.mark.long
def test_a_gap_beside_scatter_of_the_tire_brings_no_further_effect():
    """A gap turns the directions of the scatter where the force crosses it: wear had P = 0.73."""
    truth = Truth(
        seed=63, play=3e-4, scatter=0.03, noise=0.5,
        slips=(-0.1, -0.05, -0.01, 0.0, 0.01, 0.05, 0.1),
    )  # fmt: skip
    result = Session.of_tables(campaign(truth)).diagnose().to_dict()
    (effect,) = result["effects"]
    assert {effect["name"], *effect["class"]} == {"rack_backlash", "road_play"}
    others = result["posterior"]["effects"].items()
    assert all(p < 0.05 for name, p in others if name not in ("rack_backlash", "road_play")), (
        others
    )
