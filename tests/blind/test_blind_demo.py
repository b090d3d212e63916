# SPDX-License-Identifier: Apache-2.0
"""The demo's machine makes the proposed run, and nothing is silent for long."""

from __future__ import annotations

import numpy as np
import pytest

from flatplank_analysis.contact_patch.data import load_runs
from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.contact_patch.plans import planned
from flatplank_analysis.contact_patch.tire_runs import TireRuns
from flatplank_data.campaign import Campaign
from flatplank_sim.sealed import generate

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
