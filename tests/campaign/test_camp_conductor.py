# SPDX-License-Identifier: Apache-2.0
"""No run is lost or doubled, whatever stops a campaign."""

from __future__ import annotations

import pytest
import yaml
from camp_plans import small

from flatplank_control.bench.results import write_kept_runs
from flatplank_control.runner.campaign import Conductor, Journal, Outcome, Verdict
from flatplank_control.runner.campaign.conductor import unwritten
from flatplank_control.runner.campaign.journal import pressure_after, write_note
from flatplank_control.runner.campaign.quality import Finding
from flatplank_data.run_record import load_record, record_from_dict

GOOD = Verdict((Finding("settling", 1.0, 2.0),))
BAD = Verdict((Finding("settling", 3.0, 2.0),))


def journal(folder, plan) -> Journal:
    return Journal(folder / "j.jsonl", plan.name, plan.digest)


def outcome(job, verdict=GOOD) -> Outcome:
    radius = {"radius": 0.31} if job.measurement.measurement == "free_rolling" else {}
    return Outcome(job.measurement.name, verdict, radius)


def test_a_campaign_from_beginning_to_end(tmp_path):
    plan = small()
    conductor = Conductor(plan, journal(tmp_path, plan))
    names = []
    while job := conductor.next_job():
        names.append(job.measurement.name)
        conductor.finish(job, outcome(job))
        assert conductor.done == len(names)
    assert conductor.over and len(set(names)) == len(plan.runs) == 5
    assert names[0].startswith("TOY_ERR_REL")


def test_slip_runs_wait_for_their_radius_and_use_it(tmp_path):
    plan = small()
    conductor = Conductor(plan, journal(tmp_path, plan))
    first = conductor.next_job()
    assert conductor.next_job() is None
    conductor.finish(first, outcome(first))
    job = conductor.next_job()
    assert job.measurement.effective_rolling_radius == 0.31
    assert job.measurement.r_e_source == first.measurement.name


def test_a_bad_run_is_made_again_under_another_name_and_then_kept_flagged(tmp_path):
    plan = small("attempts: 2\n")
    conductor = Conductor(plan, journal(tmp_path, plan))
    first = conductor.next_job()
    conductor.finish(first, outcome(first, BAD))
    assert conductor.done == 0
    second = conductor.next_job()
    assert second.run == first.run and second.attempt == 2
    assert second.measurement.name == first.measurement.name + "_r02"
    conductor.finish(second, outcome(second, BAD))
    assert conductor.done == 1
    assert not conductor.journal.done[first.run.key].facts["good"]


def test_kept_is_the_last_attempt_of_what_is_done(tmp_path):
    plan = small("attempts: 2\n", runs="runs:\n- {measurement: slip, kappa: [0.0, 0.05, 0.1]}\n")
    conductor = Conductor(plan, journal(tmp_path, plan))
    conductor.finish(radius := conductor.next_job(), outcome(radius))
    for _ in range(2):
        conductor.finish(job := conductor.next_job(), outcome(job, BAD))
    conductor.finish(left := conductor.next_job(), outcome(left, BAD))
    conductor.skip(left.run.key, "by the operator")
    again = Conductor(plan, journal(tmp_path, plan))
    assert [(done.record, done.valid_file) for done in again.kept()] == [
        (radius.measurement.record(), radius.measurement.name),
        (job.measurement.record(), job.measurement.name),
    ]
    assert job.attempt == 2


def campaign_file(folder) -> list[dict]:
    return yaml.safe_load((folder / "campaign.yaml").read_text())["runs"]


def test_the_list_of_the_campaign_says_what_each_run_was_made_with(tmp_path):
    """Not what the latest one was: road that the paper had seen, r_e."""
    plan = small("session: {sliding_distance: 12.5}\n")
    conductor = Conductor(plan, journal(tmp_path, plan))
    while job := conductor.next_job():
        made = Outcome(job.measurement.name, GOOD, {"radius": 0.31, "travel": 4.0})
        conductor.finish(job, made)
        write_kept_runs(conductor, tmp_path)
    listed = [run["parameters"]["session"]["sliding_distance"] for run in campaign_file(tmp_path)]
    assert listed == [12.5, 16.5, 20.5, 24.5, 28.5]


@pytest.mark.parametrize(("then", "more"), [(0.3101, 0), (0.3110, 4)])
def test_slips_are_made_again_when_their_radius_is_another_by_more_than_slip_is_kept(
    tmp_path, then, more
):
    plan = small("attempts: 1\n")
    conductor = Conductor(plan, journal(tmp_path, plan))
    first = conductor.next_job()
    conductor.finish(first, Outcome("r", BAD, {"radius": 0.31}))
    while job := conductor.next_job():
        conductor.finish(job, outcome(job))
    write_kept_runs(conductor, tmp_path)
    slips = campaign_file(tmp_path)[1:]
    conductor.journal.schedule_again(first.run.key)
    conductor = Conductor(plan, journal(tmp_path, plan))
    write_kept_runs(conductor, tmp_path)
    assert campaign_file(tmp_path)[1:] == slips and conductor.done == 4
    found = conductor.finish(conductor.next_job(), Outcome("r_r02", GOOD, {"radius": then}))
    assert (f"{more} runs that rest on the old one are made again" in found.text()) == bool(more)
    # after a crash as well
    conductor = Conductor(plan, journal(tmp_path, plan))
    assert conductor.done == 5 - more
    while job := conductor.next_job():
        assert job.measurement.effective_rolling_radius == then
        assert job.measurement.name.endswith("_r02") and job.measurement.r_e_source == "r_r02"
        conductor.finish(job, outcome(job))
    write_kept_runs(conductor, tmp_path)
    listed = campaign_file(tmp_path)
    assert listed[0]["file"] == "r_r02" and len(listed) == 5
    assert {run["effective_rolling_radius"] for run in listed[1:]} == {then if more else 0.31}
    assert sum(run["file"].endswith("_r02") for run in listed[1:]) == more


