# SPDX-License-Identifier: Apache-2.0
"""Where a residual is: maps, events, periods of residuals that are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shapes import CONDITIONS, REPEATS, measured

from flatplank_analysis.discovery import where
from flatplank_analysis.discovery.runs import Coordinate, RunSet

RUNS, SAMPLES = CONDITIONS * REPEATS, 480
EXACT = np.zeros((CONDITIONS, SAMPLES))
"""standard errors where nothing scatters"""
PLACE = np.linspace(0.005, 4.795, SAMPLES)
"""[m] a node every centimetre"""


def placed() -> RunSet:
    """Empty runs over a place of 4.8 m, an angle and the setting."""
    runs = measured(0).runs
    place = np.broadcast_to(PLACE, (RUNS, SAMPLES)).copy()
    setting = np.repeat(runs.facts["setting"][:, None], SAMPLES, axis=1)
    own = np.random.default_rng(5).permutation(RUNS)[:, None] + 0.0 * place
    coordinates = {
        "place": Coordinate(place, "m", local=True),
        "angle": Coordinate(place % 0.5, "m", bins=10, period=0.5),
        "setting": Coordinate(setting, "1"),
        "own": Coordinate(own, "1"),
    }
    return replace(
        runs, time=place, measured=np.zeros((1, RUNS, SAMPLES)), coordinates=coordinates
    )


def maps_of(runs: RunSet, residual: np.ndarray, floor: float = 0.0) -> dict[str, where.Map]:
    return {m.coordinate: m for m in where.make_maps(runs, residual, floor)}


def test_a_map_holds_means_and_shares_of_its_bins():
    runs = placed()
    height = np.sqrt([0.0, 1.0, 6.0, 3.0])[np.searchsorted([2.0, 2.2, 2.4, 2.6], PLACE) % 4]
    setting = 1.0 + runs.facts["setting"][:, None]
    maps = maps_of(runs, height * setting)
    found = maps["place"]
    np.testing.assert_allclose(found.edges, np.linspace(0.005, 4.795, 25), atol=1e-6)
    np.testing.assert_allclose(found.mean[3, 10:13], [1.0, 6.0**0.5, 3.0**0.5]
                               * setting[3 * REPEATS], rtol=0.04)  # fmt: skip
    np.testing.assert_allclose(found.share[10:13], [0.1, 0.6, 0.3], atol=0.02)
    assert found.place == (found.edges[11], found.edges[12])
    assert found.place_share == pytest.approx(found.share[11])
    assert found.words().startswith(f"{100.0 * found.share[11]:.2g} % of the residual within 2.2")


def test_the_floor_is_taken_out_of_a_map():
    """What noise of the floor leaves in the mean of three is no systematic energy."""
    runs = placed()
    residual = np.where(PLACE < 2.4, 2.0, 3.0) * np.ones((RUNS, 1))
    (share,) = {round(float(s), 9) for s in maps_of(runs, residual)["place"].share[:11]}
    low, high = 4.0, 9.0
    assert share == pytest.approx(low / (12.0 * (low + high)), rel=0.01)
    left = maps_of(runs, residual, floor=3.0**0.5 * 2.0)["place"]
    assert left.share[:11].max() < 1e-9 and left.share[12:].sum() == pytest.approx(1.0)
    none = maps_of(runs, residual, floor=20.0)["place"]
    assert none.words() == "nothing beyond the floor"


def test_what_differs_between_repeats_is_no_part_of_a_map():
    runs = placed()
    differs = np.tile([3.0, 0.0, -3.0], CONDITIONS)[:, None]
    residual = np.where(PLACE < 1.2, 1.0, 0.0) + np.where(PLACE > 3.6, differs, 0.0)
    found = maps_of(runs, residual)["place"]
    np.testing.assert_allclose(found.share, (np.arange(24) < 6) / 6.0, atol=0.01)


def test_repeats_that_begin_at_other_angles_are_compared_by_the_angle():
    """At one time their forces are of different angles, and their mean is of none."""
    runs = placed()
    began = np.tile([0.0, 0.17, 0.33], CONDITIONS)[:, None]
    angle = (PLACE + began) % 0.5
    known = {**runs.coordinates, "angle": Coordinate(angle, "m", bins=10, period=0.5)}
    runs = replace(runs, coordinates=known)
    found = maps_of(runs, np.where((angle > 0.2) & (angle < 0.25), 10.0, 0.0))["angle"]
    assert found.place == pytest.approx((0.2, 0.25)) and found.place_share > 0.99


def test_the_coordinate_that_orders_a_residual_comes_first():
    runs = placed()
    rng = np.random.default_rng(1)
    step = np.where(PLACE < 2.4, -3.0, 3.0) + 0.6 * rng.standard_normal((RUNS, SAMPLES))
    found = where.make_maps(runs, step, 0.3)
    assert found[0].coordinate == "place"
    assert found[0].ordered == pytest.approx(1.0 / 1.04, abs=0.01)
    assert found[0].p_value == pytest.approx(1.0 / 61.0)
    by_setting = runs.facts["setting"][:, None] * np.sin(PLACE)
    assert {m.coordinate for m in where.make_maps(runs, by_setting, 0.1)[:2]} <= {"setting", "own"}
    noise = rng.standard_normal((RUNS, SAMPLES))
    assert maps_of(runs, noise)["place"].p_value > 0.05
    # a level that all runs share is order, too, though no shift along the place changes it
    level = maps_of(runs, np.ones((RUNS, SAMPLES)))["place"]
    assert (level.ordered, level.p_value) == pytest.approx((1.0, 1.0 / 61.0))
    levels = maps_of(runs, rng.choice([-1.0, 1.0], (RUNS, 1)) * np.ones(SAMPLES))["place"]
    assert levels.p_value > 0.05


def test_stretches_beyond_a_limit_are_told_with_their_conditions():
    runs = placed()
    residual = np.zeros((RUNS, SAMPLES))
    groups = runs.groups
    residual[groups[2], 100:110] = 3.0
    residual[np.concatenate([groups[1], groups[4]])[:, None], np.arange(300, 305)] = 5.0
    residual[groups[4], 303] = 8.0
    residual[groups[0], 200:205] = 1.9
    found = where.events(runs, residual, 2.0, EXACT)
    assert [e.coordinate for e in found] == ["place", "place"]
    worst, other = found
    assert worst.level == pytest.approx(np.sqrt((4.0 * 25.0 + 64.0) / 5.0))
    assert (worst.start, worst.end) == pytest.approx((3.005, 3.055))
    assert worst.conditions == (runs.condition_names[1], runs.condition_names[4])
    assert (other.start, other.end) == pytest.approx((1.005, 1.105))
    assert other.level == pytest.approx(3.0) and other.conditions == (runs.condition_names[2],)
    assert not where.events(runs, residual, 8.1, EXACT)
    # with five centimetres between them they are two
    residual[groups[2], 115:120] = 3.0
    ends = [(e.start, e.end) for e in where.events(runs, residual, 2.0, EXACT)][1:]
    assert sorted(ends) == [pytest.approx((1.005, 1.105)), pytest.approx((1.155, 1.205))]
    # two nodes are no stretch
    assert not where.events(runs, np.where(np.arange(SAMPLES) == 7, 99.0, 0.0)
                            * np.ones((RUNS, 1)), 2.0, EXACT, width=0.02)  # fmt: skip


def test_the_period_of_a_wave_and_its_share():
    runs = placed()
    wave = 2.0 * np.cos(2.0 * np.pi * PLACE / 0.31 + 0.4) * np.ones((RUNS, 1))
    period, share = where.period_of(runs, wave + 1.0, "place", 0.1)
    assert period == pytest.approx(0.31, rel=0.01)
    assert share == pytest.approx(2.0 / (2.0 + 1.0), rel=0.03)
    long = np.cos(np.pi * PLACE) * np.ones((RUNS, 1))
    assert where.period_of(runs, long, "place", 0.1)[0] == pytest.approx(2.0, rel=0.1)
    # what turns with the condition has no period over the place
    turned = wave * np.where(runs.condition % 2, 1.0, -1.0)[:, None]
    assert where.period_of(runs, turned, "place", 0.1)[1] < 0.01
    # and what is shorter than was asked for is not looked at
    assert where.period_of(runs, wave, "place", 0.5)[0] > 0.45


def test_the_share_that_repeats_itself():
    runs = placed()
    shape = 2.0 * np.sign(np.sin(7.0 * PLACE))
    differs = np.tile([1.0, 0.0, -1.0], CONDITIONS)[:, None]
    within, total = 1.0, 4.0 + 2.0 / 3.0
    found = where.coherence(runs, shape + differs)
    assert found == pytest.approx(1.0 - within / total)
    assert where.coherence(runs, differs * np.ones(SAMPLES)) == 0.0
    once = runs.subset(np.arange(0, RUNS, REPEATS))
    assert np.isnan(where.coherence(once, shape * np.ones((CONDITIONS, 1))))
