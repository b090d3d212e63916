# SPDX-License-Identifier: Apache-2.0
"""What an earlier runner left behind is made safe before anything else, whatever it left."""

from __future__ import annotations

import asyncio

import pytest
from camp_plans import HEAD

from flatplank_control.nodes import campaign_runner
from flatplank_control.nodes.campaign_runner import CampaignRunner
from flatplank_control.runner.campaign import (
    Conductor,
    Journal,
    Outcome,
    Verdict,
    plan_from_text,
)
from flatplank_control.runner.campaign.quality import Finding
from flatplank_control.runner.steps import Manual, PlanFailed
from flatplank_data.journals import SUFFIX
from flatplank_data.run_record import record_from_dict

GOOD = Verdict((Finding("settling", 1.0, 2.0),))
PARKING = HEAD + "r_e: given\nruns:\n- {{measurement: parking, start: {starts}}}\n"


class PaperBench:
    """Writes down what it is told, and gives up at the first step of a run."""

    def __init__(self) -> None:
        self.axes: tuple[str, ...] = ()
        self.told: list = []

    async def end_safely(self, status: str, _why: str) -> list[str]:
        self.told.append((status, self.axes))
        return []

    async def perform(self, step) -> None:
        self.told.append(step)
        if not isinstance(step, Manual):
            raise PlanFailed("a run has begun")


def killed(folder, text: str, complete: bool) -> None:
    """The runner died in the first run; its bag was closed, or not."""
    plan = plan_from_text(text, "plan")
    job = Conductor(plan, Journal(folder / f"small{SUFFIX}", plan.name, plan.digest)).next_job()
    status = "complete" if complete else "interrupted"
    record = record_from_dict({**job.measurement.record(), "status": status})
    (folder / record.name).mkdir()
    record.save(folder / record.name)


def go_on(folder, text: str, monkeypatch) -> list:
    monkeypatch.setattr(
        campaign_runner, "outcome_of", lambda path, *_: Outcome(path.name, GOOD, {})
    )
    bench = PaperBench()
    runner = CampaignRunner(bench, text, str(folder), resume=True)
    try:
        asyncio.run(runner.run(lambda: None, lambda _text: None))
    except PlanFailed as error:
        assert str(error) == "a run has begun"
    return bench.told


@pytest.mark.parametrize("complete", [True, False])
def test_the_bench_is_made_safe_before_the_next_run(tmp_path, monkeypatch, complete):
    text = PARKING.format(starts=[1, 2])
    killed(tmp_path, text, complete)
    safe, *run = go_on(tmp_path, text, monkeypatch)
    assert safe == ("interrupted", ("steer",))
    assert run and not isinstance(run[0], Manual)


def test_the_last_bag_taken_over_leaves_no_loaded_tire(tmp_path, monkeypatch):
    text = PARKING.format(starts=[1])
    killed(tmp_path, text, complete=True)
    told = go_on(tmp_path, text, monkeypatch)
    assert told == [("interrupted", ("steer",)), Manual("unload", 0.0)]
