# SPDX-License-Identifier: Apache-2.0
"""Points of a Magic Formula fit: levels, proposals, runs, stiffness."""

from __future__ import annotations

import numpy as np
from idn_points import points

from flatplank_analysis.identify.mf import information as candidates


def test_distinct_settings_of_the_data_in_words():
    p = points(fz=np.array([3000.0, 1000.0, 1150.0, 3190.0, 5000.0, 1300.0]))
    np.testing.assert_allclose(candidates.levels_of(p, "fz"), [1150.0, 3095.0, 5000.0])
    assert candidates.describe_levels(p, "fz") == "3 loads (1150 N, 3100 N, 5000 N)"
    assert candidates.describe_levels(p, "pressure") == "1 pressure (2.5 bar)"
    six = points(fz=1000.0 * np.arange(1, 7))
    assert candidates.describe_levels(six, "fz") == "6 loads"
    five = points(5, fz=1000.0 * np.arange(1, 6))
    assert candidates.describe_levels(five, "fz").endswith("5000 N)")
    assert candidates.levels_of(p.rows(np.zeros(6, bool)), "fz").size == 0
    angles = points(alpha=np.radians([0.0, 0.4, 0.8, 3.0, 3.0, 3.0]))
    np.testing.assert_allclose(np.degrees(candidates.levels_of(angles, "alpha")), [0.4, 3.0])
    assert candidates.LEVEL["kappa"][1](-0.05) == "-5 %"
    assert candidates.SHOW["alpha"](np.radians(-5.0)) == "a slip angle of -5 deg"
    assert candidates.SHOW["gamma"](np.radians(2.5)) == "a camber of +2.5 deg"
    assert candidates.SHOW["pressure"](2.2e5) == "a pressure of 2.2 bar"
    assert candidates.SHOW["kappa"](0.02) == "a slip of +2 %"
    assert (
        candidates.LEVEL["alpha"][1](np.radians(3.0))
        == "+3 deg"
        == candidates.LEVEL["gamma"][1](np.radians(3.0))
    )
