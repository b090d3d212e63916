# SPDX-License-Identifier: Apache-2.0
"""What the search does with its refits in one step, each on numbers of its own."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from decisions import decision, odd
from shapes import LONG, OTHER, shape

from flatplank_analysis.discovery import invariants, search
from flatplank_analysis.discovery.decide import NEARLY, Judge
from flatplank_analysis.discovery.decision import NEGLIGIBLE, UNEVEN
from flatplank_analysis.discovery.fit import Term, Whitened
from flatplank_analysis.discovery.rivals import AlternativeEffect
from flatplank_analysis.discovery.search import _Searcher
from flatplank_analysis.discovery.steps import AcceptedEffect

FREE = shape("free", LONG.form, generic=True)
REFUSED = ("its 99 % interval covers zero",)


@pytest.mark.parametrize(
    ("other", "asked"),
    [
        # ln of the independent numbers is 5: 1.03 times 990 beside 3 parameters
        (decision(FREE, drop=1035.0, parameters=3), True),
        (decision(FREE, drop=1034.0, parameters=3), False),
        (decision(FREE, drop=1035.0, parameters=3, p_repeats=0.011), False),
        (decision(OTHER, drop=1035.0, parameters=3, reasons=(NEGLIGIBLE,)), True),
        (decision(OTHER, drop=1034.0, parameters=3, reasons=(NEGLIGIBLE,)), False),
        # of another form than the effect, too; was the way of a false softening of the carcass
        (decision(OTHER, drop=1035.0, parameters=3, reasons=(NEGLIGIBLE, *UNEVEN)), True),
        (decision(OTHER, drop=1035.0, parameters=3, reasons=(NEGLIGIBLE, *REFUSED)), False),
        (decision(OTHER, drop=9000.0), False),
        (odd(OTHER, drop=9000.0), False),
    ],
)
def test_an_effect_is_tested_beside_what_explains_more_and_is_not_named(other, asked):
    tested, says = [], {}

    def newest(judge, both):
        tested.append((judge.without, both))
        return says["beside"]

    searcher = SimpleNamespace(
        fitter=SimpleNamespace(with_term=lambda fit, term: (fit, term.effect.identifier)),
        refits=SimpleNamespace(newest=newest),
    )
    state = SimpleNamespace(independent=math.exp(5.0), fit_whitened=lambda fit: fit)
    judge, own = Judge(state, 7000.0, None), decision(LONG, drop=1000.0, parameters=2)

    def stands(one, misshapen):
        tried = [(other, Whitened("with the other", 5000.0))]
        return _Searcher.stands_beside_stronger(searcher, judge, one, tried, misshapen)

    for beside, misshapen, wanted in (
        (decision(), False, True), (decision(reasons=REFUSED), False, False),
        (odd(), False, False), (odd(), True, True),
    ):  # fmt: skip
        says["beside"] = beside
        assert stands(own, misshapen) is (wanted or not asked)
    assert tested == [(5000.0, ("with the other", "long"))] * (4 if asked else 0)
    assert stands(decision(FREE, drop=1.0), False) and len(tested) == (4 if asked else 0)


@pytest.mark.parametrize(("drop", "dispersion", "asked"), [
    (84.0, 1.0, False), (86.0, 1.0, True), (86.0, 1.5, False),
])  # fmt: skip
def test_a_law_is_stronger_where_the_difference_decides_between_two_effects(
    drop, dispersion, asked
):
    """ln of the independent numbers is 5, so 45 are beside four parameters' 64 or 66; 20 decide,
    times the dispersion."""
    tested = []
    searcher = SimpleNamespace(
        fitter=SimpleNamespace(with_term=lambda fit, term: fit),
        refits=SimpleNamespace(newest=lambda judge, both: tested.append(both) or decision()),
    )
    judge = Judge(SimpleNamespace(independent=math.exp(5.0), fit_whitened=lambda f: f), 0.0, None)
    own, tried = (
        decision(drop=50.0, dispersion=dispersion),
        decision(FREE, drop=drop, parameters=4),
    )
    assert _Searcher.stands_beside_stronger(
        searcher, judge, own, [(tried, Whitened("law", 0.0))], False
    )
    assert tested == ["law"] * asked


def test_a_refit_that_was_carried_to_its_end_takes_the_place_of_the_first():
    fits = [Whitened(name, 0.0) for name in ("a", "b", "end")]
    first, other, wrong = decision(), decision(OTHER), odd()
    for last, refused in ((wrong, {"long": pytest.approx(0.2)}), (decision(reasons=REFUSED), {})):
        tried = [(first, fits[0]), (other, fits[1])]
        step, searcher = SimpleNamespace(refits=[other, first]), SimpleNamespace(refused={})
        _Searcher.correct(searcher, step, tried, (last, fits[2]), fits[0])
        assert tried == [(last, fits[2]), (other, fits[1])]
        assert step.refits == [other, last] and searcher.refused == refused


@pytest.mark.parametrize(
    ("without", "again", "wanted", "fitted"),
    [
        (640.0, 0.0, 640.0, "both"), (660.0, 0.0, 650.0, "both"),
        (590.0, 580.0, 590.0, "again"), (590.0, 610.0, 590.0, "both"),
    ],
)  # fmt: skip
def test_the_base_found_with_an_effect_may_fit_better_without_it(without, again, wanted, fitted):
    """Where it is better than with it, 600, that fit had not ended: it goes on from there."""
    ends = {"less": ("less", without), "less and last": ("again", again)}
    state = SimpleNamespace(fit_whitened=lambda fit: Whitened(*ends[fit]))
    searcher = SimpleNamespace(
        fitter=SimpleNamespace(
            without_term=lambda fit, index: "less", with_term=lambda fit, term: f"{fit} and {term}"
        ),
        refits=SimpleNamespace(newest=lambda judge, found: judge.without),
    )
    found = Whitened(SimpleNamespace(name="both", terms=("first", "last")), 600.0)
    fair, told, end = _Searcher.tested(searcher, Judge(state, 650.0, None), found)
    assert fair.without == told == wanted
    assert end.fit == "again" if fitted == "again" else end is found


def test_a_wrong_form_is_added_where_it_is_nearly_right_or_leaves_nothing():
    def completed(tried, taken, which=0):
        def take(_step, _judge, every, best, misshapen):
            assert every is tried and best == [tried[which]] and misshapen
            return taken

        step = SimpleNamespace(found=[])
        return _Searcher.complete(SimpleNamespace(take=take), step, None, tried)

    def after(share: float, left: str):
        found = [AcceptedEffect(decision(OTHER)), AcceptedEffect(odd(share=share))]
        return SimpleNamespace(left=left, found=found)

    pair = [(odd(), None), (odd(OTHER, drop=800.0), None)]
    for left in ("5 N", ""):
        near, far = after(0.99 * NEARLY, left), after(1.01 * NEARLY, left)
        assert completed(pair, near) is near
        assert completed(pair, far) is (None if left else far)
    assert completed([], far) is None and completed([(decision(), None)], far) is None
    assert completed(pair, None) is None
    # of two that cannot be told apart it is the more common one
    rare = odd(shape("rare", LONG.form, rarity=1), drop=1005.0)
    assert completed([(rare, None), *pair], near, which=1) is near


def test_what_a_step_judges_its_refits_by(monkeypatch):
    """The drop of what was found, by the noise of now where it is one effect; whether all of it
    is of the law; effects of a wrong form; and what looks like a found effect."""
    judges = []
    monkeypatch.setattr(search, "shortlist", lambda *what: [what])
    monkeypatch.setattr(search, "mostly_imitated", lambda screen, items: [(screen, *items)])
    like = AlternativeEffect(Term(shape("like", LONG.form), np.array([0.1])), True)
    over = AlternativeEffect(Term(shape("over", LONG.form), np.array([0.1])), False)
    wide = AcceptedEffect(decision(drop=700.0, dispersion=2.0), (like, over))
    law, wrong = AcceptedEffect(decision(FREE, drop=300.0)), AcceptedEffect(odd(OTHER, 0.25))

    def judged(*found):
        def of(judge, items):
            judges.append(judge)
            listed = (step.screen, {"looked": 2}, 5)
            assert items == [listed, (step.screen, listed)]
            return [(odd(drop=600.0), None)], [decision(OTHER, reasons=REFUSED)]

        step = SimpleNamespace(
            state=SimpleNamespace(whitened=SimpleNamespace(chi2=4000.0)), found=list(found),
            screen=SimpleNamespace(typical="typical"),
        )  # fmt: skip
        again = [replace(f, decision=replace(f.decision, drop=900.0)) for f in found]
        searcher = SimpleNamespace(
            backward=SimpleNamespace(retested=lambda one: again), looked_at={"looked": 2},
            options=SimpleNamespace(terms=("before",), refits=5), refused={"earlier": 0.1},
            refits=SimpleNamespace(of=of), take=lambda *_: "taken",
        )  # fmt: skip
        assert _Searcher.forward(searcher, step) == "taken"
        assert searcher.refused == {"earlier": 0.1, "long": pytest.approx(0.2)}
        assert [d.drop for d in step.refits] == [1000.0, 600.0]
        judge = judges.pop()
        assert judge.without == 4000.0 and judge.typical == "typical"
        return [d.drop for d in judge.others], judge.uneven, judge.alike

    assert judged() == ([], (), {})
    assert judged(law) == ([900.0], (), {})
    assert judged(wide) == ([900.0], (), {"like": 40.0})
    uneven = ((3, pytest.approx(0.25)),)
    assert judged(law, wide, wrong) == ([300.0, 700.0, 1000.0], uneven, {"like": 40.0})


def test_where_much_is_left_gaps_are_tried_from_their_start_sizes(monkeypatch):
    monkeypatch.setattr(search, "shortlist", lambda *_: ["items"])
    monkeypatch.setattr(search, "mostly_imitated", lambda *_: [])
    monkeypatch.setattr(search, "preferred", lambda tried: ("best of", *tried))
    first, more = (decision(drop=500.0), "a"), (decision(OTHER, drop=800.0), "b")
    state = SimpleNamespace(whitened=SimpleNamespace(chi2=4000.0))

    def forward(left, *takes):
        given, tried = iter(takes), []

        def take(_step, _judge, refits, chosen):
            assert chosen == ("best of", *refits)
            tried.append(refits)
            return next(given)

        step = SimpleNamespace(
            state=state, found=[], screen=SimpleNamespace(typical=None), left=left
        )
        searcher = SimpleNamespace(
            options=SimpleNamespace(terms=(), refits=5), looked_at={}, refused={}, take=take,
            refits=SimpleNamespace(
                of=lambda *_: ([first], []), with_start_sizes=lambda *what: [more]
            ),
            complete=lambda _step, _judge, refits: refits,
        )  # fmt: skip
        return _Searcher.forward(searcher, step), tried, [d.drop for d in step.refits]

    for left in ("5 N", ""):
        assert forward(left, "taken") == ("taken", [[first]], [500.0])
    assert forward("5 N", None, "taken") == ("taken", [[first], [more]], [500.0, 800.0])
    assert forward("5 N", None, None) == ([more, first], [[first], [more]], [500.0, 800.0])
    assert forward("", None) == ([first], [[first]], [500.0])


@pytest.mark.parametrize(
    ("errors", "channels", "again"),
    [((8.9, 9.5), 2, True), ((9.5, 8.9), 2, True), ((9.1, 9.5), 2, False), ((1.0, 1.0), 1, False)],
)
def test_a_base_fitted_with_the_weights_of_the_floors_must_be_a_tenth_better(
    errors, channels, again, monkeypatch
):
    fits = {"plain": ("from plain", errors[0]), "white": ("from white", errors[1])}

    class Told:
        def __init__(self, model, weight):
            assert (model, weight) == ("model", [2.0] * channels)

        def fit(self, base, terms, known):
            name, error = fits[base]
            assert terms == "terms" and known.base == base
            return SimpleNamespace(name=name, chi2=error, of=error)

        def error(self, fit):
            return fit.of

    monkeypatch.setattr(search, "Fitter", Told)
    monkeypatch.setattr(search, "channel_weights", lambda _model, levels: levels)
    plain, white = (SimpleNamespace(base=b, terms="terms", of=10.0) for b in ("plain", "white"))
    floors = [SimpleNamespace(floor=2.0)] * channels
    state = SimpleNamespace(fit=plain, whitened=SimpleNamespace(fit=white), floors=floors)
    searcher = SimpleNamespace(model="model", step_of=lambda fit, found: (fit.name, found))
    step = SimpleNamespace(state=state)
    found = _Searcher.with_weights_of_floors(searcher, step)
    best = "from plain" if errors[0] < errors[1] else "from white"
    assert found == ((best, []) if again else step) and isinstance(searcher.fitter, Told)


def test_a_search_goes_on_from_one_effect_that_replaces_several(monkeypatch):
    """The first step stays; the last one may be replaced where a rival is better."""
    monkeypatch.setattr(search, "start_base", lambda model, start: "base")
    monkeypatch.setattr(invariants, "error_of", lambda fitter, fit: 3.0)
    state = SimpleNamespace(fit="fit")
    first, second, single, third = (
        SimpleNamespace(state=state, name=name) for name in ("first", "second", "single", "third")
    )
    after = {"first": second, "single": third}
    for replaced, better, wanted in (
        (None, None, [first, second]),
        (single, None, [first, single, third]),
        (None, third, [first, third]),
    ):
        searcher = SimpleNamespace(
            say=lambda *_: None, model="model", effects=["effect"], looked_at={}, starts=2,
            options=SimpleNamespace(start={}, terms=()), began=0.0,
            fitter=SimpleNamespace(fit=lambda base, terms: (base, terms)),
            step_of=lambda fit, found: {("base", ()): first}[fit],
            with_weights_of_floors=lambda step: step, from_other_starts=lambda step: step,
            continued=lambda steps: [*steps, after[steps[-1].name]],
            single_effect_step=lambda steps, found=replaced: found,
            classes=lambda step, better=better: better or step,
        )  # fmt: skip
        found = _Searcher.run(searcher)
        assert found.steps == wanted and searcher.bare == 3.0


@pytest.mark.parametrize(("most", "wanted"), [(1, 2), (2, 3), (9, 5)])
def test_steps_are_added_up_to_the_number_of_effects_that_is_allowed(most, wanted):
    """Or until none passes; a step never leads back to the effects of an earlier one."""
    chain = [[], [LONG], [LONG, OTHER], [OTHER], [OTHER, FREE]]
    steps = [
        SimpleNamespace(found=[AcceptedEffect(decision(e)) for e in effects]) for effects in chain
    ]
    told, known = [], []

    def forward(step):
        known.append(searcher.known)
        return dict(zip(map(id, steps), [*steps[1:], None], strict=True))[id(step)]

    searcher = SimpleNamespace(
        options=SimpleNamespace(most=most), forward=forward, say=lambda *what: told.append(what)
    )
    for count in (1, 2):
        assert _Searcher.continued(searcher, steps[:count]) == steps[: max(wanted, count)]
    # most additions, and the first one of the second call is number 2
    numbers = [n for n in range(1, 6) if n <= min(most, 5)]
    numbers += numbers[1:]
    assert told == [(f"refits, step {n}", pytest.approx(0.05 + 0.15 * n)) for n in numbers]
    names = [frozenset(e.identifier for e in effects) for effects in chain]
    assert known == [set(names[:n]) for n in numbers]


@pytest.mark.parametrize(
    ("left", "last", "wanted"),
    [((0.0, 2.1), 9.9, True), ((1.1, 0.0), 9.9, True), ((0.9, 1.9), 9.9, False),
     ((1.1, 2.1), 10.1, False)],
)  # fmt: skip
def test_the_best_of_other_starts_is_fitted_to_its_end(left, last, wanted, monkeypatch):
    """Where something of consequence is left in any channel; each start has six iterations. What
    was given as a start stays, unless a start says otherwise."""
    monkeypatch.setattr(
        invariants, "limits", lambda _state, c: SimpleNamespace(rest=(1.0, 2.0)[c])
    )
    monkeypatch.setattr(search, "start_base", lambda _model, start: tuple(sorted(start.items())))
    starts = [{"a": 2.0}, {"b": 3.0}, {"a": 4.0}]
    bases = [
        (("a", 2.0), ("c", 5.0)),
        (("a", 1.0), ("b", 3.0), ("c", 5.0)),
        (("a", 4.0), ("c", 5.0)),
    ]
    chi2 = dict(zip(bases, (30.0, 20.0, 25.0), strict=True))
    asked = []

    def fit(base, terms, iterations=25, known=None):
        asked.append((base, terms, iterations))
        assert known is None or (known.base, iterations) == (base, 25)
        return SimpleNamespace(base=base, terms=terms, chi2=chi2[base], error=last)

    searcher = SimpleNamespace(
        model=(model := SimpleNamespace(starts=starts)), say=lambda *_: None, starts=1,
        options=SimpleNamespace(start={"a": 1.0, "c": 5.0}, terms="terms"),
        fitter=SimpleNamespace(model=model, fit=fit, error=lambda fit: fit.error),
        step_of=lambda fit, found: (fit.base, found),
    )  # fmt: skip
    floors = [SimpleNamespace(unexplained=value) for value in left]
    step = SimpleNamespace(state=SimpleNamespace(floors=floors, fit=SimpleNamespace(error=10.0)))
    found = _Searcher.from_other_starts(searcher, step)
    assert found == ((bases[1], []) if wanted else step)
    tried = left != (0.9, 1.9)
    assert searcher.starts == (4 if tried else 1)
    every = [*((base, "terms", 6) for base in bases), (bases[1], "terms", 25)]
    assert asked == (every if tried else [])
