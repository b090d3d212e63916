# SPDX-License-Identifier: Apache-2.0
"""Steady curves of bristles: chords, bend and slope at zero slip of curves in closed form."""

from __future__ import annotations

import importlib

import numpy as np
import pytest

curve = importlib.import_module("flatplank_analysis.identify.steady_curve")
SLIPS = np.array([-0.05, -0.02, -0.01, 0.0, 0.01, 0.02, 0.05])


def bristles(slips: np.ndarray, q: float) -> np.ndarray:
    """95 kN at zero slip, all sliding beyond 1/q."""
    part = np.minimum(q * np.abs(slips), 1.0)
    return np.sign(slips) * 9.5e4 / (3.0 * q) * (1.0 - (1.0 - part) ** 3)


@pytest.mark.parametrize("slips", [SLIPS, SLIPS[3:], np.array([-0.06, -0.013, 0.0, 0.009, 0.04])])
@pytest.mark.parametrize("q", [1e-4, 5.0, 12.0, 16.0])
def test_bend_and_slope_of_bristles_come_back(slips, q):
    force = bristles(slips, q)
    assert curve._bend(slips, force) == pytest.approx(q, rel=1e-6, abs=1e-4)
    weights = curve.slope_weights(slips, force)
    assert weights @ force == pytest.approx(9.5e4)
    np.testing.assert_allclose(weights @ (force + 300.0), 9.5e4)  # an offset is no slope
    sets = np.vstack([force, bristles(slips, 0.5 * q)])
    np.testing.assert_allclose(curve._bend(slips, sets), [q, 0.5 * q], rtol=1e-5, atol=1e-4)


def test_the_table_has_the_bend_between_zero_and_its_neighbours():
    """Half-way points lie on the curve of bristles, moved with the error of their level."""
    force = bristles(SLIPS, 12.0)
    found = curve.curve_law(SLIPS, force)
    half = np.array([[-0.005, 0.005]])
    np.testing.assert_allclose(found.force(half)[0][0], bristles(half[0], 12.0), rtol=1e-4)
    moved = force + 40.0 * (SLIPS == 0.01)
    q, slope = curve._bend(SLIPS, moved), curve.slope_weights(SLIPS, moved) @ moved

    def brush(slip):
        return slope * slip * (1.0 - q * slip + (q * slip) ** 2 / 3.0)

    wanted = brush(0.005) + 0.5 * (moved[4] - brush(0.01))
    assert curve.curve_law(SLIPS, moved).force(half)[0][0, 1] == pytest.approx(wanted, rel=1e-3)
    # without the levels that tell the bend the table goes through the points alone
    plain = curve.curve_law(SLIPS[2:5], force[2:5])
    np.testing.assert_allclose(plain.force(half)[0][0], 0.5 * force[[2, 4]], rtol=1e-3)
    away = curve.curve_law(SLIPS + 0.003, force)
    np.testing.assert_allclose(away.force(SLIPS[None] + 0.003)[0][0], force, atol=2.0)


def test_what_is_missing_for_the_slope():
    force = bristles(SLIPS, 12.0)
    assert curve.slope_lack(SLIPS, force) == "" == curve.slope_lack(SLIPS[3:], force[3:])
    pair = "a second pair of slips, braking and driving"
    assert curve.slope_lack(SLIPS[2:5], force[2:5]) == pair
    no = "a run without slip and two small slips of one sign"
    assert curve.slope_lack(SLIPS[4:], force[4:]) == no
    slides = curve.slope_lack(SLIPS, bristles(SLIPS, 70.0))
    assert slides == "smaller slips: at 2 % the whole contact slides"
    np.testing.assert_allclose(curve.slope_weights(SLIPS[4:], force[4:]),
                               np.array([-1.0, 0.0, 1.0]) / 0.04)  # fmt: skip
