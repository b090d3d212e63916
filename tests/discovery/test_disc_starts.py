# SPDX-License-Identifier: Apache-2.0
"""From where the base and an effect are fitted, and how far."""

from __future__ import annotations

import time
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from decisions import decision, screened
from shapes import LONG, OTHER, TIME, Sum, measured, searched, shape, wave

from flatplank_analysis.discovery import refits
from flatplank_analysis.discovery.decide import Judge
from flatplank_analysis.discovery.dispersion import TypicalDispersion
from flatplank_analysis.discovery.fit import Fitter, Term, Whitened
from flatplank_analysis.discovery.parameters import Parameter
from flatplank_analysis.discovery.refits import Refits
from flatplank_analysis.discovery.screen import best_per_effect
from flatplank_analysis.discovery.search import Options, _Searcher
from flatplank_analysis.discovery.state import start_base
from flatplank_analysis.discovery.verdict import AT_FLOOR, diagnose

FOUND = np.array([0.3])
STARTS = classmethod(lambda cls: (1.0, 7.5))
"""of a gap"""


class Tone(Sum):
    """level + sin(2 pi f t): from a wrong pitch no fit gets to the right one."""

    parameters = (
        Parameter("level", "1", 0.0, -5.0, 5.0, 0.1),
        Parameter("pitch", "1/s", 0.5, 0.1, 3.0, 0.02),
    )

    def predict(self, sets):
        out = np.empty((len(sets), *self.runs.measured.shape))
        for row, one in zip(out, sets, strict=True):
            row[0] = one.base[0] + np.sin(2.0 * np.pi * one.base[1] * TIME)
            for effect, values in one.effects:
                row[0] += values[0] * effect.form(self.setting)
        return out


def test_a_base_in_a_corner_is_fitted_from_elsewhere():
    heard = measured(20, (1.0, lambda c: np.sin(2.0 * np.pi * 1.2 * TIME)))
    tone = Tone(replace(heard.runs, measured=heard.runs.measured - 0.1 * TIME))
    alone = searched(tone, LONG, OTHER)
    assert alone.starts == 1 and alone.steps[0].state.floors[0].unexplained > 0.3
    tone.starts = ({"pitch": 2.5}, {"pitch": 1.15})
    search = searched(tone, LONG, OTHER)
    assert search.starts == 3 and diagnose(search).verdict == AT_FLOOR
    assert search.last.state.fit.base[1] == pytest.approx(1.2, abs=0.01)
    # where nothing is left, no other start is tried
    assert searched(tone, LONG, start={"pitch": 1.15}).starts == 1
    # an effect that was found from there is fitted with the base from its start as well
    state = search.last.state
    searcher = _Searcher(tone, [LONG], Options(start={"pitch": 1.15}))
    cornered = state.fitter.fit(np.array([0.0, 0.5]), [Term(LONG, np.array([0.0]))])
    stuck = state.fit_whitened(cornered)
    freed = searcher.refits.restarted(state, stuck)
    assert freed.chi2 < 0.5 * stuck.chi2
    assert searcher.refits.restarted(state, freed) is freed

    # and is then taken as it came out from there
    class Cornered(Refits):
        def refit(self, _state, _item):
            return stuck

    judge = Judge(state, stuck.chi2 + 200.0, TypicalDispersion(1.0, 16.0))
    ((_, taken),), rest = Cornered(tone, state.fitter, {"pitch": 1.15}, {}, {"long": 1}).of(
        judge, [None]
    )
    assert taken.chi2 == pytest.approx(freed.chi2) and rest == []


def test_a_search_tells_what_it_does_and_how_long_it_took():
    heard = measured(20, (1.0, lambda c: np.sin(2.0 * np.pi * 1.2 * TIME)), (0.1, LONG.form))
    tone = Tone(replace(heard.runs, measured=heard.runs.measured - 0.1 * TIME))
    tone.starts = ({"pitch": 2.5}, {"pitch": 1.15})
    told, began = [], time.perf_counter()
    search = searched(tone, LONG, OTHER, progress=lambda *what: told.append(what))
    assert 0.0 < search.base_fit < search.first_ranking < search.seconds
    assert search.seconds < time.perf_counter() - began
    wanted = (
        ("fit of the base", 0.0), ("screening", 0.15), ("other starts of the base", 0.17),
        ("screening", 0.15), ("refits, step 1", 0.2), ("screening", 0.15),
        ("refits, step 2", 0.35), ("effects that could stand in for what was found", 0.9),
    )  # fmt: skip
    assert told == [(text, pytest.approx(share)) for text, share in wanted]


