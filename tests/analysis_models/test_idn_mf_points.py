# SPDX-License-Identifier: Apache-2.0
"""Points of a Magic Formula fit: levels, proposals, runs, stiffness."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from idn_points import points

from flatplank_analysis.identify.carcass import CarcassFit
from flatplank_analysis.identify.mf import information as candidates
from flatplank_analysis.identify.mf.points import (
    _tail,
    merge,
    merge_with_cx_source,
    points_from_runs,
    steady_points,
    stiffness_points,
)
from flatplank_data.errors import FlatplankError


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


def test_a_run_that_could_be_made_is_the_data_at_one_new_level():
    p = points(8, fz=np.repeat([2000.0, 4300.0], 4), kappa=np.tile([0.02, 0.05], 4))
    found = candidates.proposals(p, lambda new: np.column_stack([new.fz, new.kappa, new.alpha]))
    texts = [c.text for c in found]
    # 4000 and 4300 N are one load; two settings of four are measured twice and count once
    assert "a load of 4000 N" not in texts and "a load of 5000 N" in texts
    assert "a load of 2000 N" not in texts and "a slip of +2 %" not in texts
    load = found[texts.index("a load of 5000 N")]
    assert load.have == "2 loads (2000 N, 4300 N)"
    np.testing.assert_allclose(load.rows[:, 0], 5000.0)
    assert sorted(load.rows[:, 1]) == pytest.approx([0.02, 0.02, 0.05, 0.05])
    angle = found[texts.index("a slip angle of +5 deg")]
    np.testing.assert_allclose(angle.rows[:, 2], np.radians(5.0))
    assert sorted(angle.rows[:, 0]) == [2000.0, 2000.0, 4300.0, 4300.0]
    many = points(1000, fz=np.full(1000, 3e3), kappa=np.linspace(-5.0, 5.0, 1000))
    assert 400 <= len(candidates._representative(many)) <= 500
    near = points(4, fz=np.array([3000.0, 3060.0, 4000.0, 2960.0]), kappa=np.full(4, 0.0202))
    np.testing.assert_array_equal(candidates._representative(near).fz, [3000.0, 4000.0])


def test_points_axes_outputs_and_runs():
    p = points(3, kappa=np.array([0.0, 0.1, 0.2]))
    assert p.ranges() == {"kappa": (0.0, 0.2)} and p.run.tolist() == [0, 1, 2]
    one = replace(p, measured={"fx": np.array([1.0, np.nan, 3.0])})
    assert one.with_output("fx").kappa.tolist() == [0.0, 0.2]
    assert len(one.with_output("fy")) == 0
    other = steady_points(
        {"re": np.array([0.3, 0.31])}, fz=[2e3, 2e3], pressure=2e5, run=np.array([7, 7])
    )
    both = merge([p, other])
    assert len(both) == 5 and len(np.unique(both.run)) == 4
    assert both.with_output("re").run.tolist()[0] == both.with_output("re").run.tolist()[1]
    assert np.isnan(both.with_output("re").measured["fx"]).all()
    turned = merge([other, p.rows(np.array([2, 0, 1]))])
    np.testing.assert_array_equal(turned.kappa, both.kappa)
    many = [points(n, run=np.arange(n) // 2) for n in (2, 7, 5)]
    assert len(np.unique(merge(many).run)) == 1 + 4 + 3
    x = np.linspace(0.0, 2.0, 201)
    run = SimpleNamespace(distance=x, fy=np.where(x > 1.5, 40.0, 7.0), mz=0.0 * x)
    assert _tail(run, "fy") == pytest.approx(40.0) and np.isnan(_tail(run, "mz"))
    with pytest.raises(FlatplankError, match="no run"):
        points_from_runs([])


def carcass(alpha: float = 0.0, gamma: float = 0.0, known: bool = True):
    at = SimpleNamespace(alpha=alpha, gamma=gamma)
    at._asdict = lambda: dict(fz=3e3, pressure=2.5e5, alpha=alpha, gamma=gamma)
    fit = SimpleNamespace(
        at=at, sigma_x=SimpleNamespace(value=0.5, determined=known),
        slip_stiffness=SimpleNamespace(value=1e5, determined=known),
    )  # fmt: skip
    fit.rolling_stiffness = CarcassFit.rolling_stiffness.fget(fit)
    return fit


def test_stiffness_of_the_rolling_tire_goes_before_that_at_rest():
    fits = [carcass(), carcass(alpha=0.01), carcass(gamma=0.01), carcass(known=False), carcass()]
    found = stiffness_points(fits)
    assert [p.measured["cx"].tolist() for p in found] == [[2e5], [2e5]]
    standing = steady_points(
        {"cx_at_rest": np.array([1.8e5, np.nan])}, fz=[3e3, 3e3], pressure=2e5
    )
    all_points, source = merge_with_cx_source([standing], fits)
    assert len(all_points.with_output("cx")) == 2 and source.startswith("C_F")
    assert "2 operating points without" in source
    assert "1 operating point without" in merge_with_cx_source([standing], fits[:1])[1]
    all_points, source = merge_with_cx_source([standing], fits[1:4])
    assert all_points.with_output("cx").measured["cx"].tolist() == [1.8e5]
    assert source.startswith("1 runs at rest")
    assert merge_with_cx_source([points()], [])[1] == ""
