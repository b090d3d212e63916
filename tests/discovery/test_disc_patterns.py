# SPDX-License-Identifier: Apache-2.0
"""Bumps and waves that no effect explains are told with their place, and noise is none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from ball import Drag, throw
from promises import broken
from scipy.signal import lfilter
from shapes import CONDITIONS, LONG, NOISE, OTHER, REPEATS, TIME, Sum, measured, searched

from flatplank_analysis.discovery.fit import Fitter, Term
from flatplank_analysis.discovery.report.text import text_of
from flatplank_analysis.discovery.runs import Coordinate
from flatplank_analysis.discovery.state import channel_weights, make_state, start_base
from flatplank_analysis.discovery.verdict import AT_FLOOR, NONE, diagnose

RUNS = CONDITIONS * REPEATS


def placed(model: Sum) -> Sum:
    """The same runs over a place of 4 m from 1 m on, a fifth of it before the step; half of the
    slips above zero."""
    runs = model.runs
    place = runs.time + 1.0
    level = np.repeat(runs.facts["setting"][:, None], runs.samples, axis=1)
    coordinates = {
        "slip level": Coordinate(level, "1"),
        "distance since the step": Coordinate(place - 1.8, "m", local=True),
        "plank position": Coordinate(place, "m", local=True),
    }
    return Sum(replace(runs, coordinates=coordinates))


def judged(model: Sum):
    result = diagnose(searched(model, LONG, OTHER))
    assert not broken(result)
    return result


def bump(c: np.ndarray) -> np.ndarray:
    """Half a metre long, with one sign of the setting only."""
    u = (TIME - 2.6) / 0.5
    return np.where((np.abs(u) < 0.5) & (c > 0.0), np.cos(np.pi * u), 0.0)


def hum(c: np.ndarray) -> np.ndarray:
    return np.cos(2.0 * np.pi * TIME / 0.31) * (c < 0.0)


@pytest.mark.parametrize("size", [1.2, -1.2])
def test_a_bump_of_some_conditions_is_told_with_its_place(size):
    result = judged(placed(measured(1, (size * NOISE, bump))))
    assert result.verdict == NONE
    assert "bump over plank position" in result.reason and "slip level above zero" in result.reason
    where = {m["coordinate"]: m["range"] for m in result.to_dict()["unexplained"]["where"][:2]}
    low, high = where["plank position"]
    assert 3.2 < low < 3.6 < high < 4.0
    assert where["distance since the step"] == pytest.approx([low - 1.8, high - 1.8])
    pattern = result.search.last.state.patterns.strongest(result.limits.bump, result.limits.wave)
    assert (low, high) == pytest.approx((pattern.start, pattern.end), rel=1e-5)
    assert pattern.size == pytest.approx(size * NOISE, rel=0.35)
    assert " of 0.0" in text_of(result) and " of 0," not in text_of(result)


def test_a_wave_of_some_conditions_is_told_with_its_period():
    result = judged(placed(measured(2, (0.55 * NOISE, hum))))
    assert result.verdict == NONE
    assert "wave of 0.3" in result.reason and "slip level below zero" in result.reason
    assert result.period == pytest.approx(0.31, rel=0.03)


def test_what_is_left_in_the_mean_is_told_with_its_place_too():
    result = judged(placed(measured(1, (3.0 * NOISE, bump))))
    assert result.verdict == NONE and "clearest is a bump over plank position" in result.reason


def test_what_is_of_no_consequence_is_not_told():
    """Both are ten times what the noise lets through."""
    for size, form in ((0.5, bump), (0.3, hum)):
        assert judged(placed(measured(3, (size * NOISE, form)))).verdict == AT_FLOOR


@pytest.mark.parametrize("slow", [0.0, 0.9, 0.98])
def test_noise_has_no_patterns(slow):
    """White noise and red noise, whose mean wanders over half a metre."""
    for seed in range(10):
        model = measured(400 + seed, noise=0.0 if slow else NOISE)
        if slow:
            push = np.random.default_rng(seed).standard_normal((RUNS, 3 * len(TIME)))
            red = lfilter([NOISE * np.sqrt(1.0 - slow**2)], [1.0, -slow], push)
            model.runs.measured[0] += red[:, -len(TIME) :]
            model.runs.measured[0] += 0.2 * NOISE * push[:, : len(TIME)]
        assert judged(placed(model)).verdict == AT_FLOOR, seed


def test_what_the_model_predicts_is_no_pattern():
    """A throw is a parabola of many metres, of which the numbers of the base are only a part:
    what noise leaves of 3 mm here and there is not sure, unless it holds the throw itself."""
    for seed in (1, 2, 3):
        ball = throw(seed, 0.02)
        fitter = Fitter(ball, channel_weights(ball, [0.02]))
        fit = fitter.fit(start_base(ball), [Term(Drag, np.array([0.02]))])
        found = make_state(ball, fitter, fit, []).patterns
        assert np.abs(found.residual).max() > 0.05 and found.strongest(0.003, 0.003) is None
