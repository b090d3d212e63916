# SPDX-License-Identifier: Apache-2.0
"""A campaign on the twin, stopped and resumed; the dry run tells its time."""

from __future__ import annotations

from dataclasses import replace

import pyarrow.parquet
import pytest
import yaml
from camp_plans import LENIENT, ROAD, small

from flatplank_control.bench.results import outcome_of
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.cli.operator import print_result_of_plan
from flatplank_control.runner.campaign import Conductor, Job, Journal, Limits, PlannedRun
from flatplank_control.runner.campaign.supervised import Standstill
from flatplank_control.runner.conditions import plank_beyond
from flatplank_control.runner.dry_run import DryBench
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.plans import plan_of
from flatplank_control.runner.steps import Wait
from flatplank_data.campaign import Campaign
from flatplank_sim.twin import log
from flatplank_sim.twin.campaign import run_on_twin
from flatplank_sim.twin.log import BagLog, TableLog
from flatplank_sim.twin.twin import Twin
from flatplank_sim.twin.twin_bench import TwinBench

SETUP = BenchSetup(pace="hold")


class Stopped(Exception):
    pass


def stop_after(count: int):
    def progress(conductor, _job, _outcome):
        if conductor.done == count:
            raise Stopped

    return progress


def test_stopped_resumed_and_nothing_lost(tmp_path):
    plan = small(ROAD + LENIENT)
    for progress in (stop_after(2), lambda *_: None):
        journal = Journal(tmp_path / "j.jsonl", plan.name, plan.digest)
        conductor = Conductor(plan, journal)
        try:
            run_on_twin(conductor, SETUP, tmp_path, progress=progress)
        except Stopped:
            assert conductor.done == 2
    assert conductor.over
    listed = yaml.safe_load((tmp_path / "campaign.yaml").read_text())["runs"]
    files = [run["file"] for run in listed]
    assert len(files) == len(set(files)) == 5
    assert all((tmp_path / name).exists() for name in files)
    slips = [run for run in listed if run["measurement"] == "slip"]
    assert {run["effective_rolling_radius"] for run in slips} == {
        journal.done["r_e.0.0"].facts["radius"]
    }


def test_a_failed_attempt_is_not_analysed(tmp_path):
    strict = LENIENT.replace("speed_error: 1,", "speed_error: 1.0e-9,")
    plan = small(ROAD + strict, runs="runs:\n- {measurement: slip, kappa: 0.05, start: 1}\n")
    journal = Journal(tmp_path / "j.jsonl", plan.name, plan.digest)
    run_on_twin(Conductor(plan, journal), SETUP, tmp_path, bags=True)
    attempts = [done.files for done in journal.done.values()]
    kept, bad = {f[-1] for f in attempts}, {name for f in attempts for name in f[:-1]}
    assert bad
    campaign = Campaign.load(tmp_path)
    assert {run.info.file for run in campaign.runs} == kept
    assert {problem.file for problem in campaign.problems} == bad


def test_a_list_that_a_crash_left_behind_is_made_up_for(tmp_path):
    plan = small(ROAD + LENIENT, runs="runs:\n- {measurement: slip, kappa: 0.05, start: 1}\n")
    journal = Journal(tmp_path / "j.jsonl", plan.name, plan.digest)
    run_on_twin(Conductor(plan, journal), SETUP, tmp_path)
    listing = (tmp_path / "campaign.yaml").read_text()
    (tmp_path / "campaign.yaml").unlink()
    run_on_twin(Conductor(plan, journal), SETUP, tmp_path)
    assert (tmp_path / "campaign.yaml").read_text() == listing


@pytest.mark.parametrize("kind", ["slip", "free_rolling"])
def test_the_dry_run_tells_the_time(kind, tmp_path):
    m = Measurement(measurement=kind, kappa=0.05, start=2, step_position=0.3, end_position=0.6)
    twin = TwinBench(Twin(SETUP), TableLog(tmp_path))
    twin.perform(plan_of(m))
    dry = DryBench()
    dry.perform(plan_of(m))
    assert dry.time == pytest.approx(twin.snapshot().encoders.stamp_ns * 1e-9, rel=0.1)


@pytest.mark.parametrize("log", [TableLog, BagLog])
def test_a_run_that_the_operator_ended_is_judged_up_to_there(log, tmp_path):
    m = Measurement(kappa=0.05, step_position=0.3, end_position=3.0)

    def until(at: float):
        for step in plan_of(m):
            early = isinstance(step, Wait) and step.may_end_early
            yield replace(step, until=plank_beyond(at)) if early else step

    bench = TwinBench(Twin(SETUP), log(tmp_path))
    bench.perform(until(1.0))
    job = Job(PlannedRun("0.0", m, 1), m, 1, ())
    nothing = Standstill("before the run"), Standstill("after the run")
    verdict = outcome_of(bench.kept[0], job, Limits(), *nothing).verdict
    assert verdict.ended == pytest.approx(1.0, abs=0.01)
    assert verdict.ok and verdict.left_out == ("load_drift", "once_per_turn")


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_stopped_run_ends_neither_the_campaign_nor_is_a_result(jobs, tmp_path, capsys):
    """The stiffer tire trips the load rule; nobody can look at the twin and enable it again."""
    runs = "runs:\n- {measurement: slip, kappa: 0.05, start: [1, 2], fz: [3000, 5000]}\n"
    plan = small(ROAD + LENIENT + "attempts: 2\n", runs)
    setup = replace(SETUP, parameters={"wheel_drive": {"fz_trip": 4000.0}})
    journal = Journal(tmp_path / "j.jsonl", plan.name, plan.digest)
    conductor = Conductor(plan, journal)
    told = []
    run_on_twin(
        conductor, setup, tmp_path, bags=True, jobs=jobs,
        progress=lambda _conductor, _job, outcome: told.append(outcome.text()),
    )  # fmt: skip
    assert conductor.over
    stopped = [text for text in told if text.startswith("stopped: ")]
    assert len(stopped) == 2, "both attempts at r_e under the high load"
    assert all("the vertical force is above its limit" in text for text in stopped), stopped
    assert "2 runs that rest on its r_e are skipped" in stopped[-1]
    assert {run.info.fz for run in Campaign.load(tmp_path).runs} == {3000.0}
    assert print_result_of_plan(plan, journal) == 3
    printed = capsys.readouterr().out
    assert "3 of 6 runs" in printed and "1 flagged, 2 skipped" in printed


def test_a_table_does_not_depend_on_its_blocks(tmp_path, monkeypatch):
    """Samples are kept in blocks: a run held as tuples took a third of its time to look after
    them."""
    short = Measurement(measurement="free_rolling", end_position=0.1)
    tables = []
    for block in (log.FLUSH_EVERY, 7, 10**6):
        monkeypatch.setattr(log, "FLUSH_EVERY", block)
        bench = TwinBench(Twin(SETUP), TableLog(tmp_path / str(block)))
        bench.perform(plan_of(short))
        tables.append(pyarrow.parquet.read_table(bench.kept[0]))
    assert tables[0].num_rows > 500
    assert tables[0].equals(tables[1]) and tables[0].equals(tables[2])
