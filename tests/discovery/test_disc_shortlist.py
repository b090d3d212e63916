# SPDX-License-Identifier: Apache-2.0
"""The shortlist of screened effects, and the sizes from which their refits start."""

from __future__ import annotations

from dataclasses import make_dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from ball import Drag, throw
from decisions import screened
from draws import numbers, without
from scipy.stats import chi2
from shapes import LONG, OTHER, Sum, measured, shape, wave

from flatplank_analysis.discovery import shortlist
from flatplank_analysis.discovery.dispersion import among_repeats, typical_dispersion
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.fit import Fitter
from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.screen import _bounded, best_per_effect, likeness, screen
from flatplank_analysis.discovery.state import (
    channel_weights,
    make_state,
    measured_term,
    start_base,
    term_of,
)


def test_what_the_tire_can_feign_is_told_when_the_residual_asks_for_it():
    """Beyond the level and within its range; what is visible, is on the shortlist."""
    looked, typical = {"long": 3, "other": 3}, SimpleNamespace(dispersion=2.0)
    least = 2.0 * 0.8 * chi2.isf(0.05 / 3, 1)

    def told(*items):
        return shortlist.unidentifiable(
            SimpleNamespace(ranked=list(items), typical=typical), looked
        )

    faint = screened(LONG, 1.0, gain=1.01 * least, visible=0.004)
    assert told(faint) == ["long"]
    # scores that scatter less than the noise are luck
    typical.dispersion = 0.4
    assert told(replace(faint, gain=0.51 * least)) == ["long"]
    assert told(replace(faint, gain=0.49 * least)) == []
    typical.dispersion = 2.0
    assert told(screened(OTHER, 1.0, gain=2.0 * least, visible=0.004), faint) == ["other", "long"]
    assert told(screened(LONG, 1.0, gain=0.99 * least, visible=0.004)) == []
    assert told(screened(LONG, 1.0, gain=1.01 * least, visible=0.006)) == []
    far = LONG.main_parameter().upper / LONG.main_parameter().screen
    assert told(screened(LONG, far, gain=2.0 * least, visible=0.004)) == []


def test_the_shortlist_has_what_may_be_an_effect():
    looked = {"long": 3, "other": 3}
    least = 0.8 * chi2.isf(0.05 / 3, 1)
    assert shortlist._least_gain(screened(LONG, 1.0), looked) == pytest.approx(least)
    one, other = screened(LONG, 1.0), screened(OTHER, 1.0, gain=900.0)
    other = replace(other, contribution=np.eye(9)[1])

    def listed(*items, most=5, like=0.0):
        projected = np.eye(9) + like * (np.ones((9, 9)) - np.eye(9))
        result = SimpleNamespace(ranked=list(items), projected=projected)
        return [i.identifier for i in shortlist.shortlist(result, looked, most)]

    assert listed(one, other) == ["long", "other"]
    assert listed(one, other, most=1) == ["long"]
    assert listed(replace(one, gain=0.99 * least), other) == ["other"]
    assert listed(replace(one, visible=0.0049), other) == ["other"]
    # twins take one place: the surer one, or the alphabet
    assert listed(one, other, like=0.999) == ["long"]
    assert listed(replace(other, gain=1010.0), one, like=0.999) == ["long"]
    assert listed(replace(other, gain=1021.0), one, like=0.999) == ["other"]
    assert listed(one, other, like=0.99) == ["long", "other"]
    usual = screened(shape("zzz", LONG.form), 1.0, gain=500.0)
    rare = screened(shape("aaa", LONG.form, rarity=2), 1.0)
    assert shortlist._goes_before(usual, rare) and not shortlist._goes_before(rare, usual)


