# SPDX-License-Identifier: Apache-2.0
"""A goal says what it wants, and how far it is."""

from __future__ import annotations

import pytest

from flatplank_control.runner.dry_run import Progress, dry_run_progress
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.plans import PLANS, mapping_of, measurement_of, plan_of


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "empty; state what to measure"),
        ("{}", "empty; state what to measure"),
        ("# nothing\n", "empty; state what to measure"),
        ("just text", "'just text' is no plan"),
        ("[1, 2]", "is no plan"),
        ("5", "'5' is no plan"),
        ("a: [", "not YAML"),
        ("{fz: 3700}", "states how, but not what to measure"),
        ("{kapa: 1}", "unknown key 'kapa'"),
        ("{measurement: slipp}", "measurement is 'slipp'"),
        ("{kappa: foo}", "kappa is 'foo', must be a number"),
    ],
)
def test_a_goal_that_says_nothing_is_refused_in_one_line(text, reason):
    with pytest.raises(ValueError, match=".") as refused:
        measurement_of(mapping_of(text))
    assert reason in str(refused.value) and "\n" not in str(refused.value)


def test_a_slip_or_a_kind_is_enough():
    assert measurement_of(mapping_of("{kappa: 0.05}")).measurement == "slip"
    assert measurement_of(mapping_of("{measurement: free_rolling}")).kappa == 0.0


@pytest.mark.parametrize("kind", PLANS)
def test_progress_goes_from_nothing_to_all(kind):
    wanted = Measurement(measurement=kind, profile_parameters={})
    steps = len(list(plan_of(wanted)))
    progress = dry_run_progress(plan_of(wanted))
    done = [progress.done(k) for k in range(steps + 1)]
    assert done == sorted(done) and done[0] == 0.0 and done[-1] == pytest.approx(1.0)
    left = [progress.left(k) for k in range(steps + 1)]
    assert left == sorted(left, reverse=True) and left[-1] == pytest.approx(0.0)
    assert left[0] == pytest.approx(progress.total) and progress.total > 10.0


def test_time_within_a_step_counts_up_to_its_end():
    progress = Progress([10.0, 110.0, 120.0])
    assert progress.left(1, 30.0) == 80.0 and progress.done(1, 50.0) == 0.5
    assert progress.left(1, 500.0) == 10.0, "a step that takes longer than on paper"
