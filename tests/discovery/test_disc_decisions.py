# SPDX-License-Identifier: Apache-2.0
"""Rules by which the search accepts, refuses and ranks effects, each on numbers of its own."""

from __future__ import annotations

from dataclasses import make_dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from decisions import RUNS, decision
from shapes import CONDITIONS, LONG, OTHER, REPEATS, measured, shape

from flatplank_analysis.discovery import backward, decide, refits, rivals, search
from flatplank_analysis.discovery.decide import SHARE, Judge
from flatplank_analysis.discovery.decision import IMITATED, UNEVEN
from flatplank_analysis.discovery.fit import Fitter, Term
from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.rivals import AlternativeEffect
from flatplank_analysis.discovery.state import (
    channel_weights,
    make_state,
    rough_levels,
    start_base,
)
from flatplank_analysis.discovery.steps import AcceptedEffect

NO_RUNS = SimpleNamespace(runs=None)
FREE = shape("free", LONG.form, generic=True)
BEYOND = ("its interval reaches beyond its physical range",)


@pytest.mark.parametrize(
    ("changes", "reasons"),
    [
        ({}, ()),
        ({"p_repeats": 0.011}, ("not beyond the scatter among repeats",)),
        ({"p_conditions": 0.0051}, ("not beyond the scatter among conditions",)),
        ({"drop": 0.0}, ("not beyond the scatter among repeats",
                         "not beyond the scatter among conditions")),
        ({"matters": 0.11}, ("present, negligible",)),
        ({"stretch_q": 30.1}, UNEVEN[:1]), ({"condition_q": 30.1}, UNEVEN[1:]),
        ({"interval": (0.0364, 0.1636)}, ()), ({"interval": (-0.1636, -0.0364)}, ()),
        ({"interval": (0.0362, 0.1638)}, ("its 99 % interval covers zero",)),
        ({"interval": (-0.01, 0.2)}, ("its 99 % interval covers zero",)),
        ({"term": Term(LONG, np.array([5.0]))}, ("at the end of its physical range",)),
        ({"term": Term(LONG, np.array([-0.1])), "interval": (-0.2, -0.1)}, ()),
        ({"interval": (2.0, 5.0)}, ()), ({"interval": (2.0, 5.1)}, BEYOND),
        ({"term": Term(LONG, np.array([-4.8])), "interval": (-5.1, -4.5)}, BEYOND),
    ],
)  # fmt: skip
def test_every_reason_has_its_bound(changes, reasons):
    assert tuple(decide._reasons(decision(**changes), 0.005)) == reasons


def test_a_free_form_has_no_sign_and_no_range():
    free = shape("free", LONG.form, generic=True)
    for interval in ((-0.1, 0.3), (0.1, 5.1)):
        assert not list(decide._reasons(decision(free, interval=interval), 0.005))


def test_a_first_effect_that_is_sure_among_repeats_needs_less_among_conditions():
    """A further one does not: errors of the form of the first differ between conditions, too. A
    free form of the law leaves nothing of the kind."""
    refused = ["not beyond the scatter among conditions"]
    sure = decision(p_repeats=9e-6, p_conditions=0.0049)
    first = Judge(NO_RUNS, 0.0, None)
    assert not list(first._reasons(sure))
    for before, reasons in (((FREE,), []), ((FREE, OTHER), refused), ((OTHER,), refused)):
        judge = replace(first, others=tuple(decision(e, drop=10.0) for e in before))
        assert list(judge._reasons(sure)) == reasons
    assert list(first._reasons(replace(sure, p_repeats=1.1e-5))) == refused
    assert list(first._reasons(replace(sure, p_conditions=0.0051))) == refused
    # conditions that differ are an error of the law, but for what another form may differ
    weak = replace(sure, drop=39.0)
    assert not list(first._reasons(replace(weak, dispersion_conditions=5.9)))
    assert list(first._reasons(replace(weak, dispersion_conditions=6.0))) == refused
    assert not list(first._reasons(replace(sure, dispersion_conditions=149.0)))
    assert list(first._reasons(replace(sure, dispersion_conditions=151.0))) == refused


def test_what_is_explained_already_asks_for_more():
    below = [f"its drop is below {100 * SHARE:g} % of what is explained already"]

    def reasons(share: float, signals=(1.0,), own=(1.0,)) -> list[str]:
        half = decision(OTHER, drop=0.5 * share * 1000.0 / SHARE, signals=signals)
        judge = Judge(NO_RUNS, 0.0, None, others=(half, half))
        return list(judge._reasons(decision(signals=own)))

    assert reasons(1.01) == below and not reasons(0.99)
    # where it shows in one signal, what is explained in the other does not count
    assert reasons(4.04, (0.25, 0.75), (1.0, 0.0)) == below
    assert not reasons(3.96, (0.25, 0.75), (1.0, 0.0))
    assert reasons(1.01, (0.5, 0.5), (0.5, 0.5)) == below
    assert not reasons(1e9, (0.0, 1.0), (1.0, 0.0)) and not reasons(9.0, (0.0, 1.0), (0.0, 0.0))
    judge = Judge(NO_RUNS, 0.0, None)
    judge = replace(judge, alike={LONG.identifier: 1001.0})
    assert list(judge._reasons(decision())) == [
        "its drop does not distinguish it from a found effect"
    ]


