# SPDX-License-Identifier: Apache-2.0
"""Steering zero and ply steer of curves that are known."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from idn_runs import run

from flatplank_analysis.identify.lateral import (
    NAMES,
    _solved,
    lack_of_mirrors,
    steering_zero,
)
from flatplank_analysis.identify.runs import StepRun


def cornering(zero: float, ply: float, level: float, start: int, slope: float) -> StepRun:
    """Steady -Fy, Mz and Fx at an angle of a tire that is odd in the angle it feels."""
    alpha = math.radians(level)
    felt = math.tan(alpha + zero + ply)
    side = 3700.0 * 0.95 * math.sin(1.4 * math.atan(12.0 * felt))
    drag = slope * (math.cos(alpha) / math.cos(alpha + zero) - 1.0) if slope == slope else 0.0
    x = np.arange(0.001, 1.5, 0.002)
    own = 1.0 * (x > 1.1)  # the last 0.3 m
    columns = {"mz": -0.03 * side * math.cos(1.15 * math.atan(8.0 * felt)) * own, "fy": drag * own}
    return run(math.tan(alpha), start, fx=side * own, distance=x, **columns,
               slip_stiffness=slope)  # fmt: skip


@pytest.mark.parametrize(("zero", "ply"), [(-0.015, 0.003), (0.01, -0.004)])
def test_steering_zero_and_ply_steer_of_known_curves(zero, ply):
    def runs(slope):
        return [
            replace(cornering(zero, ply, level, start, slope), level=level)
            for level in (-8.0, -3.0, -1.0, 1.0, 3.0, 8.0) for start in (1, 2)
        ]  # fmt: skip

    found = steering_zero(runs(6e4))
    assert math.radians(found.zero.value) == pytest.approx(zero, abs=8e-4)
    assert math.radians(found.ply.value) == pytest.approx(ply, abs=8e-4)
    assert found.shift == pytest.approx(zero + ply, abs=2e-4) and found.ply.determined
    moved = found.corrected(replace(run(0.05), level=2.0))
    assert moved.kappa == pytest.approx(math.tan(math.radians(2.0) + found.shift))
    np.testing.assert_allclose(moved.slip, moved.kappa * moved.distance)
    both = steering_zero(runs(math.nan))
    assert math.radians(both.zero.value) == pytest.approx(zero + ply, abs=4e-4)
    assert not both.ply.determined and "with ply steer" in both.zero.note
    assert steering_zero(runs(6e4)[:8]) is None
    # two angles and straight ahead do not tell how the curve bends: e stays where it is
    few = [r for r in runs(6e4) if abs(r.level) < 4.0]
    straight = replace(cornering(zero, ply, 0.0, 1, 6e4), level=0.0)
    assert _solved([*few, straight])[0][NAMES.index("e")] == 0.0
    assert _solved(runs(6e4))[0][NAMES.index("e")] != 0.0
    assert lack_of_mirrors([-1.0, 1.0, 3.0]) and not lack_of_mirrors([-1, 1, 3, -3, 0])


def test_the_sign_of_the_moment_does_not_matter():
    """Mz of another axis system has a trail of the other sign, and the same zero."""
    runs = [replace(cornering(0.03, 0.01, level, 1, 6e4), level=level)
            for level in (-8.0, -3.0, -1.0, 1.0, 3.0, 8.0)]  # fmt: skip
    here, there = (_solved([replace(r, mz=s * r.mz) for r in runs])[0] for s in (1.0, -1.0))
    trail = NAMES.index("trail")
    assert here[trail] == pytest.approx(0.03, abs=1e-3) == -there[trail]
    others = [i for i, name in enumerate(NAMES) if name not in ("trail", "mz0")]
    np.testing.assert_allclose(there[others], here[others], rtol=1e-4, atol=1e-6)


def test_scatter_between_three_starts_is_in_the_errors():
    """Starts fitted one by one; two of them tell no scatter."""

    def of(start, zero):
        return [replace(cornering(zero, 0.0, level, start, 6e4), level=level)
                for level in (-8.0, -3.0, 3.0, 8.0)]  # fmt: skip

    parts = [of(1, -0.002), of(2, 0.0), of(3, 0.004)]
    runs = [one for part in parts for one in part]
    whole, errors = _solved(runs)
    each = np.array([_solved(part)[0] for part in parts])
    wanted = np.hypot(errors, each.std(axis=0, ddof=1) / 3.0**0.5)
    found = steering_zero(runs)
    assert found.zero.std_error == pytest.approx(math.degrees(wanted[0]))
    assert found.ply.std_error == pytest.approx(math.degrees(wanted[1]))
    assert wanted[0] > 1.1 * errors[0]
    assert found.zero.value == pytest.approx(math.degrees(whole[0]))
    two = steering_zero(parts[0] + parts[2])
    alone = _solved(parts[0] + parts[2])[1]
    assert two.zero.std_error == pytest.approx(math.degrees(alone[0]))
    # a start without mirrored angles is no witness
    three = steering_zero(parts[0] + parts[2] + parts[1][:2])
    alone = _solved(parts[0] + parts[2] + parts[1][:2])[1]
    assert three.zero.std_error == pytest.approx(math.degrees(alone[0]))
