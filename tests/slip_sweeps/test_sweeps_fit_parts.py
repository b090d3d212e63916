# SPDX-License-Identifier: Apache-2.0
"""The fit of sweeps without the fit: points, start values, loads left out, progress."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from flatplank_analysis.slip_sweeps.conditions import BINS, SweepCondition
from flatplank_analysis.slip_sweeps.curves import Curve
from flatplank_analysis.slip_sweeps.fit import points_of

SLIP = np.linspace(-0.1, 0.1, BINS)
WAY = np.array([1.0] * 6 + [-1.0] * 3)
"""samples of each bin: six while the slip rises, three while it falls"""
ONE_WAY, EMPTY = 5, 7
"""a bin that was passed while the slip rose only, and one without a force"""
EMPTY_SAMPLES = np.arange(9 * EMPTY, 9 * EMPTY + 9)
KEPT = np.arange(BINS) != EMPTY


def a_study(loads=(1000.0,), swept="alpha", held=None, path="a.csv", **more):
    """A condition per load. Forces and load of the two ways differ by 20 N and 100 N; `more`:
    channel -> value, None: not in the file."""
    bins, way = np.repeat(np.arange(BINS), 9), np.tile(WAY, BINS)
    way[9 * ONE_WAY : 9 * ONE_WAY + 9] = 1.0
    n, count = len(bins), len(loads)
    slip = np.tile(SLIP[bins], count)
    load = np.concatenate([f + 50.0 * way for f in loads])
    both = np.tile(way, count)
    force = -1e4 * slip + 10.0 * both + (load - 50.0 * both)
    force.reshape(count, n)[:, EMPTY_SAMPLES] = np.nan
    columns = {swept: slip, "fz": load, "fx": force, "fy": force + 1.0, "mz": 0.1 * force}
    columns |= {k: np.full(n * count, v) for k, v in more.items() if v is not None}
    columns = {k: v for k, v in columns.items() if more.get(k, 0.0) is not None}
    nothing = np.full(BINS, np.nan)
    curve = Curve(bins, slip[:n], way > 0.0, SLIP, nothing, nothing, nothing, 1.0, "", 9.0)
    conditions = [
        SweepCondition(swept, {"fz": f} | (held or {}), np.arange(k * n, (k + 1) * n), 1)
        for k, f in enumerate(loads)
    ]
    return SimpleNamespace(
        columns=columns, conditions=conditions, curves=[curve] * count, path=path
    )


def test_a_point_is_the_mean_of_the_ways_however_many_samples_each_has():
    points = points_of([a_study(gamma=0.05, pressure=2e5)])
    assert len(points) == BINS - 1
    wanted = np.where(np.arange(BINS) == ONE_WAY, 1050.0, 1000.0)[KEPT]
    assert points.fz == pytest.approx(wanted)
    assert points.alpha == pytest.approx(SLIP[KEPT])
    assert points.gamma == pytest.approx(0.05) and (points.kappa == 0.0).all()
    assert points.pressure == pytest.approx(2e5)
    ways = np.where(np.arange(BINS) == ONE_WAY, 10.0, 0.0)
    assert points.measured["fy"] == pytest.approx((1001.0 - 1e4 * SLIP + ways)[KEPT])
    assert points.measured["mz"] == pytest.approx((0.1 * (1000.0 - 1e4 * SLIP + ways))[KEPT])


def test_files_follow_one_another_and_a_pressure_that_one_has_not_is_not_known():
    points = points_of([a_study(pressure=2e5), a_study((1000.0, 3000.0))])
    assert len(points) == 3 * (BINS - 1)
    known = np.isfinite(points.pressure)
    assert known[: BINS - 1].all() and not known[BINS - 1 :].any()
    assert points.fz[-1] == pytest.approx(3000.0) and points.fz[0] == pytest.approx(1000.0)


@pytest.mark.parametrize(
    ("swept", "angle_deg", "forces"),
    [
        ("alpha", None, {"fy", "mz"}), ("kappa", None, {"fx"}), ("kappa", 0.0, {"fx"}),
        ("kappa", 0.4, {"fx"}), ("kappa", -0.4, {"fx"}), ("kappa", 2.0, {"fx", "fy"}),
        ("kappa", -2.0, {"fx", "fy"}),
    ],
)  # fmt: skip
def test_a_sweep_measures_the_forces_of_its_slip_and_both_of_combined_slip(
    swept, angle_deg, forces
):
    held = {} if angle_deg is None else {"alpha": np.radians(angle_deg)}
    more = {} if angle_deg is None else {"alpha": np.radians(angle_deg)}
    points = points_of([a_study(swept=swept, held=held, **more)])
    assert {k for k, v in points.measured.items() if np.isfinite(v).any()} == forces
