# SPDX-License-Identifier: Apache-2.0
"""Progress, time left and the last words of `flatplank run`."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from camp_plans import small

from flatplank_control.cli.operator import (
    NOT_ALL_GOOD,
    OF_A_RUN,
    ProgressPrinter,
    call_service_of_key,
    print_result_of_plan,
)
from flatplank_control.cli.run import schedule_bad_runs_again
from flatplank_control.runner.campaign import Conductor, Journal, Outcome, Verdict
from flatplank_control.runner.campaign.quality import Finding
from flatplank_data.journals import SUFFIX

GOOD = Verdict((Finding("settling", 1.0, 2.0),))
BAD = Verdict((Finding("settling", 3.0, 2.0),))


def test_the_time_left_is_told_at_the_pace_so_far(capsys):
    now = [0.0]
    talk = ProgressPrinter(now=lambda: now[0])
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
    conductor.finish(conductor.next_job(), Outcome("a", GOOD))
    job = conductor.next_job()
    if skip:
        conductor.skip(job.run.key, "the operator")
    else:
        conductor.finish(job, Outcome("b", verdict))
    # told from what stands on the disk
    assert print_result_of_plan(plan, Journal(journal.path, plan.name, plan.digest)) == code
    said = capsys.readouterr().out
    assert f"{1 if skip else 2} of 2 runs in {tmp_path}" in said
    assert ("flagged: b: settling 3 (limit 2)" in said) == (verdict is BAD)
    assert (f"skipped: {job.run.key} (small.yaml:7)" in said) == skip


def three_runs(folder):
    plan = small(
        "r_e: given\nattempts: 1\n",
        "runs:\n- {measurement: slip, start: [1, 2, 3], effective_rolling_radius: 0.31}\n",
    )
    return plan, Journal(folder / f"{plan.name}{SUFFIX}", plan.name, plan.digest)


def test_flagged_and_skipped_runs_are_made_once_more(tmp_path, capsys):
    plan, journal = three_runs(tmp_path)
    conductor = Conductor(plan, journal)
    conductor.finish(conductor.next_job(), Outcome("a", GOOD))
    flagged = conductor.next_job()
    conductor.finish(flagged, Outcome("b", BAD))
    skipped = conductor.next_job()
    conductor.skip(skipped.run.key, "the operator")
    schedule_bad_runs_again(plan, tmp_path)
    assert capsys.readouterr().out == "2 flagged or skipped runs are made once more\n"
    _, journal = three_runs(tmp_path)
    conductor = Conductor(plan, journal)
    assert [done.valid_file for done in conductor.kept()] == ["a", "b"], "until there is a new one"
    again = conductor.next_job()
    assert (again.run.key, again.attempt) == (flagged.run.key, 2)
    assert again.measurement.name == f"{flagged.measurement.name}_r02"
    conductor.finish(again, Outcome("b_r02", GOOD))
    last = conductor.next_job()
    assert (last.run.key, last.measurement.name) == (skipped.run.key, skipped.measurement.name)
    conductor.finish(last, Outcome("c", BAD))
    assert conductor.over
    assert [done.valid_file for done in conductor.kept()] == ["a", "b_r02", "c"]
    assert print_result_of_plan(plan, three_runs(tmp_path)[1]) == NOT_ALL_GOOD
    assert "1 flagged, 0 skipped: " in capsys.readouterr().out


def test_nothing_can_be_made_once_more_before_it_was_made(tmp_path):
    plan, _ = three_runs(tmp_path / "elsewhere")
    with pytest.raises(ValueError, match="has no runs of this plan yet; leave it out"):
        schedule_bad_runs_again(plan, tmp_path)
    assert not list(tmp_path.glob(f"*{SUFFIX}"))


def test_a_key_is_one_service_of_the_runner(capsys):
    class Runner:
        def __init__(self) -> None:
            self.asked: list[str] = []

        def call(self, _kind, name):
            self.asked.append(name)
            return SimpleNamespace(success=len(self.asked) > 1, message="nothing is being asked")

    runner = Runner()
    for key in ("", "x", "r", "c", "e"):
        call_service_of_key(runner, OF_A_RUN, key)
    assert runner.asked == ["measurement_runner/confirm", "measurement_runner/enough"]
    said = capsys.readouterr().out.splitlines()
    assert said == ["nothing is being asked", OF_A_RUN["e"].text]
