# SPDX-License-Identifier: Apache-2.0
"""A campaign on the twin, stopped and resumed; the dry run tells its time."""

from __future__ import annotations

import pytest
import yaml
from camp_plans import LENIENT, ROAD, small

from flatplank_control.bench import campaign_run
from flatplank_control.bench.campaign_run import run_on_twin
from flatplank_control.bench.log import TableLog
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.bench.twin import Twin
from flatplank_control.bench.twin_bench import TwinBench
from flatplank_control.runner.campaign import Conductor, Journal
from flatplank_control.runner.dry_bench import DryBench
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.plans import plan_of

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


def test_a_run_killed_between_journal_and_campaign_file_is_listed_on_resume(tmp_path, monkeypatch):
    """campaign.yaml is that of a campaign that nobody killed."""
    plan = small(ROAD + LENIENT, "runs:\n- {measurement: slip, kappa: 0.05}\n")
    whole, torn = tmp_path / "whole", tmp_path / "torn"

    def campaign(folder):
        journal = Journal(folder / "j.jsonl", plan.name, plan.digest)
        run_on_twin(Conductor(plan, journal), SETUP, folder)

    def killed(*_):
        raise Stopped

    campaign(whole)
    with monkeypatch.context() as patch, pytest.raises(Stopped):
        patch.setattr(campaign_run, "write_campaign", killed)
        campaign(torn)
    assert not (torn / "campaign.yaml").exists()
    campaign(torn)
    listed = (torn / "campaign.yaml").read_text()
    assert len(yaml.safe_load(listed)["runs"]) == 2
    assert listed == (whole / "campaign.yaml").read_text()


@pytest.mark.parametrize("kind", ["slip", "free_rolling"])
def test_the_dry_run_tells_the_time(kind, tmp_path):
    m = Measurement(measurement=kind, kappa=0.05, start=2, step_position=0.3, end_position=0.6)
    twin = TwinBench(Twin(SETUP), TableLog(tmp_path))
    twin.perform(plan_of(m))
    dry = DryBench()
    dry.perform(plan_of(m))
    assert dry.time == pytest.approx(twin.snapshot().encoders.stamp_ns * 1e-9, rel=0.1)
