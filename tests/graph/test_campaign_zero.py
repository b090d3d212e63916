# SPDX-License-Identifier: Apache-2.0
"""A campaign on the graph of the thesis's machine: the unloaded hub is really looked at."""

from __future__ import annotations

import pytest
from bench_graph import graph
from short_plan import short_plan

from flatplank_control.runner.campaign import Journal, plan_from_text

pytestmark = pytest.mark.graph
PLAN = short_plan("zero", "kappa: 0.05, start: 3", more="attempts: 1\n")


def test_zero_noise_and_the_preloaded_shaft_stand_in_the_journal(tmp_path, monkeypatch):
    plan = plan_from_text(PLAN, "plan")
    with graph(tmp_path, monkeypatch, preset="thesis2023") as bench:
        bench.client.measure(PLAN, simulated=True, folder=str(bench.data))
    journal = Journal(bench.data / "zero.journal.jsonl", plan.name, plan.digest)
    (run,) = plan.runs
    facts = journal.done[run.key].facts
    for look in (facts["before"], facts["after"]):
        assert look["noise"] > 0.1
        assert abs(look["zero_fz"]) > 1.0
    # the filter is off, and the shaft turns with the wheel on its way to 240 deg
    assert facts["once_per_turn_unloaded"] > 50.0
