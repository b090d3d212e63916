# SPDX-License-Identifier: Apache-2.0
"""Screened effects, and the sizes from which their fits start."""

from __future__ import annotations

from dataclasses import make_dataclass, replace

import numpy as np
import pytest
from ball import Drag, throw
from decisions import screened
from draws import numbers, without
from shapes import LONG, OTHER, measured, shape, wave

from flatplank_analysis.discovery.dispersion import among_repeats, typical_dispersion
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.fit import Fitter
from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.screen import best_per_effect, negligible, screen
from flatplank_analysis.discovery.starts import line_search
from flatplank_analysis.discovery.state import (
    channel_weights,
    make_state,
    start_base,
    term_of,
    term_with,
)


def test_a_screened_size_far_below_what_matters_is_none():
    """Half of it: the screening is rough. The step is 0.02."""
    least = shape("least", LONG.form, matters=0.1)
    assert negligible(screened(least, 2.4))
    assert not negligible(screened(least, -2.6))
    # steps count from the null, and what the base takes counts, too
    size = param(0.06, unit="1", bounds=(-1.0, 1.0), screen=0.02, matters=0.1)
    apart = make_dataclass("apart", [("a", float, size)], bases=(Effect,), frozen=True)
    assert negligible(screened(apart, -2.0))
    assert not negligible(screened(apart, 2.0))
    apart.in_base = 0.04
    assert not negligible(screened(apart, -2.0))


def test_a_term_starts_at_its_screened_size_within_its_range():
    bounded = shape("bounded", LONG.form, bound=0.05)
    item = screened(bounded, 2.0)
    assert term_of(item.candidate, np.array([2.0])).values == pytest.approx([0.04])
    assert term_of(item.candidate, np.array([-9.0])).values == pytest.approx([-0.05])
    term = term_of(item.candidate, np.array([2.0]))
    assert term_with(term, {"a": 0.01}).values == pytest.approx([0.01])
    assert term_with(term, {"a": 0.9}).values == pytest.approx([0.05])
    assert term_with(term, {}).values == pytest.approx([0.04])


def test_the_best_of_several_sizes_with_the_base_moved_along():
    """Drag of two screening steps: of 0.5, 1, 1.5, 2.2 ... the fourth is the nearest."""
    model = throw(1, 0.02)
    fitter = Fitter(model, channel_weights(model, [0.02]))
    state = make_state(model, fitter, fitter.fit(start_base(model)), [Drag])
    (item,) = best_per_effect(screen(state))
    for sizes in (np.zeros(1), np.ones(1)):
        term, gain = line_search(state, replace(item, sizes=sizes), {})
        assert term.values == pytest.approx([0.022])
        found = state.fit_whitened(fitter.with_term(state.whitened.fit, term))
        assert gain == pytest.approx(state.whitened.chi2 - found.chi2, rel=0.05)
    half, _ = line_search(state, replace(item, sizes=np.full(1, 0.4)), {})
    assert half.values == pytest.approx([0.02])
    # what was screened as next to nothing is tried with one and three screening steps, too
    tiny, _ = line_search(state, replace(item, sizes=np.full(1, 0.01)), {})
    assert tiny.values == pytest.approx([0.03])


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