def test_what_the_base_imitates_mostly_is_refitted_without_any_gain():
    """One size, and no free form, and no gap; from one screening step, whatever its sign."""
    two = classmethod(lambda cls: (1.0, 7.5))
    gap, free = shape("gap", LONG.form, starts=two), shape("free", LONG.form, generic=True)
    second = param(0.0, unit="1", bounds=(-1.0, 1.0), screen=0.1)
    pair = make_dataclass("pair", [("b", float, second)], bases=(LONG,), frozen=True)
    pair.identifier = "pair"

    def listed(*items, known=()):
        result = SimpleNamespace(ranked=list(items))
        found = shortlist.mostly_imitated(result, list(known))
        assert all(item.sizes.tolist() == [1.0] for item in found)
        return [item.identifier for item in found]

    faint = screened(LONG, -3.0, gain=0.0, visible=0.24)
    assert listed(faint, screened(OTHER, 0.0, 0.0, 0.005)) == ["long", "other"]
    assert listed(faint, known=[faint]) == []
    assert listed(replace(faint, visible=0.26)) == listed(replace(faint, visible=0.0049)) == []
    assert listed(*(screened(e, np.ones(len(e.linear())), visible=0.1) for e in (gap, free))) == []
    assert listed(screened(pair, [1.0, 1.0], visible=0.1)) == []


def test_likeness_is_that_of_columns_without_what_the_model_takes():
    """0.6 between two columns; never more than 1, whatever rounding makes of the sums."""
    one, other = screened(LONG, 1.0), screened(OTHER, 1.0)
    one, other = (replace(o, contribution=np.eye(2)[i]) for i, o in enumerate((one, other)))
    for cross, own, wanted in (
        (0.6, 1.0, 0.6),
        (-0.6, 1.0, 0.6),
        (1.2, 4.0, 0.6),
        (1.0, 0.9, 1.0),
    ):
        result = SimpleNamespace(projected=np.array([[1.0, cross], [cross, own]]))
        assert likeness(result, one, other) == pytest.approx(wanted)
    nothing = replace(other, contribution=np.zeros(2))
    assert likeness(result, one, nothing) == 0.0


def test_a_screened_size_far_below_what_matters_is_none():
    """Half of it: the screening is rough. The step is 0.02."""
    least = shape("least", LONG.form, matters=0.1)
    assert shortlist.negligible(screened(least, 2.4))
    assert not shortlist.negligible(screened(least, -2.6))
    # steps count from the null, and what the base takes counts, too
    size = param(0.06, unit="1", bounds=(-1.0, 1.0), screen=0.02, matters=0.1)
    apart = make_dataclass("apart", [("a", float, size)], bases=(Effect,), frozen=True)
    assert shortlist.negligible(screened(apart, -2.0))
    assert not shortlist.negligible(screened(apart, 2.0))
    apart.in_base = 0.04
    assert not shortlist.negligible(screened(apart, -2.0))


def test_a_size_of_no_consequence_is_refitted_only_where_several_are_tried():
    """A gap that was screened from its null shows less than it is."""
    several = classmethod(lambda cls: (1.0, 7.5))
    for starts, wanted in ((LONG.starts, []), (several, ["small"])):
        small = screened(shape("small", LONG.form, matters=0.1, starts=starts), 2.4)
        result = SimpleNamespace(ranked=[small], projected=np.eye(9))
        listed = shortlist.shortlist(result, {"small": 1}, 5)
        assert [i.identifier for i in listed] == wanted


def test_a_term_starts_at_its_screened_size_within_its_range():
    bounded = shape("bounded", LONG.form, bound=0.05)
    item = screened(bounded, 2.0)
    assert term_of(item.candidate, np.array([2.0])).values == pytest.approx([0.04])
    assert term_of(item.candidate, np.array([-9.0])).values == pytest.approx([-0.05])
    term = term_of(item.candidate, np.array([2.0]))
    assert measured_term(term, {"a": 0.01}).values == pytest.approx([0.01])
    assert measured_term(term, {"a": 0.9}).values == pytest.approx([0.05])
    assert measured_term(term, {}).values == pytest.approx([0.04])