def test_a_fault_of_another_form_leaves_what_differs():
    uneven = decision(reasons=UNEVEN[:1], stretch_q=390.0, condition_q=10.0)
    assert uneven.unevenness == pytest.approx(0.39) and not uneven.accepted
    assert uneven.misshapen and uneven.residue == pytest.approx(390.0)
    assert replace(uneven, condition_q=399.0).residue == pytest.approx(399.0)
    assert not replace(uneven, stretch_q=401.0).misshapen
    assert replace(uneven, stretch_q=401.0).residue == 0.0
    assert not replace(uneven, reasons=(*UNEVEN, "present, negligible")).misshapen
    assert not decision().misshapen and decision().accepted
    free = shape("free", LONG.form, generic=True)
    assert not replace(uneven, term=Term(free, np.array([0.1]))).misshapen
    assert decision(p_conditions=1e-3).p_value == 1e-3 and decision(p_repeats=0.2).p_value == 0.2


def test_an_effect_stays_while_it_explains_something_beside_the_others():
    strong, weak = (
        AcceptedEffect(decision(drop=1e5)),
        AcceptedEffect(decision(drop=1e5 * SHARE * 1.01)),
    )
    assert backward.needed(weak, [strong, weak]) and backward.needed(strong, [strong, weak])
    weaker = AcceptedEffect(decision(drop=1e5 * SHARE * 0.99))
    assert not backward.needed(weaker, [strong, weaker])
    unsure = AcceptedEffect(decision(drop=1e5, p_repeats=0.02))
    assert not backward.needed(unsure, [strong, unsure])
    # sure enough as the first effect, and not as a further one
    faint = AcceptedEffect(decision(drop=1e4, p_conditions=1.1 * decide.CONDITIONS))
    assert not backward.needed(faint, [strong, faint])
    assert backward.needed(faint, [faint, AcceptedEffect(decision(drop=9e3))])
    # in another signal than the strong one it is no small share
    aside = AcceptedEffect(decision(drop=1.0, signals=(0.0, 1.0)))
    strong = AcceptedEffect(decision(drop=1e5, signals=(1.0, 0.0)))
    assert backward.needed(aside, [strong, aside])


def test_a_gap_beside_another_one_is_what_its_form_leaves_unless_it_explains_much():
    """Less than a quarter of what the other one explains alone; the whitened sums of squares are
    by the terms of a fit, one of them before the found ones."""
    gap = {"starts": classmethod(lambda cls: (1.0, 2.5))}
    one, two = shape("one", LONG.form, **gap), shape("two", LONG.form, **gap)
    elsewhere = shape("elsewhere", LONG.form, **gap, coordinate="load")
    assert two.imitates(one) and not two.imitates(elsewhere)
    assert not two.imitates(LONG) and not LONG.imitates(two)
    chi2 = {"before": 2000.0, "before one": 1000.0, "before two": 1300.0}

    def left(*effects, i, drop):
        self = backward.Backward(
            SimpleNamespace(without_term=lambda fit, at: fit[:at] + fit[at + 1 :]), 1, {}, {},
            9.0, None,
        )  # fmt: skip
        whole = ["before", *(e.identifier for e in effects)]
        state = SimpleNamespace(
            whitened=SimpleNamespace(fit=whole),
            fit_whitened=lambda fit: SimpleNamespace(fit=fit, chi2=chi2[" ".join(fit)]),
        )
        found = [AcceptedEffect(decision(e, drop=drop)) for e in effects]
        return self.left_by_a_gap(SimpleNamespace(state=state, found=found), i)

    for gaps in ((one, two), (two, one)):
        first, second = gaps.index(one), gaps.index(two)
        assert left(*gaps, i=second, drop=249.0) and not left(*gaps, i=second, drop=251.0)
        assert left(*gaps, i=first, drop=174.0) and not left(*gaps, i=first, drop=176.0)
    assert not left(one, elsewhere, i=1, drop=1.0) and not left(one, LONG, i=1, drop=1.0)


