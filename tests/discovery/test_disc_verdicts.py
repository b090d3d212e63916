# SPDX-License-Identifier: Apache-2.0
"""What counts as a residual, and the verdict that follows from what was found and what is left."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from ball import Drag, throw
from decisions import decision, rival
from shapes import LONG, OTHER, TIME, Sum, measured, searched, shape, wave

from flatplank_analysis.discovery import invariants, verdict, where
from flatplank_analysis.discovery.decision import UNEVEN
from flatplank_analysis.discovery.fit import Fitter, Term
from flatplank_analysis.discovery.model import FormError
from flatplank_analysis.discovery.parameters import Parameter
from flatplank_analysis.discovery.patterns import Pattern
from flatplank_analysis.discovery.runs import Coordinate
from flatplank_analysis.discovery.sources import source_of
from flatplank_analysis.discovery.state import start_base
from flatplank_analysis.discovery.steps import AcceptedEffect
from flatplank_analysis.discovery.verdict import diagnose as unasked


def test_limits_of_what_counts():
    """Of the floor and of the form of the model; channels of one unit share the largest force."""
    runs = measured(0, noise=0.0).runs
    values = np.stack([runs.measured[0], -10.0 + 0.0 * runs.measured[0]])
    runs = replace(runs, measured=values, channels=("fx", "fy"), units=("N", "N"))
    form = FormError(0.01, 0.02, 0.03, 0.04, side=0.05)
    floors = [SimpleNamespace(floor=2.0), SimpleNamespace(floor=0.1)]
    state = SimpleNamespace(runs=runs, floors=floors, model=SimpleNamespace(form=form))
    assert state.runs.largest == pytest.approx([10.0, 10.0])
    found = invariants.limits(state)
    assert found.rest == pytest.approx(0.6)
    assert found.stretch == pytest.approx(np.hypot(4.0, 0.2))
    assert found.error == pytest.approx(1.1 * np.hypot(2.0, 0.1))
    assert found.bump == pytest.approx(np.hypot(2.0, 0.3))
    assert found.wave == pytest.approx(np.hypot(0.6 * 2.0**0.5, 0.4))
    assert invariants.limits(state, 1).rest == pytest.approx(0.5)
    state.runs = replace(runs, units=("N", "Nm"), input_noise=(1.5, 0.0))
    assert state.runs.largest == pytest.approx([1.0 + 0.1 * 4.0, 10.0])
    error = invariants.limits(state).error
    assert error == pytest.approx(1.1 * np.sqrt(4.0 + 0.014**2 + 1.5**2))


def state_left(varying: float = 0.0, error: float = 0.0, bump: float = 0.0):
    """A state in which nothing is left but this."""
    runs = replace(measured(0).runs, coordinates={})
    level = SimpleNamespace(
        floor=1.0, unexplained=0.0, p_value=1.0, varying=varying, varying_p=1e-9
    )
    found = SimpleNamespace(size=bump, words=lambda: "a bump")
    return SimpleNamespace(
        runs=runs, floors=[level], model=SimpleNamespace(form=FormError()),
        residual=np.full(runs.measured.shape, error), expected_errors=0.0,
        patterns=SimpleNamespace(strongest=lambda *_: found if bump else None),
    )  # fmt: skip


def test_what_is_left_is_said_in_words():
    rest = invariants.residual_of_consequence
    assert rest(state_left(), False) == rest(state_left(), True) == ""
    assert rest(state_left(bump=-2.0), False) == "2.0 is left in z: a bump"
    # ordered differences count where nothing is named, the error where something is
    assert "differs between repeats" in rest(state_left(varying=0.6), False)
    assert rest(state_left(varying=0.59), False) == rest(state_left(varying=0.6), True) == ""
    # where chance is excluded: it is looked for in everything that could differ
    for p_value, told in ((9e-4, True), (1.1e-3, False)):
        by_chance = state_left(varying=5.0)
        by_chance.floors[0].varying_p = p_value
        assert bool(rest(by_chance, False)) == told
    twice = state_left(varying=1.21)
    twice.floors[0].floor = 2.0
    assert rest(twice, False) == "1.2 in z differs between repeats in an ordered way"
    twice.floors[0].varying = 1.19
    assert rest(twice, False) == ""
    assert "more than 1.1 floors" in rest(state_left(error=1.11), True)
    assert rest(state_left(error=1.09), True) == rest(state_left(error=1.11), False) == ""


def test_a_mean_residual_is_told_where_it_is_sure_and_counts():
    def told(unexplained: float, p_value: float) -> str:
        state = state_left()
        vars(state.floors[0]).update(floor=2.3421, unexplained=unexplained, p_value=p_value)
        return invariants.residual_of_consequence(state, True)

    assert told(7.0432, 9e-4) == "7.0 is left in z (floor 2.3)"
    assert told(7.0432, 1.1e-3) == told(0.29 * 2.3421, 9e-4) == ""
    assert told(0.31 * 2.3421, 9e-4) == "0.73 is left in z (floor 2.3)"


def test_a_stretch_is_told_in_floors():
    """A centimetre from node to node nearly; five are off by three floors."""
    state = state_left()
    runs = state.runs
    place = Coordinate(runs.time / 4.0, "m", local=True)
    state.runs = replace(runs, coordinates={"place": place})
    state.floors[0].floor = 1.5
    state.residual = np.zeros(runs.measured.shape)
    state.residual[:, :, 40:55] = 4.5
    state.expected_errors = np.zeros((len(runs.groups), runs.samples))
    other = state.residual.copy()
    fit = SimpleNamespace(residual=lambda _measured: other)
    state.whitened = SimpleNamespace(fit=fit)
    told = invariants.residual_of_consequence(state, True)
    assert told == "a stretch of 5 cm in z is 3.0 floors off"
    # least squares alone give way there, or the two fits do in two places or conditions
    for kept in (0.65 * other, np.roll(other, 30, axis=2), 0.0 * other):
        fit.residual = lambda _measured, kept=kept: kept
        assert not invariants.stretches(state)
    part = np.where((runs.condition == 1)[:, None], other, 0.0)
    fit.residual = lambda _measured: part
    (left,) = invariants.stretches(state)
    assert runs.condition_names[1] in left.conditions and left.level == 4.5
    fit.residual = lambda _measured: other
    state.residual *= 0.65
    assert not invariants.residual_of_consequence(state, False)


def test_a_base_is_far_off_when_it_is_so_everywhere():
    runs = measured(0).runs
    force = np.where(runs.condition == 0, 1.0, 100.0)[:, None] * np.ones(runs.samples)
    runs = replace(runs, measured=np.stack([force, 0.0 * force]), channels=("a", "b"))
    floors = [SimpleNamespace(floor=1.2), SimpleNamespace(floor=1.6)]

    def told(error: float, quiet: float | None = None) -> str:
        residual = np.zeros(runs.measured.shape)
        residual[0] = error
        residual[1, runs.condition == 3] = 2.0 * error
        if quiet is not None:
            residual[:, runs.condition == 5] = quiet
        return invariants.far_off(SimpleNamespace(runs=runs, floors=floors, residual=residual))

    assert told(10.1).endswith(f"of 100 in {runs.condition_names[3]}")
    assert told(10.1).startswith("23 of")
    assert told(9.9) == told(10.1, quiet=3.0) == ""
    # the one that hardly has a force is not asked; five floors of 2 are asked for as well
    floors[0].floor = 3.0
    assert told(10.1) == "" and told(18.0) != ""
    # nor is a tenth of the force far off, however low the floor; the worst is so by its share
    floors[0].floor = 0.1
    assert told(9.9) == "" and told(10.1) != ""
    force[runs.condition == 5] = 20.0
    runs = replace(runs, measured=np.stack([force, 0.0 * force]))
    assert told(12.0).startswith(f"12 of 20 in {runs.condition_names[5]}")


def test_a_fit_must_not_raise_the_error():
    ball = throw(1, 0.02)
    fitter = Fitter(ball, np.ones((1, 1, 1)))
    old = fitter.fit(start_base(ball))
    assert invariants.error_of(fitter, old) == pytest.approx(
        np.sqrt(np.mean((ball.runs.measured[0] - old.predicted[0]) ** 2))
    )
    good = fitter.fit(old.base, [Term(Drag, np.array([0.01]))])
    bad = fitter.fit(np.array([12.0, 0.0]), [Term(Drag, np.array([0.3]))], iterations=0)
    assert invariants.not_raising_error(fitter, old, [bad, good]) is good
    (term,) = invariants.not_raising_error(fitter, old, [bad]).terms
    assert term.values[0] == pytest.approx(good.terms[0].values[0], rel=0.02)
    null = invariants.at_null(good.terms[0])
    assert invariants.is_active(good.terms[0]) and not invariants.is_active(null)


class Two(Sum):
    """A level that both channels share; only the second one feels the effect, beyond 0.05."""

    def predict(self, sets):
        out = np.empty((len(sets), *self.runs.measured.shape))
        for row, one in zip(out, sets, strict=True):
            row[:] = one.base[0] + one.base[1] * TIME
            for _, (size,) in one.effects:
                row[1] += max(size - 0.05, 0.0) * (1.0 + wave(1.5))
        return out


def test_a_gap_of_another_channel_is_not_lost_at_its_null():
    """The level of the first channel is right before, and between both channels afterwards. A fit
    from the null does not find the effect: there it does nothing."""
    runs = measured(24).runs
    x = 1.0 + 0.1 * TIME + 0.0 * runs.measured
    y = 0.9 + 0.1 * TIME + 0.1 * (1.0 + wave(1.5)) + 0.0 * runs.measured
    two = Two(replace(runs, channels=("x", "y"), measured=np.concatenate([x, y])))
    fitter = Fitter(two, np.ones((2, 1, 1)))
    old = fitter.fit(np.array([1.0, 0.1]), iterations=0)
    best = fitter.fit(old.base, [Term(LONG, np.array([0.1]))])
    assert invariants.error_of(fitter, best) > invariants.error_of(fitter, old) + 0.01
    fit = invariants.not_raising_error(fitter, old, [best])
    assert fit.terms[0].values[0] > 0.07
    assert invariants.error_of(fitter, fit) <= invariants.error_of(fitter, old)


def test_fits_that_raise_the_error_are_followed_by_others_in_turn(monkeypatch):
    """With less and less weight of the other channels, from nothing and from what raised it; then
    of the effect alone; last without it."""
    asked, good = [], {}
    old = SimpleNamespace(base="old", terms=(Term(OTHER, np.array([0.3])),), error=1.0)

    class Told:
        def __init__(self, model, weight):
            self.model, self.weight = model, weight

        def fit(self, base, terms, iterations=25):
            asked.append((self.weight.tolist(), base, [t.size for t in terms], iterations))
            error = good.get(len(asked), 2.0)
            return SimpleNamespace(base=base, terms=tuple(terms), error=error)

    def only_last(fitter, _old, terms):
        return fitter.fit("only", terms)

    monkeypatch.setattr(invariants, "Fitter", Told)
    monkeypatch.setattr(invariants, "_fit_only_last", only_last)
    monkeypatch.setattr(invariants, "error_of", lambda fitter, fit: fit.error)
    last = Term(LONG, np.array([0.2]))
    worse = SimpleNamespace(base="worse", terms=(*old.terms, last), chi2=5.0, error=3.0)
    worst = SimpleNamespace(base="worst", terms=(*old.terms, last), chi2=6.0, error=0.5)
    fitter = Told("model", np.array([4.0, 8.0]))
    wanted = [
        ([4.0, 8.0 * tilt], base, [0.3, size], 25)
        for tilt in (1.0, 0.3, 0.1, 0.01)
        for base, size in (("old", 0.0), ("worse", 0.2))
    ]
    wanted += [([4.0, 8.0], "only", [0.3, size], 25) for size in (0.0, 0.2)]
    wanted += [([4.0, 8.0], "old", [0.3, 0.0], 0)]
    # one that does nothing is none, whatever its error
    for low, count in (((), 11), ((1, 3, 9), 11), ((4,), 4), ((10,), 10)):
        asked.clear()
        good.clear()
        good.update(dict.fromkeys(low, 1.0))
        found = invariants.not_raising_error(fitter, old, [worst, worse])
        assert asked == wanted[:count] and len(wanted) == 11
        assert [t.size for t in found.terms] == wanted[count - 1][2]
    worse.error = 1.0
    assert invariants.not_raising_error(fitter, old, [worst, worse]) is worse


@pytest.mark.parametrize(
    ("upper", "late", "told"),
    [
        # a thousandth of the range of 0.2 s; of the unit of 0.01 s where it has no other end
        (0.1, -0.0999, True), (0.1, -0.0997, False), (0.1, 0.0999, True), (0.1, 0.0997, False),
        (np.inf, -0.099992, True), (np.inf, -0.09998, False),
    ],
)  # fmt: skip
def test_a_number_of_the_base_at_an_end_of_its_range_is_told(upper, late, told):
    ball = throw(1, 0.02)
    ball.parameters = (ball.parameters[0], replace(ball.parameters[1], upper=upper))
    fitter = Fitter(ball, np.full((1, 1, 1), 50.0))
    fit = fitter.fit(np.array([14.9, late]), [Term(Drag, np.array([0.0]))], iterations=0)
    ends = invariants.parameters_at_ends(fitter, fit)
    assert ends == ({"late": f"late = {late:.5g} (range -0.1 to {upper:g})"} if told else {})


class Sided(Sum):
    """Level and slope of both channels, and an offset of the second one, which has the effects."""

    parameters = (*Sum.parameters, Parameter("side", "1", 0.0, -5.0, 5.0, 0.1))

    def predict(self, sets):
        out = np.empty((len(sets), *self.runs.measured.shape))
        for row, one in zip(out, sets, strict=True):
            row[:] = one.base[0] + one.base[1] * TIME
            row[1] += one.base[2] + sum(v[0] * e.form(self.setting) for e, v in one.effects)
        return out


def test_only_what_leaves_the_first_channel_alone_is_fitted_with_an_effect():
    """By least squares in the second channel, in which the slope is another one."""
    runs = measured(36).runs
    x = runs.measured[0]
    y = 1.4 - 0.2 * TIME + 0.3 * (1.0 + wave(1.5)) + 0.0 * x
    model = Sided(replace(runs, channels=("x", "y"), measured=np.stack([x, y])))
    parameters = model.parameters
    fitter = Fitter(model, np.array([5.0, 1.0])[:, None, None])
    old = fitter.fit(start_base(model))
    fit = invariants._fit_only_last(
        fitter, old, [Term(OTHER, np.array([0.1])), Term(LONG, np.array([0.0]))]
    )
    assert fit.base[:2].tolist() == old.base[:2].tolist() and model.parameters is parameters
    assert fit.terms[0].size == 0.1 and fit.terms[0].fixed == ()
    rest = y - old.base[0] - old.base[1] * TIME - 0.1 * OTHER.form(model.setting)
    columns = np.stack([np.ones(x.size), LONG.form(model.setting).ravel()], axis=1)
    side, size = np.linalg.lstsq(columns, rest.ravel())[0]
    assert (fit.base[2], fit.terms[1].size) == pytest.approx((side, size), rel=1e-4)
    assert len(fit.free) == 5 and len(fit.jacobian) == 5


def judged(found, left="", lawful=None, unseen=(), refits=(), monkeypatch=None):
    """The verdict where these effects were found and this is left, before and after polishing."""
    state, polished = SimpleNamespace(floors=[SimpleNamespace(floor=1.0)]), object()
    what = {id(state): left, id(polished): lawful}
    monkeypatch.setattr(invariants, "residual_of_consequence", lambda s, _found: what[id(s)])
    monkeypatch.setattr(verdict, "unidentifiable", lambda _screen, _looked_at: list(unseen))
    steps = SimpleNamespace(state=state, found=found, screen=None, refits=refits)
    search = SimpleNamespace(with_law_effects=None if lawful is None else polished, looked_at={})
    return verdict._verdict(search, steps)


def test_verdicts(monkeypatch):
    def told(*given, **more):
        return judged([*given], monkeypatch=monkeypatch, **more)

    one = AcceptedEffect(decision())
    free = AcceptedEffect(decision(shape("free", LONG.form, generic=True)))
    group = replace(one, rivals=tuple(rival(f"r{i}", False, True) for i in range(3)))
    crowd = replace(one, rivals=tuple(rival(f"r{i}", False, True) for i in range(4)))
    assert told()[0] == verdict.AT_FLOOR
    assert told(left="5 N")[0] == verdict.NONE and "5 N" in told(left="5 N")[1]
    slight = [decision(OTHER, reasons=("present, negligible",), drop=d, matters=d) for d in (2, 3)]
    there = "other of 0.1 is in the data, but below the size that matters (3)"
    assert there in told(left="5 N", refits=slight)[1]
    assert "no effect" in told(left="5 N", refits=[decision(reasons=UNEVEN)])[1]
    assert told(left="5 N", lawful="4 N")[0] == verdict.NONE
    assert told(left="5 N", lawful="")[0] == verdict.LAW
    assert "machine is in order" in told(left="5 N", lawful="")[1]
    assert "machine is in order" not in told(left="5 N", lawful="", unseen=["slow"])[1]
    assert told(free)[0] == told(free, left="5 N", lawful="")[0] == verdict.LAW
    assert told(free, left="5 N")[0] == verdict.PARTLY
    assert told(one, left="5 N") == (verdict.PARTLY, "5 N")
    assert "another form" in told(one, left="5 N", lawful="")[1]
    assert told(one)[0] == told(one, free)[0] == verdict.FOUND
    assert told(one, group)[0] == verdict.GROUP and "cannot be told apart" in told(group)[1]
    assert "more than four" in told(crowd)[1] and "more than four" not in told(group)[1]


def test_the_clearest_pattern_is_told_where_something_is_left(monkeypatch):
    """Its place is that of the maps, and the period that of a wave; without one a period counts
    from a fifth of the energy on."""
    search = searched(measured(0), LONG)  # its verdicts are made up: `conftest.py` does not ask
    facts = dict(coordinate="time", unit="s", start=1.0, end=1.5, size=0.2, under="", p_value=1e-9)
    wave_, bump = (Pattern(period=period, **facts) for period in (0.31, np.nan))

    def told(name, pattern, reason="5 N", share=0.21):
        state = search.last.state
        known = SimpleNamespace(
            strongest=lambda *_: pattern, ranges=lambda p: {"time": (p.start, p.end)}
        )
        monkeypatch.setitem(vars(state), "patterns", known)
        monkeypatch.setattr(verdict, "_verdict", lambda *_: (name, reason))
        monkeypatch.setattr(verdict, "_period", lambda *_: (0.08, share))
        found = unasked(search)
        place = found.maps[0].place if found.maps[0].place == (1.0, 1.5) else None
        return found.reason, found.period, place

    near = pytest.approx
    for name in (verdict.NONE, verdict.PARTLY):
        assert told(name, None) == ("5 N", 0.08, None)
        assert told(name, None, share=0.19) == ("5 N", near(np.nan, nan_ok=True), None)
        words = "5 N; clearest is a wave of 0.31 s over time"
        assert told(name, wave_, share=0.0) == (words, 0.31, (1.0, 1.5))
        words = "5 N; clearest is a bump over time within 1 to 1.5 s"
        assert told(name, bump) == (words, 0.08, (1.0, 1.5))
        assert told(name, bump, bump.words()) == (bump.words(), 0.08, (1.0, 1.5))
    assert told(verdict.AT_FLOOR, wave_, share=0.0)[0] == "5 N"


def test_the_law_is_fitted_where_something_is_left(monkeypatch):
    """Where nothing can be named, only the first step is told, and no law is asked."""
    monkeypatch.setattr(verdict, "fit_with_law_effects", lambda search: "fitted")
    monkeypatch.setattr(verdict, "_verdict", lambda *_: (verdict.AT_FLOOR, "nothing"))
    for left, off, fitted in (("5 N", "", "fitted"), ("", "", None), ("5 N", "far", None)):
        search = searched(measured(1, (0.05, LONG.form)), LONG)
        monkeypatch.setattr(invariants, "residual_of_consequence", lambda *_, left=left: left)
        monkeypatch.setattr(invariants, "far_off", lambda _state, off=off: off)
        found = unasked(search)
        assert found.search.with_law_effects == fitted
        assert len(found.search.steps) == len(found.found) + 1 == (1 if off else 2)
        assert found.verdict == (verdict.UNDECIDED if off else verdict.AT_FLOOR)
        before = search.steps[0].state
        assert found.rmse_before == found.search.model.runs.rmse(before.residual[0])
        assert (found.rmse_after == found.rmse_before) == bool(off)


def test_a_campaign_that_cannot_be_decided_is_told_with_its_source():
    runs = measured(0).runs.subset(np.arange(0, 9, 3))
    told = verdict.undecidable_diagnosis(runs, 2.0).to_dict()
    assert told["verdict"] == verdict.UNDECIDED and told["reason"] == verdict.undecidable(runs)
    assert told["effects"] == [] and told["seconds"] == 2.0 and told["runs"] == 0
    assert source_of(runs).to_dict().items() <= told.items()


def test_programs_get_six_digits_and_nothing_where_there_is_no_number():
    none = verdict.undecidable_diagnosis(measured(0).runs, 2.3456)
    numbers = {
        "floor": "floor_rmse", "rmse_before": "rmse_before", "rmse_after": "rmse_after",
        "held_out_before": "held_out_before", "held_out_after": "held_out_after",
    }  # fmt: skip
    left = {"unexplained": "rmse", "varying": "varying", "period": "period"}
    left["coherence"] = "coherence"
    told = none.to_dict()
    assert told["seconds"] == 2.35 and told["limits"] is None and told["detectable"] == {}
    assert [told[key] for key in numbers.values()] == [None] * len(numbers)
    assert [told["unexplained"][key] for key in left.values()] == [None] * len(left)
    names = [*numbers, *left]
    given = {name: (i + 1) * 1.23456789 for i, name in enumerate(names)}
    limits = invariants.Limits(*(0.12345671 * i for i in range(1, 6)))
    sizes = {"drag": (0.01234567, "1/m")}
    told = replace(none, limits=limits, detectable=sizes, notes=("a", "b"), **given).to_dict()
    values = [told[key] for key in numbers.values()]
    values += [told["unexplained"][key] for key in left.values()]
    assert values == [float(f"{given[name]:.6g}") for name in names]
    assert told["limits"] == {
        "rest": 0.123457, "stretch": 0.246913, "error_found": 0.37037, "bump": 0.493827,
        "wave": 0.617284,
    }  # fmt: skip
    assert told["detectable"] == {"drag": {"size": 0.0123457, "unit": "1/m"}}
    assert told["notes"] == ["a", "b"]


def test_programs_get_what_is_known_of_an_effect():
    others = (rival("alike", False, True), rival("like", True, True), rival("else", True, False))
    found = AcceptedEffect(
        decision(size=0.123456789, held_out_gain=0.5123456, p_repeats=1.23456e-7), rivals=others
    )
    told = verdict.effect_dict(found)
    assert (told["name"], told["kind"], told["unit"]) == ("long", "machine", "1")
    assert told["size"] == told["parameters"]["a"] == 0.123457
    assert told["interval"] == [0.0617284, 0.185185] and told["held_out_gain"] == 0.512346
    assert told["p_value"] == 1.23e-7
    assert told["class"] == ["alike"] and told["weakly"] == ["like"]
    assert [a["name"] for a in told["advice"]] == ["long", "alike"]


def test_programs_get_the_four_clearest_places_of_a_residual():
    runs = measured(0).runs.subset(np.arange(0, 9, 3))
    bins = np.linspace(0.0, 2.0, 3)
    maps = [
        where.Map(name, "m", bins, np.zeros((3, 2)), np.zeros(2), 0.0, 1.0, (0.5, 1.25), 0.75)
        for name in "abcdef"
    ]
    told = replace(verdict.undecidable_diagnosis(runs, 2.0), maps=tuple(maps)).to_dict()
    assert [m["coordinate"] for m in told["unexplained"]["where"]] == ["a", "b", "c", "d"]
    assert told["unexplained"]["where"][0]["range"] == [0.5, 1.25]
    assert told["unexplained"]["where"][0]["share"] == 0.75


def test_why_a_campaign_cannot_be_decided():
    runs = measured(0).runs
    assert verdict.undecidable(runs) == verdict.undecidable(runs.subset(np.arange(6))) == ""
    assert verdict.undecidable(replace(runs, contradicted=("one", "other"))) == "one; other"
    assert verdict.undecidable(runs.subset(np.arange(5))).startswith("5 runs: at least 6 ")
    same = np.zeros(runs.runs, dtype=int)
    one = replace(runs, condition=same, condition_names=("one",))
    assert verdict.undecidable(one).startswith("one condition only")


def test_a_base_that_is_far_off_is_told_with_what_was_tried(monkeypatch):
    monkeypatch.setattr(
        invariants, "far_off", lambda state: {"off": "9 of 10 in x"}.get(state, "")
    )
    found = [AcceptedEffect(decision()), AcceptedEffect(decision(OTHER))]

    def told(state, effects):
        last = SimpleNamespace(state=state, found=effects)
        model = SimpleNamespace(runs=measured(0).runs)
        return verdict._unsettled(SimpleNamespace(model=model, last=last, starts=3))

    assert told("near", found) == ("", "")
    name, why = told("off", found)
    assert name == verdict.UNDECIDED and "worst 9 of 10 in x; tried: 3 starts of the base, " in why
    assert "and beside it long, other;" in why and "beside" not in told("off", [])[1]


def test_what_stands_beside_a_verdict(monkeypatch):
    """One step position, what the tire imitates, wrong forms, and numbers at their ends."""
    ends = {"white": {"g": "g = 15", "late": "late = 0.1"}, "plain": {"late": "late = 0.1"}}
    monkeypatch.setattr(invariants, "parameters_at_ends", lambda _fitter, fit: ends.get(fit, {}))
    monkeypatch.setattr(verdict, "unidentifiable", lambda _screen, looked: looked["names"])

    def notes(steps=(), unseen=(), found=(), fits=("", "")):
        state = SimpleNamespace(fitter=None, whitened=SimpleNamespace(fit=fits[0]), fit=fits[1])
        last = SimpleNamespace(state=state, screen=None, found=found)
        runs = SimpleNamespace(facts={"step": np.array(steps)} if steps else {})
        search = SimpleNamespace(last=last, looked_at={"names": list(unseen)})
        return list(verdict._notes(runs, search))

    assert notes() == notes(steps=(1.0, 1.06)) == notes(steps=(np.nan, np.nan)) == []
    for steps in ((1.0, 1.04, np.nan), (2.0,)):
        (note,) = notes(steps=steps)
        assert note.startswith("one step position in all runs")
    (note,) = notes(unseen=["slow", "fast"])
    assert note.startswith("what is left points to slow, fast, but ")
    wrong = AcceptedEffect(decision(reasons=UNEVEN, stretch_q=200.0))
    (note,) = notes(found=[AcceptedEffect(decision(OTHER)), wrong])
    assert note.startswith(f"long: {UNEVEN[0]}, {UNEVEN[1]}; ")
    assert notes(fits=("white", "plain")) == ["at an end of its range: g = 15, late = 0.1"]
    assert notes(fits=("", "plain")) == ["at an end of its range: late = 0.1"]


def test_a_period_is_looked_for_only_where_something_is_left():
    """Over the plank; a wave of 8 cm in every condition."""
    runs = measured(0).runs
    place = np.linspace(0.0, 4.0, 480) * np.ones((runs.runs, 1))
    runs = replace(
        runs, measured=np.zeros((1, *place.shape)), time=place,
        coordinates={"plank position": Coordinate(place, "m", local=True)},
    )  # fmt: skip
    residual = np.cos(2.0 * np.pi * place / 0.08)
    for name in (verdict.NONE, verdict.PARTLY):
        period, share = verdict._period(runs, residual, name)
        assert period == pytest.approx(0.08, rel=0.01) and share == pytest.approx(1.0, rel=0.05)
    # the shortest that is looked for is 15 mm
    short = np.cos(2.0 * np.pi * place / 0.024)
    assert verdict._period(runs, short, verdict.NONE)[0] == pytest.approx(0.024, rel=0.01)
    elsewhere = replace(runs, coordinates={"angle": runs.coordinates["plank position"]})
    for told in (
        verdict._period(runs, residual, verdict.AT_FLOOR),
        verdict._period(elsewhere, residual, verdict.NONE),
    ):
        assert np.isnan(told[0]) and told[1] == 0.0