@pytest.mark.parametrize("torn", [False, True])
@pytest.mark.parametrize("until", range(5))
def test_resume_after_a_crash_at_any_run(tmp_path, until, torn):
    plan = small()
    conductor = Conductor(plan, journal(tmp_path, plan))
    made = []
    for _ in range(until):
        job = conductor.next_job()
        conductor.finish(job, outcome(job))
        made.append(job.run.key)
    lost = conductor.next_job()
    if torn:
        with open(tmp_path / "j.jsonl", "a") as file:
            file.write('{"event": "end", "run": "')
    again = Conductor(plan, journal(tmp_path, plan))
    assert again.journal.interrupted == lost.run.key
    assert again.done == until
    while job := again.next_job():
        again.finish(job, outcome(job))
        made.append(job.run.key)
    assert sorted(made) == sorted(run.key for run in plan.runs)
    third = Conductor(plan, journal(tmp_path, plan))
    assert third.over and third.next_job() is None


def test_a_journal_of_another_plan_is_refused(tmp_path):
    journal(tmp_path, small())
    with pytest.raises(ValueError, match="belongs to another version of the plan"):
        journal(tmp_path, small("attempts: 3\n"))


def test_skipping_a_radius_run_skips_what_needs_it(tmp_path):
    plan = small()
    conductor = Conductor(plan, journal(tmp_path, plan))
    conductor.skip(conductor.next_job().run.key, "the operator")
    assert conductor.over


def test_notes_of_the_operator_do_not_disturb_a_resume(tmp_path):
    plan = small()
    journal(tmp_path, plan)
    write_note(tmp_path / "j.jsonl", " a bump at 2 m ")
    assert Conductor(plan, journal(tmp_path, plan)).done == 0


def test_earlier_runs_of_a_condition_are_handed_to_the_judge(tmp_path):
    plan = small(runs="runs:\n- {measurement: slip, kappa: 0.05, repeats: 3}\n")
    conductor = Conductor(plan, journal(tmp_path, plan))
    seen = []
    while job := conductor.next_job():
        seen.append(len(job.earlier))
        facts = {"profile": [1.0], "radius": 0.31}
        conductor.finish(job, Outcome(job.measurement.name, GOOD, facts))
    assert seen == [0, 0, 1, 2]


def test_each_record_says_what_road_the_paper_has_seen(tmp_path):
    """Also of runs that were not kept, and after a resume."""
    plan = small("session: {paper_batch: P3, sliding_distance: 12.5}\n")
    conductor = Conductor(plan, journal(tmp_path, plan))
    for verdict, before in ((BAD, 12.5), (GOOD, 16.6)):
        job = conductor.next_job()
        session = job.measurement.record()["parameters"]["session"]
        assert session == {"paper_batch": "P3", "sliding_distance": before}
        facts = {"radius": 0.31, "travel": 4.1}
        conductor.finish(job, Outcome(job.measurement.name, verdict, facts))
    again = Conductor(plan, journal(tmp_path, plan)).next_job()
    assert again.measurement.session["sliding_distance"] == 20.7


def test_the_pressure_after_a_run_goes_into_its_record(tmp_path):
    plan = small("session: {rim: 6Jx15}\n")
    conductor = Conductor(plan, journal(tmp_path, plan))
    path = tmp_path / "j.jsonl"
    with pytest.raises(ValueError, match="no run is over yet"):
        pressure_after(path, "2.48")
    job = conductor.next_job()
    record_from_dict(job.measurement.record()).save(_made(tmp_path / job.measurement.name))
    conductor.finish(job, outcome(job))
    assert pressure_after(path, " 2.48 ") == job.measurement.name
    session = load_record(tmp_path / job.measurement.name).parameters["session"]
    assert session == {"rim": "6Jx15", "sliding_distance": 0.0, "pressure_after": 2.48}
    with pytest.raises(ValueError, match="pressure 'two': give 0.3 .. 6 bar"):
        pressure_after(path, "two")
    assert Conductor(plan, journal(tmp_path, plan)).done == 1


def _made(folder):
    folder.mkdir()
    return folder


def test_a_bag_whose_line_was_never_written_is_taken_over(tmp_path):
    """The runner died between the two: the run is neither lost nor made twice."""
    plan = small()
    first = journal(tmp_path, plan)
    conductor = Conductor(plan, first)
    job = conductor.next_job()
    record = record_from_dict({**job.measurement.record(), "status": "complete"})
    again = journal(tmp_path, plan)
    resumed = Conductor(plan, again)
    same = resumed.next_job(again.interrupted)
    assert same.run.key == job.run.key
    assert unwritten(tmp_path, same, again) is None
    # an interrupted attempt lies beside it under the first name
    for name, status in ((record.name, "interrupted"), (f"{record.name}_r02", "complete")):
        (tmp_path / name).mkdir()
        record.with_changes(status=status, name=name).save(tmp_path / name)
    found = unwritten(tmp_path, same, again)
    assert found == tmp_path / f"{record.name}_r02"
    resumed.finish(same, Outcome(found.name, GOOD, {"radius": 0.31}))
    assert unwritten(tmp_path, same, again) is None