class Late(Sum):
    """An effect that does nothing below 0.05: from there no fit finds it."""

    def part(self, effect, values):
        return max(values[0] - 0.05, 0.0) * effect.form(self.setting)


def test_a_gap_that_ended_at_its_null_is_started_from_its_start_size():
    gap = shape("gap", LONG.form, starts=STARTS)
    for effect, size in ((gap, 0.25), (LONG, 0.0)):
        model = Late(measured(25, (0.2, LONG.form)).runs)
        searcher = _Searcher(model, [effect], Options())
        dead = Term(effect, np.array([0.0]))
        step = searcher.step_of(searcher.fitter.fit(start_base(model)), [])
        stuck = step.state.with_term(dead, most=12)
        freed = searcher.refits.restarted(step.state, stuck)
        assert stuck.fit.terms[-1].size == 0.0
        assert freed.fit.terms[-1].size == pytest.approx(size, rel=0.05)


def test_what_was_refitted_already_is_not_fitted_again_from_its_start_size():
    gaps = [shape(e.identifier, e.form, starts=STARTS) for e in (LONG, OTHER)]
    model = measured(28, (0.1, LONG.form))
    searcher = _Searcher(model, [*gaps, shape("plain", lambda c: wave(4.5))], Options())
    step = searcher.step_of(searcher.fitter.fit(start_base(model)), [])
    judge = Judge(step.state, step.state.whitened.chi2, step.screen.typical)

    def fitted(items):
        more = searcher.refits.with_start_sizes(judge, step.screen, items)
        return [d.term.effect.identifier for d, _ in more]

    (long, *_) = (i for i in best_per_effect(step.screen) if i.identifier == "long")
    assert fitted([]) == ["long", "other"] and fitted([long]) == ["other"]


def test_two_at_most_are_fitted_from_their_start_sizes():
    """Those that the screening shows best: a fit from the start values of the base takes long."""
    forms = {"first": LONG.form, "second": OTHER.form, "third": lambda c: wave(4.5)}
    gaps = [shape(name, form, starts=STARTS) for name, form in forms.items()]
    model = measured(28, (0.1, LONG.form), (0.05, OTHER.form), (0.07, forms["third"]))
    searcher = _Searcher(model, gaps, Options())
    step = searcher.step_of(searcher.fitter.fit(start_base(model)), [])
    judge = Judge(step.state, step.state.whitened.chi2, step.screen.typical)
    found = searcher.refits.with_start_sizes(judge, step.screen, [])
    assert [d.term.effect.identifier for d, _ in found] == ["first", "third"]

    class Told(Refits):
        """The fit shows another order than the screening."""

        def newest(self, _judge, found):
            effect = found.fit.terms[-1].effect
            return decision(effect, drop={"first": 100.0, "third": 900.0}[effect.identifier])

    makes = Told(model, searcher.fitter, {}, {}, {})
    found = makes.with_start_sizes(judge, step.screen, [])
    assert [d.term.effect.identifier for d, _ in found] == ["third", "first"]


def test_a_refit_starts_from_what_was_screened_searched_or_measured(monkeypatch):
    monkeypatch.setattr(refits, "line_search", lambda _m, _s, i: Term(i.candidate.effect, FOUND))
    gap = shape("gap", LONG.form, starts=STARTS)
    asked = []
    state = SimpleNamespace(with_term=lambda term, most: asked.append((term, most)))
    makes = refits.Refits(None, None, {}, {"other": {"a": 0.7}}, {})
    for effect, start in ((LONG, 0.04), (gap, FOUND[0]), (OTHER, 0.7)):
        makes.refit(state, screened(effect, 2.0))
        (term, most) = asked.pop()
        assert term.effect is effect and term.size == pytest.approx(start) and most == 2