def test_effects_of_a_wrong_form_and_how_much_their_sizes_differ():
    """By what is seen now, or was seen when they were refused for it."""
    odd = decision(OTHER, stretch_q=300.0, reasons=UNEVEN[:1])
    step = SimpleNamespace(found=[AcceptedEffect(decision()), AcceptedEffect(odd)])
    assert backward.uneven_terms(step, 2, {}) == ((3, pytest.approx(odd.unevenness)),)
    known = backward.uneven_terms(step, 2, {"long": 0.3, "other": 0.9})
    assert known == ((2, 0.3), (3, pytest.approx(odd.unevenness)))


def test_what_is_good_enough_for_a_full_refit():
    assert refits.nearly(decision(reasons=UNEVEN, p_repeats=0.019))
    assert not refits.nearly(decision(p_repeats=0.021))
    assert not refits.nearly(decision(reasons=("present, negligible",)))
    assert not refits.nearly(decision(reasons=("at the end of its physical range",)))


def test_the_largest_gain_comes_first():
    pairs = [(decision(drop=d), None) for d in (3.0, 9.0, 5.0)]
    assert [d.drop for d, _ in refits.by_drop(pairs)] == [9.0, 5.0, 3.0]


def test_of_gains_that_cannot_be_told_apart_the_usual_effect_goes_first():
    rare = shape("rare", LONG.form, rarity=1)
    free = shape("free", LONG.form, generic=True)
    one, other = decision(rare, drop=1000.0), decision(LONG, drop=975.0)
    generic = decision(free, drop=2000.0)
    given = [(d, None) for d in (generic, one, other)]
    assert [d for d, _ in refits.preferred(given)] == [other, one, generic]
    far = decision(LONG, drop=960.0)
    assert [d for d, _ in refits.preferred([(one, None), (far, None)])] == [one, far]
    assert not refits.preferred([(decision(p_repeats=0.5), None)])
    many = [(decision(drop=1e3 - 200.0 * i), None) for i in range(4)]
    assert refits.preferred(many) == many[:3]
    more, same = decision(OTHER, drop=1003.0, parameters=3), decision(LONG, drop=984.0)
    assert [d for d, _ in refits.preferred([(more, None), (same, None)])] == [same, more]
    less = decision(LONG, drop=982.0)
    assert [d for d, _ in refits.preferred([(more, None), (less, None)])] == [more, less]
    # the more the scores scatter, the less a difference decides
    wide, same = replace(more, dispersion=2.0), decision(LONG, drop=965.0)
    assert [d for d, _ in refits.preferred([(wide, None), (same, None)])] == [same, wide]
    # a wrong form makes rarer effects indistinguishable, not simpler ones better
    odd = replace(more, reasons=UNEVEN[:1], stretch_q=300.0)
    assert [d for d, _ in refits.preferred([(odd, None), (less, None)])] == [odd, less]


def test_which_wrong_form_is_completed():
    """The one that explains most, unless an effect of a form that is wronger still explains more,
    or it could stand in for a found one of a wrong form."""
    odd = decision(LONG, reasons=UNEVEN[:1], stretch_q=300.0)
    weaker = decision(OTHER, drop=500.0, reasons=UNEVEN[:1], stretch_q=100.0)
    wronger = decision(shape("wronger", LONG.form), drop=1100.0, reasons=UNEVEN, stretch_q=900.0)
    free = decision(shape("free", LONG.form, generic=True), drop=5000.0, reasons=UNEVEN)

    def completed(*tried, found=()):
        pairs = search.completable([(d, None) for d in tried], found)
        return [d for d, _ in refits.preferred(pairs)][:1]

    assert completed(weaker, odd) == [odd] and completed(free, odd) == [odd]
    assert not completed(wronger, odd)
    assert completed(replace(wronger, p_repeats=0.5), odd) == [odd]
    assert completed(replace(wronger, drop=900.0), odd) == [odd]
    assert completed(replace(wronger, reasons=(*UNEVEN, IMITATED)), odd) == [odd]
    alike = (AlternativeEffect(odd.term, False),)
    assert completed(odd, weaker, found=[AcceptedEffect(weaker, alike)]) == [weaker]
    assert completed(odd, weaker, found=[AcceptedEffect(decision(), alike)]) == [odd]
    # it explains more than an error of the law leaves of what is found
    for much, passing in ((0.99, [odd]), (1.01, [])):
        before = AcceptedEffect(decision(OTHER, drop=much * odd.drop / rivals.ALIKE))
        assert completed(odd, found=[before]) == passing


