# SPDX-License-Identifier: Apache-2.0
"""What counts as a residual, a base that is far off, and fits that must not raise the error."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from ball import Drag, throw
from shapes import LONG, TIME, Sum, measured, wave

from flatplank_analysis.discovery import invariants
from flatplank_analysis.discovery.fit import Fitter, Term
from flatplank_analysis.discovery.state import start_base


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
    assert ends == ({"late": f"late = {late:.5g} s (range -0.1 to {upper:g} s)"} if told else {})
