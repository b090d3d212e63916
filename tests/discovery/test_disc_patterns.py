# SPDX-License-Identifier: Apache-2.0
"""Bumps and waves that no effect explains are told with their place, and noise is none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from ball import Drag, throw
from draws import without
from promises import broken
from scipy.signal import lfilter
from shapes import CONDITIONS, LONG, NOISE, OTHER, REPEATS, TIME, Sum, measured, searched

from flatplank_analysis.discovery import patterns
from flatplank_analysis.discovery.fit import Fitter, Term
from flatplank_analysis.discovery.patterns import _ModelColumns
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


def test_what_the_model_imitates_is_no_pattern():
    model = placed(measured(1, (2.0 * NOISE, bump)))
    state = searched(model, LONG, OTHER).last.state
    fit = state.whitened.fit
    columns = fit.jacobian[fit.loose()]
    own = _ModelColumns(model.runs, state.metric, columns, fit.residual(model.runs.measured))
    assert [own.gain(column[0]) for column in columns] == [0.0] * len(columns)
    # the gain is the drop of chi2 when the model's parameters adapt
    full = np.zeros((1, *model.runs.measured.shape))
    full[0, 0] = bump(model.setting)
    flat = state.metric(columns).reshape(len(columns), -1).T
    left = state.metric(fit.residual(model.runs.measured)[None]).ravel()
    rest, new = (without(flat, v) for v in (left, state.metric(full).ravel()))
    gain = own.gain(full[0, 0])
    assert gain > 100.0 and gain == pytest.approx((new @ rest) ** 2 / (new @ new), rel=1e-4)


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


def test_of_places_that_differ_by_their_origin_one_is_asked():
    """The last one that the runs have; by less than two centimetres is the same."""
    runs = placed(measured(1)).runs
    place, since = (runs.coordinates[n] for n in ("plank position", "distance since the step"))
    assert [p.name for p in patterns._places(runs)] == ["plank position"]
    for much, count in ((0.019, 1), (0.021, 2)):
        bent = place.values - 1.8 + much * (np.arange(runs.samples) == 7)
        both = {"plank position": place, "since": replace(since, values=bent)}
        other = replace(runs, coordinates={**both, "slip": replace(since, local=False)})
        assert [p.name for p in patterns._places(other)] == ["since", "plank position"][:count]
    ends = next(patterns._places(runs)).ends()
    assert ends == pytest.approx((1.0, 5.0))
    # a place is that which all runs have
    values = place.values + 0.5 * (np.arange(runs.runs) == 3)[:, None]
    assert patterns._Place("a", "m", values).ends() == pytest.approx((1.5, 5.0))


def test_runs_of_one_sign_of_a_setting_are_asked_alone():
    runs = placed(measured(1)).runs
    slip = runs.facts["setting"].copy()
    slip[3] = 9e-4
    level = np.repeat(slip[:, None], runs.samples, axis=1)
    moving = level + 0.1 * TIME
    coordinates = {
        "slip": Coordinate(level), "load": Coordinate(2.0 + level), "speed": Coordinate(moving),
        "angle": Coordinate(level, period=1.0), "place": Coordinate(level, local=True),
    }  # fmt: skip
    groups = list(patterns._groups(replace(runs, coordinates=coordinates)))
    assert [words for words, _ in groups] == ["", ", slip above zero", ", slip below zero"]
    assert groups[0][1].tolist() == [1.0] * RUNS
    # less than a thousandth of the largest is neither
    assert groups[1][1].tolist() == (slip > 0.01).tolist()
    assert groups[2][1].tolist() == (slip < -0.01).tolist()


def test_bumps_and_waves_that_are_asked():
    """Of 4 m: bumps of 20, 40 and 80 cm at every half of their width; waves from 1 m down to six
    nodes or a hundred and twentieth, at four phases."""
    values = np.linspace(1.0, 5.0, 483) * np.ones((2, 1))
    place = patterns._Place("place", "m", values)
    bumps = list(patterns._bumps(place))
    assert [k.numbers[0, 1] for k in bumps] == pytest.approx([0.2, 0.4, 0.8])
    assert all(not k.waves and np.ptp(k.numbers[:, 1]) == 0.0 for k in bumps)
    for kind in bumps:
        width = kind.numbers[0, 1]
        middles = np.linspace(1.0, 5.0, round(8.0 / width) + 1)[1:-1]
        assert kind.numbers[: len(middles), 0] == pytest.approx(middles)
        assert len(kind.numbers) - len(middles) in (0, 1)  # the last one may end outside
    waves = list(patterns._waves(place))
    counts = [4.0 / k.numbers[0, 1] for k in waves]
    assert counts == pytest.approx(np.arange(4.0, 80.3, 0.5)) and all(k.waves for k in waves)
    for kind in waves[:3]:
        period = kind.numbers[0, 1]
        assert kind.numbers[:, 0] == pytest.approx(1.0 + period * np.arange(4) / 8.0)
    fine = patterns._Place("place", "m", np.linspace(1.0, 5.0, 4801) * np.ones((2, 1)))
    assert max(4.0 / k.numbers[0, 1] for k in patterns._waves(fine)) == pytest.approx(119.5)


def test_shapes_and_sizes_of_bumps_and_waves():
    """A bump of 1 m at 3 m, and a wave of 0.5 m with a crest at 3 m; sizes by least squares."""
    runs = placed(measured(1)).runs
    values = runs.coordinates["plank position"].values
    at = np.array([[3.0, 1.0]])
    (bumped,) = patterns._Kind(False, at).shapes(values, at)
    wanted = np.where(np.abs(values - 3.0) < 0.5, np.cos(np.pi * (values - 3.0)) ** 2, 0.0)
    np.testing.assert_allclose(bumped, wanted)
    half = np.array([[3.0, 0.5]])
    (waved,) = patterns._Kind(True, half).shapes(values, half)
    np.testing.assert_allclose(waved, np.cos(4.0 * np.pi * (values - 3.0)))
    place = next(patterns._places(runs))
    above = runs.facts["setting"][::REPEATS] > 0.0
    below = np.random.default_rng(1).standard_normal((CONDITIONS, runs.samples))
    for kind in list(patterns._bumps(place))[:1] + list(patterns._waves(place))[:1]:
        (shape,) = kind.shapes(values[:1], kind.numbers[3:4])
        mean = np.where(above[:, None], -0.7 * shape, below)
        alone = [
            t for t in patterns._tested(runs, place, mean)
            if t.under == ", slip level above zero" and t.kind.waves == kind.waves
        ]  # fmt: skip
        assert alone[0].sizes[3] == pytest.approx(-0.7)
        found = alone[0].pattern(3, 0.5)
        assert (found.size, found.p_value) == (pytest.approx(-0.7), 0.5)
        crest, width = kind.numbers[3]
        if kind.waves:
            assert (found.start, found.end, found.period) == pytest.approx((1.0, 5.0, width))
        else:
            ends = crest - 0.5 * width, crest + 0.5 * width
            assert (found.start, found.end) == pytest.approx(ends) and np.isnan(found.period)
        column = alone[0].column(3)
        np.testing.assert_allclose(column, shape * (runs.facts["setting"] > 0.0)[:, None])
