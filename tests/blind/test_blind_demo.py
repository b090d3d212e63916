# SPDX-License-Identifier: Apache-2.0
"""The demo's machine makes the proposed run, and nothing is silent for long."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from flatplank_analysis.contact_patch.data import load_runs
from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.contact_patch.plans import planned
from flatplank_analysis.contact_patch.tire_runs import TireRuns
from flatplank_data.campaign import Campaign
from flatplank_sim.cli.demo import CLOSE, sealed_challenge
from flatplank_sim.sealed import generate
from flatplank_sim.sealed.seal import unseal

PROPOSED = {"kappa": -0.02, "fz": 2590, "pressure": 2.5, "step_position": 1.5, "starts": [1, 2]}


def test_a_planned_run_has_the_inputs_that_the_measured_one_has(tmp_path, monkeypatch):
    """Travel, turned angle and distance since the step; a preload is a step before the step."""
    monkeypatch.setattr(generate, "SLIPS", (-0.02,))
    monkeypatch.setattr(generate, "MENU", {"nothing": generate.MENU["nothing"]})
    folder = generate.make_challenge(tmp_path / "of", 1)
    settings = PROPOSED | {"fz": generate.LOAD, "preload": 0.01, "starts": [1.5]}
    plan = planned(TireModel(load_runs(Campaign.load(str(folder)))), "", settings)
    generate.measure_next(folder, settings, 1)
    made = load_runs(Campaign.load(str(folder)))
    row = int(np.argmax(made.runs.order))
    foreseen = plan.model.data
    assert made.nominal[row] == foreseen.nominal[0]
    assert made.wheel_turn[row, 0] == pytest.approx(foreseen.wheel_turn[0, 0], abs=1e-3)
    since = np.array([-1.0, -0.1, 0.05, 0.5, 1.0])

    def turned(data: TireRuns, run: int) -> np.ndarray:
        angle = np.interp(since, data.since_step[run], data.angle[run])
        return angle[1:] - angle[0]

    assert turned(made, row) == pytest.approx(turned(foreseen, 0), rel=2e-3)


def test_what_is_close_is_hidden_in_a_short_campaign_and_the_machine_stays_the_same(tmp_path):
    folder = generate.make_challenge(tmp_path / "close", 1, close=CLOSE)
    assert len(Campaign.load(str(folder)).runs) == 8
    (effect,) = unseal(folder)["effects"]
    hidden = generate.CLOSE[CLOSE]
    assert (effect["name"], *effect["class"]) == hidden.names
    machine = generate._machine_of(folder)
    assert (machine.hidden, machine.size) == (hidden, effect["size"])
    assert generate.CLOSE.keys().isdisjoint(generate.MENU)


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2])
def test_the_demo_names_a_group_makes_the_run_that_it_asks_for_and_names_the_truth(tmp_path, seed):
    steps = SimpleNamespace(
        step=lambda _: None, print_progress=lambda _: None, count=lambda *_: None
    )
    told = "\n".join(sealed_challenge(tmp_path / "challenge", seed, CLOSE, steps))
    assert "8 runs: verdict found group: parasitic_force or nonuniformity_1" in told
    assert "runs: verdict found: parasitic_force" in told
    assert "next run: slip" in told
    assert told.rindex("name: right") > told.index("+ parasitic_force")
    assert "before_and_after.png" in told
