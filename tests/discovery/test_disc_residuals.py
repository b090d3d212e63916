# SPDX-License-Identifier: Apache-2.0
"""What counts as a residual, a base that is far off, and fits that must not raise the error."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from ball import Drag, throw
from shapes import LONG, OTHER, TIME, Sum, measured, wave

from flatplank_analysis.discovery import invariants
from flatplank_analysis.discovery.fit import Fitter, Term
from flatplank_analysis.discovery.model import FormError
from flatplank_analysis.discovery.parameters import Parameter
from flatplank_analysis.discovery.runs import Coordinate
from flatplank_analysis.discovery.state import start_base


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