def test_one_effect_takes_the_place_of_several_that_imitate_it():
    """By twenty more than they explain together, times its scatter; it was refused for its form
    alone, and is none of them."""
    state = SimpleNamespace(
        whitened=SimpleNamespace(chi2=5000.0), with_term=lambda term, most: (term, most),
        fit_whitened=lambda fit: SimpleNamespace(chi2={"last": 4500.0, "second": 4900.0}[fit]),
    )  # fmt: skip
    second, last = (
        SimpleNamespace(whitened=SimpleNamespace(fit=name)) for name in ("second", "last")
    )
    screen_ = SimpleNamespace(typical=None)
    several = [AcceptedEffect(decision(OTHER))]
    free = [AcceptedEffect(decision(shape("free", LONG.form, generic=True)))]

    def taken(odd, found=several):
        first = SimpleNamespace(state=state, screen=screen_, refits=[decision(OTHER), *odd])
        steps = [first, *(SimpleNamespace(state=s, found=found) for s in (second, last))]
        self = SimpleNamespace(take=lambda *what, misshapen: (*what, misshapen))
        return search._Searcher.single_effect_step(self, steps)

    def odd(drop, dispersion, effect=LONG):
        facts = dict(drop=drop, dispersion=dispersion, reasons=UNEVEN, stretch_q=0.3 * drop)
        return decision(effect, **facts)

    for dispersion, evidence in ((0.5, 20.0), (3.0, 60.0)):
        best = odd(501.0 + evidence, dispersion)
        where, judge, tried, chosen, misshapen = taken([odd(100.0, 1.0), best])
        assert tried == chosen == [(best, (best.term, 2))] and misshapen
        assert where.state is state and judge.without == 5000.0
        assert taken([odd(499.0 + evidence, dispersion)]) is None
    assert taken([]) is None and taken([odd(900.0, 1.0)], free) is None
    assert taken([odd(900.0, 1.0)], [*free, *several]) is not None
    assert taken([odd(900.0, 1.0, OTHER)]) is None


def test_difference_that_is_no_evidence():
    """Twenty, times the scatter; three hundredths of the drop; what makes an effect at all."""
    assert rivals.indecisive_difference(decision(drop=1.0, dispersion=0.2)) == 20.0
    assert rivals.indecisive_difference(decision(drop=1.0, dispersion=3.0)) == 60.0
    assert rivals.indecisive_difference(decision(drop=1e4)) == pytest.approx(300.0)
    before = [decision(drop=4e5), decision(drop=6e5)]
    assert rivals.indecisive_difference(decision(drop=1e4), before) == pytest.approx(3000.0)
    uneven = decision(reasons=UNEVEN[:1], drop=1e4, stretch_q=3.9e3)
    assert rivals.indecisive_difference(uneven) == pytest.approx(3.9e3)


def test_what_is_looked_for_at_many_places_pays_for_it():
    places = shape("places", LONG.form, scanned=classmethod(lambda cls, runs: runs.runs))
    fields = [(n, float, param(0.0, unit="1", bounds=(-1, 1), screen=0.1)) for n in "bcd"]
    four = make_dataclass("four", fields, bases=(places,), frozen=True)
    four.identifier = "four"
    found = search.bonferroni_divisors([LONG, OTHER, places, four], measured(0))
    assert found == {"long": 4, "other": 4, "places": 4 * RUNS, "four": 4 * 4 * RUNS}


def test_first_weights_are_the_smaller_scatter():
    """Second differences of white noise have six times its variance; a trend has none."""
    ball = measured(3, noise=0.0)
    rng = np.random.default_rng(4)
    values = rng.standard_normal((RUNS, 120)) + 9.0 * np.arange(120)
    ball.runs = replace(ball.runs, measured=values[None])
    (level,) = rough_levels(ball)
    assert level == pytest.approx(1.0, rel=0.05)
    spread = values + np.tile([50.0, 0.0, -50.0], CONDITIONS)[:, None]
    ball.runs = replace(ball.runs, measured=spread[None])
    near = np.sqrt(np.mean(np.diff(spread, 2, axis=-1) ** 2) / 6.0)
    assert rough_levels(ball) == pytest.approx([4.0 * near])
    ball.runs = ball.runs.subset(np.arange(0, RUNS, REPEATS))
    near = np.sqrt(np.mean(np.diff(ball.runs.measured, 2, axis=-1) ** 2) / 6.0)
    assert rough_levels(ball) == pytest.approx([near])


def test_pieces_of_the_law_are_set_free_together():
    bent = shape("bent", LONG.form, law=True)
    flat = measured(2, (0.2, LONG.form))
    fitter = Fitter(flat, channel_weights(flat, [0.05]))
    state = make_state(flat, fitter, fitter.fit(start_base(flat)), [])
    last = SimpleNamespace(state=state)
    ended = SimpleNamespace(last=last, effects=[OTHER, bent], model=flat)
    free = search.fit_with_law_effects(ended)
    assert [t.effect for t in free.fit.terms] == [bent]
    assert free.fit.terms[0].size == pytest.approx(0.2, rel=0.1)
    assert (
        search.fit_with_law_effects(SimpleNamespace(last=last, effects=[OTHER], model=flat))
        is None
    )
    last.state = free
    assert search.fit_with_law_effects(ended) is None
