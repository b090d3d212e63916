# SPDX-License-Identifier: Apache-2.0
"""Progress, time left and the last words of `flatplank run`."""

from __future__ import annotations

import pytest
from camp_plans import small

from flatplank_control.cli.talk import NOT_ALL_GOOD, Talk, conclude
from flatplank_control.runner.campaign import Conductor, Journal, Outcome, Verdict
from flatplank_control.runner.campaign.quality import Finding

GOOD = Verdict((Finding("settling", 1.0, 2.0),))
BAD = Verdict((Finding("settling", 3.0, 2.0),))


def test_the_time_left_is_told_at_the_pace_so_far(capsys):
    now = [0.0]
    talk = Talk(now=lambda: now[0])
    talk(0, 3, "begun", 300.0)
    now[0] = 60.0  # 100 s of bench time in 60 s
    talk(1, 3, "one", 200.0)
    talk(1, 3, "one", 200.0)
    talk(1, 3, "set it", 200.0, asks=True)
    talk(1, 3, "set it", 200.0, asks=True)
    said = capsys.readouterr().out.splitlines()
    asked = "1/3 set it; 2 min left"
    assert said == ["0/3 begun", "1/3 one; 2 min left", asked, asked]


@pytest.mark.parametrize("verdict, skip, code", [
    (GOOD, False, 0), (BAD, False, NOT_ALL_GOOD), (GOOD, True, NOT_ALL_GOOD),
])  # fmt: skip
def test_flagged_and_skipped_runs_are_named_and_have_an_exit_code(
    tmp_path, capsys, verdict, skip, code
):
    plan = small(
        "r_e: given\nattempts: 1\n",
        "runs:\n- {measurement: slip, start: [1, 2], effective_rolling_radius: 0.31}\n",
    )
    journal = Journal(tmp_path / "j.jsonl", plan.name, plan.digest)
    conductor = Conductor(plan, journal)
    conductor.finish(conductor.take(), Outcome("a", GOOD))
    job = conductor.take()
    if skip:
        conductor.skip(job.run.key, "the operator")
    else:
        conductor.finish(job, Outcome("b", verdict))
    # told from what stands on the disk
    assert conclude(plan, Journal(journal.path, plan.name, plan.digest)) == code
    said = capsys.readouterr().out
    assert f"{1 if skip else 2} of 2 runs in {tmp_path}" in said
    assert ("flagged: b: settling 3 (limit 2)" in said) == (verdict is BAD)
    assert (f"skipped: {job.run.key} (small.yaml:7)" in said) == skip