@pytest.mark.parametrize(
    ("reasons", "rise", "freed"),
    [
        ((), 0.4, True), (("present, negligible",), 0.4, True), (("at all",), 0.4, False),
        ((), 0.6, False),
    ],
)  # fmt: skip
def test_known_numbers_give_back_what_they_took_of_an_effect(reasons, rise, freed):
    """Where the effect is there, however small, and explains as much without them."""

    class Told(Refits):
        def newest(self, _judge, found):
            return f"judged at {found.chi2}"

    warm, back = Whitened("at the end", 100.0), Whitened("at the null", 100.0 + rise)
    fits = {"at the end": "at the null", "at the null": "at the null"}
    makes = Told(None, SimpleNamespace(known_at_null=fits.get), {}, {}, {})
    judge = SimpleNamespace(state=SimpleNamespace(fit_whitened={"at the null": back}.get))
    pair = decision(reasons=reasons), warm
    found = makes.with_known_at_null(judge, pair)
    assert found == ((f"judged at {back.chi2}", back) if freed else pair)
    # none was at an end
    there = pair[0], replace(warm, fit="at the null")
    assert makes.with_known_at_null(judge, there) is there


def test_what_was_refused_is_fitted_again_when_it_may_explain_most():
    """Of the two that explain most: what was refused, may exceed the scatter, and explains more
    than what was accepted."""
    refused = ("not the same size along the run",)
    again = []

    class Told(Refits):
        """A refit is its own decision; one from the start values explains half more."""

        def refit(self, _state, item):
            return item

        def newest(self, _judge, found):
            return found

        def converged(self, _judge, pair):
            return pair

        def with_known_at_null(self, _judge, pair):
            return pair

        def restarted(self, _state, warm):
            again.append(warm)
            return replace(warm, drop=1.5 * warm.drop, reasons=())

    makes, judge = Told(None, None, {}, {}, {}), SimpleNamespace(state=None)

    def fitted_again(*decisions):
        again.clear()
        found, rest = makes.of(judge, decisions)
        drops = [d.drop for d, _ in found]
        assert drops == sorted(drops, reverse=True)
        assert all(d.accepted for d, fit in found if d.drop > 1000.0)
        assert rest == [d for d in decisions if d.p_repeats > 0.02] and len(found + rest) == 3
        return again[:]

    low, mid, high = (decision(drop=d, reasons=refused) for d in (400.0, 700.0, 900.0))
    assert fitted_again(low, mid, high) == [high, mid]
    good = replace(mid, reasons=())
    assert fitted_again(low, good, high) == [high]
    assert fitted_again(low, replace(good, drop=1000.0), high) == []
    assert fitted_again(low, mid, replace(high, p_repeats=0.021)) == [mid, low]
    assert fitted_again(low, mid, replace(high, p_repeats=0.019)) == [
        replace(high, p_repeats=0.019),
        mid,
    ]


class Pair(Sum):
    """Two channels with one level."""

    def predict(self, sets):
        return np.repeat(super().predict(sets)[:, :1], 2, axis=1)


def test_the_base_is_fitted_with_the_weights_that_later_fits_use():
    """One channel scatters from run to run, but hardly along a run: the first weights trust it."""
    runs = measured(26, noise=0.01).runs
    offsets = 0.5 * np.random.default_rng(26).standard_normal((runs.runs, 1))
    x, y = runs.measured[0] + offsets, runs.measured[0] - 0.3
    model = Pair(replace(runs, channels=("x", "y"), measured=np.stack([x, y])))
    state = searched(model, LONG).steps[0].state
    again = state.fitter.fit(state.fit.base)
    assert state.fitter.error(again) > 0.99 * state.fitter.error(state.fit)
    assert state.fit.base[0] == pytest.approx(0.7, abs=0.005)


def test_channels_count_by_their_weights():
    runs = measured(29, noise=0.0).runs
    x = runs.measured[0]
    model = Pair(replace(runs, channels=("x", "y"), measured=np.stack([x, x + 2.0])))
    fit = Fitter(model, np.array([10.0, 1.0])[:, None, None]).fit(start_base(model))
    assert fit.base == pytest.approx([1.0 + 2.0 / 101.0, 0.1], rel=1e-5)