def test_the_best_of_several_sizes_with_the_base_moved_along():
    """Drag of two screening steps: of 0.5, 1, 1.5, 2.2 ... the fourth is the nearest."""
    model = throw(1, 0.02)
    fitter = Fitter(model, channel_weights(model, [0.02]))
    state = make_state(model, fitter, fitter.fit(start_base(model)), [Drag])
    (item,) = best_per_effect(screen(state))
    for sizes in (np.zeros(1), np.ones(1)):
        term, gain = shortlist.line_search_with_drop(model, state, replace(item, sizes=sizes))
        assert term.values == pytest.approx([0.022])
        found = state.fit_whitened(fitter.with_term(state.whitened.fit, term))
        assert gain == pytest.approx(state.whitened.chi2 - found.chi2, rel=0.05)
    half, _ = shortlist.line_search_with_drop(model, state, replace(item, sizes=np.full(1, 0.4)))
    assert half.values == pytest.approx([0.02])
    # what was screened as next to nothing is tried with one and three screening steps, too
    tiny, _ = shortlist.line_search_with_drop(model, state, replace(item, sizes=np.full(1, 0.01)))
    assert tiny.values == pytest.approx([0.03])
    assert shortlist.line_search(model, state, item).values == pytest.approx(
        shortlist.line_search_with_drop(model, state, item)[0].values
    )


@pytest.mark.parametrize("times", [0.5, 1.0, 1.5, 2.2, 3.3, 5.0])
def test_sizes_from_half_to_five_times_the_screened_one_are_tried(times):
    """Where the base is not at its best for the effect, its step is taken along: least squares
    of the residual by the base, with the effect at that size. What the base gains alone is no
    drop of the effect."""
    model = measured(34, (0.1, LONG.form), (0.1, OTHER.form))
    fitter = Fitter(model, channel_weights(model, [0.05]))
    state = make_state(model, fitter, fitter.fit(start_base(model)), [LONG])
    far = fitter.fit(np.array([0.8, 0.15]), iterations=0)
    state = replace(state, whitened=replace(state.whitened, fit=far))
    (item,) = best_per_effect(screen(state))
    # five steps of 0.02
    item = replace(item, sizes=np.full(1, 5.0 / times))
    term, gain = shortlist.line_search_with_drop(model, state, item)
    assert term.values == pytest.approx([0.1])
    white = state.metric(far.jacobian).reshape(len(far.jacobian), -1).T
    left = far.residual(model.runs.measured)
    with_ = left - 0.1 * LONG.form(model.setting)
    before, after = (state.metric(v[None]).ravel() for v in (left, with_))
    alone, rest = without(white, before), without(white, after)
    assert gain == pytest.approx(alone @ alone - rest @ rest, rel=1e-6)


def test_an_effect_of_two_sizes_is_tried_with_their_ratio():
    """Half as large, as large ...; where both were screened as nothing, from one step of each."""
    sizes = {n: param(0.0, unit="1", bounds=(-5.0, 5.0), screen=0.02) for n in "ab"}
    fields = [(name, float, one) for name, one in sizes.items()]
    pair = make_dataclass("pair", fields, bases=(Effect,), frozen=True)

    class Pairs(Sum):
        def part(self, effect, values):
            return values[0] * LONG.form(self.setting) + values[1] * OTHER.form(self.setting)

    for hidden, screened_sizes in (((0.1, 0.2), (5.0, 10.0)), ((0.06, 0.06), (0.0, 0.0))):
        forms = zip(hidden, (LONG.form, OTHER.form), strict=True)
        model = Pairs(measured(35, *forms).runs)
        fitter = Fitter(model, channel_weights(model, [0.05]))
        state = make_state(model, fitter, fitter.fit(start_base(model)), [pair])
        (item,) = best_per_effect(screen(state))
        item = replace(item, sizes=np.array(screened_sizes))
        assert shortlist.line_search(model, state, item).values == pytest.approx(hidden)


