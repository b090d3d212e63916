# SPDX-License-Identifier: Apache-2.0
"""What counts as a residual, and the verdict that follows from what was found and what is left."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from ball import Drag, throw
from decisions import decision, rival
from shapes import LONG, OTHER, TIME, Sum, measured, shape, wave

from flatplank_analysis.discovery import invariants, verdict, where
from flatplank_analysis.discovery.decide import UNEVEN
from flatplank_analysis.discovery.fit import Fitter, Term
from flatplank_analysis.discovery.model import FormError
from flatplank_analysis.discovery.runs import Coordinate
from flatplank_analysis.discovery.sources import source_of
from flatplank_analysis.discovery.state import start_base
from flatplank_analysis.discovery.steps import AcceptedEffect


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
    level = SimpleNamespace(floor=1.0, unexplained=0.0, p_value=1.0, varying=varying)
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
    told = invariants.residual_of_consequence(state, True)
    assert told == "a stretch of 5 cm in z is 3.0 floors off"
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


def test_a_campaign_that_cannot_be_decided_is_told_with_its_source():
    runs = measured(0).runs.subset(np.arange(0, 9, 3))
    told = verdict.undecidable_diagnosis(runs, 2.0).to_dict()
    assert told["verdict"] == verdict.UNDECIDED and told["reason"] == verdict.undecidable(runs)
    assert told["effects"] == [] and told["seconds"] == 2.0 and told["runs"] == 0
    assert source_of(runs).to_dict().items() <= told.items()


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
