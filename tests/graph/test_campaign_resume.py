# SPDX-License-Identifier: Apache-2.0
"""A campaign on the graph, resumed after `kill -9` of the runner: no run lost, none doubled."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import pytest
from bench_graph import graph

from flatplank_control.cli.run import find_plan
from flatplank_control.nodes import client
from flatplank_control.nodes.client import BenchError
from flatplank_control.runner.campaign import Journal, plan_from_text
from flatplank_data.campaign import Campaign
from flatplank_data.run_record import load_record

pytestmark = pytest.mark.graph
PLAN = """
format: flatplank-plan/1
name: resumed
tire: TOY
attempts: 1
common: {{step_position: 0.03, end_position: 0.23}}
quality: {{settling: 10000, load_error: 1, load_drift: 1, force_error: 1000, plateau: 10,
          repeatability: 10000, speed_error: 1, once_per_turn: 10000}}
runs:
- measurement: slip
  kappa: {slips}
  start: [1]
"""


class Kill:
    """Kills the runner once, in the middle of a run."""

    def __init__(self, bench, after: int) -> None:
        self.bench, self.left, self.done = bench, after, False

    def __call__(self, text: str) -> None:
        if text.startswith("slip"):
            self.left -= 1
        if self.left == 0 and not self.done:
            self.done = True
            runner = self.bench.processes.running["measurement_runner"]
            runner.kill()
            runner.wait()


def twelve() -> str:
    """The first twelve slip runs of the shipped longitudinal plan, with the run that gives r_e."""
    text = find_plan("toyo_longitudinal").read_text(encoding="utf-8")
    text = text.replace("name: toyo_longitudinal", "name: resumed")
    text = re.sub("pressure: .*", "pressure: 2.5", text)
    text = re.sub("fz: .*", "fz: 3700", text)
    return re.sub("kappa: .*", "kappa: [0.0, 0.01, -0.01, 0.02]", text)


def resumed(folder: Path, monkeypatch, text: str, kill_in: int) -> None:
    plan = plan_from_text(text, "plan")
    data = folder / "data"
    # the middleware needs 20 s to notice, which is long enough
    monkeypatch.setattr(client, "SERVER_GONE", 1.0)
    with graph(folder, monkeypatch, separate=("measurement_runner",)) as bench:
        measure = bench.client.measure
        with pytest.raises(BenchError, match="the runner has gone"):
            measure(text, simulated=True, folder=str(data), say=Kill(bench, kill_in))
        bench.processes.start_process("measurement_runner")
        bench.client.wait_connected(bench.processes)
        said: list[str] = []
        measure(text, simulated=True, folder=str(data), resume=True, say=said.append)
    assert any("interrupted" in line for line in said), said
    assert not [line for line in said if "nothing is being recorded" in line], said
    journal = Journal(data / "resumed.journal.jsonl", plan.name, plan.digest)
    assert all(journal.finished(run.key) for run in plan.runs)
    assert all(
        len(journal.done[run.key].files) == journal.done[run.key].attempts for run in plan.runs
    )
    bags = [p for p in data.iterdir() if (p / "run.yaml").exists()]
    status = Counter(load_record(bag).status for bag in bags)
    # the runner may die before or after its recording has begun
    assert status.pop("complete") == sum(done.attempts for done in journal.done.values())
    assert set(status) <= {"interrupted"} and status.total() <= 1
    files = [journal.done[run.key].files[-1] for run in plan.runs]
    assert len(set(files)) == len(plan.runs)
    assert all(load_record(data / name).status == "complete" for name in files)
    assert {run.info.file for run in Campaign.load(data).runs} == set(files)


def test_two_runs_resumed_after_the_runner_was_killed(tmp_path, monkeypatch):
    resumed(tmp_path, monkeypatch, PLAN.format(slips=[0.05]), 1)


@pytest.mark.long
@pytest.mark.timeout(7200)
def test_twelve_runs_of_the_matrix_resumed_after_the_runner_was_killed(tmp_path, monkeypatch):
    text = twelve()
    assert len(plan_from_text(text, "plan").runs) == 13
    resumed(tmp_path, monkeypatch, text, 5)