def test_a_screened_size_is_that_of_least_squares():
    """Gain, size and visible share of an effect beside what the model's own columns take."""
    waves = [shape(f"wave {n}", lambda c, n=n: c**2 * wave(n)) for n in (3.5, 4.5, 5.5, 6.5)]
    level = shape("flat", lambda c: 1.0 + 0.0 * c * wave(1.0))
    effects, scatter = [OTHER, *waves, level, LONG], numbers(31, 6, 24)
    model = measured(
        31, (0.05 + 0.01 * scatter[0], LONG.form), (-0.03 + 0.01 * scatter[1], OTHER.form),
        *((0.02 * s, e.form) for s, e in zip(scatter[2:], waves, strict=True)),
    )  # fmt: skip
    fitter = Fitter(model, channel_weights(model, [0.05]))
    state = make_state(model, fitter, fitter.fit(start_base(model)), effects)
    found = screen(state)
    fit = state.whitened.fit
    white = state.metric(fit.jacobian).reshape(len(fit.jacobian), -1).T
    left = state.metric(fit.residual(model.runs.measured)[None]).ravel()
    pairs = []
    gains = [i.gain for i in found.ranked]
    assert len(gains) == 7 and gains == sorted(gains, reverse=True)
    for item in found.ranked[:6]:
        column = state.metric(item.candidate.columns).ravel()
        rest, own = (without(white, v) for v in (left, column))
        size = (own @ rest) / (own @ own)
        assert item.sizes == pytest.approx([size], rel=1e-4)
        assert item.gain == pytest.approx((own @ rest) ** 2 / (own @ own), rel=1e-4)
        assert item.visible == pytest.approx((own @ own) / (column @ column), rel=1e-4)
        (row,) = np.flatnonzero(item.contribution)
        assert effects[row] is item.candidate.effect
        runs = model.runs.runs
        score = np.sum((rest * own).reshape(-1, runs, model.runs.samples), axis=(0, 2))
        info = np.sum((own**2).reshape(-1, runs, model.runs.samples), axis=(0, 2))
        score -= info * score.sum() / info.sum()
        pairs.append(among_repeats(model.runs.comparable, score, info))
    # what the model imitates is shown by nothing, and says nothing of the scatter
    flat = found.ranked[6]
    assert flat.visible < 1e-6 and flat.gain == 0.0 and flat.sizes.tolist() == [0.0]
    assert flat.identifier == "flat" and flat.contribution.tolist() == np.eye(7)[5].tolist()
    wanted = typical_dispersion([k for k, _ in pairs], [f for _, f in pairs])
    assert wanted.dispersion > 1.5
    assert found.typical.dispersion == pytest.approx(wanted.dispersion, rel=1e-3)
    assert found.typical.freedom == pytest.approx(wanted.freedom, rel=1e-3)


@pytest.mark.parametrize("seed", range(8))
def test_sizes_beyond_their_range_are_held_and_the_others_solved_again(seed):
    """Two sizes from -4 to 2 and from -3 to 1 steps; the second counts downwards."""
    draw = np.random.default_rng(seed)
    first, second = (
        param(1.0, unit="1", bounds=(-1.0, 2.0), screen=0.5),
        param(0.5, unit="1", bounds=(0.4, 0.8), screen=-0.1),
    )
    effect = make_dataclass("Both", [("a", float, first), ("b", float, second)], bases=(Effect,),
                            frozen=True)  # fmt: skip
    a = draw.standard_normal((9, 2)) @ [[1.0, 0.4], [0.0, 0.8]]
    goal = a @ draw.uniform(-6.0, 6.0, 2)
    sizes = _bounded(SimpleNamespace(effect=effect), a.T @ a, a.T @ goal)
    low, high = np.array([-4.0, -3.0]), np.array([2.0, 1.0])
    np.testing.assert_allclose(sizes, np.clip(sizes, low, high))
    wanted = np.linalg.lstsq(a, goal)[0]
    out = (wanted < low) | (wanted > high)
    wanted = np.clip(wanted, low, high)
    if out.sum() == 1:
        wanted[~out] = np.linalg.lstsq(a[:, ~out], goal - a[:, out] @ wanted[out])[0]
    np.testing.assert_allclose(sizes, np.clip(wanted, low, high))
