# SPDX-License-Identifier: Apache-2.0
"""The demo's machine makes the proposed run, and nothing is silent for long."""

from __future__ import annotations

import json
import threading

import numpy as np
import pytest

from flatplank_analysis.contact_patch.data import load_runs
from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.contact_patch.plans import planned
from flatplank_analysis.contact_patch.tire_runs import TireRuns
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError
from flatplank_sim.cli import simulate
from flatplank_sim.cli.step_printer import StepPrinter
from flatplank_sim.sealed import generate
from flatplank_sim.sealed.score import DIAGNOSIS

PROPOSED = {"kappa": -0.02, "fz": 2590, "pressure": 2.5, "step_position": 1.5, "starts": [1, 2]}


def test_the_proposed_runs_are_of_the_same_machine_and_in_its_campaign(tmp_path, monkeypatch):
    monkeypatch.setattr(generate, "SLIPS", (-0.02,))
    monkeypatch.setattr(generate, "START_ANGLES", {1: 0.0, 2: 120.0})
    monkeypatch.setattr(generate, "MENU", {"road_play": generate.MENU["road_play"]})
    folder = generate.make_challenge(tmp_path / "of", 1)
    generate.measure_next(folder, PROPOSED, 2)
    runs = Campaign.load(str(folder)).runs
    assert [r.info.run_index for r in runs] == [0, 1, 2, 3, 4, 5]
    assert [r.info.start for r in runs[2:]] == [1, 2, 1, 2]
    for run in runs[2:]:
        assert (run.info.kappa, run.info.fz) == (-0.02, 2590.0)
        assert np.mean(run.table().columns["fz"]) == pytest.approx(2590.0, rel=0.05)
    repeats = [runs[i].table().columns["fx"] for i in (2, 4)]
    assert not np.array_equal(*repeats), "repeats have their own noise"
    named = {"verdict": "found group", "effects": [], "next_run": {"what": "no run does"}}
    (folder / DIAGNOSIS).write_text(json.dumps(named), encoding="utf-8")
    with pytest.raises(ValueError, match="no run does"):
        simulate.main([str(folder), "--next"])
    named["next_run"] = {"what": "that run, 1 x", "settings": PROPOSED, "repeats": 1}
    (folder / DIAGNOSIS).write_text(json.dumps(named), encoding="utf-8")
    assert simulate.main([str(folder), "--next"]) == 0
    assert len(Campaign.load(str(folder)).runs) == 8
    with pytest.raises(FlatplankError, match="no run with alpha_deg"):
        generate.measure_next(folder, PROPOSED | {"alpha_deg": 2.0}, 1)


def test_a_preload_and_a_start_between_are_in_the_record(tmp_path, monkeypatch):
    monkeypatch.setattr(generate, "SLIPS", (-0.02,))
    monkeypatch.setattr(generate, "START_ANGLES", {1: 0.0})
    folder = generate.make_challenge(tmp_path / "of", 1)
    generate.measure_next(folder, PROPOSED | {"preload": 0.01, "starts": [1.5]}, 1)
    info = Campaign.load(str(folder)).runs[-1].info
    assert info.start_angle_deg == 60.0
    slips = {"kappa_1": 0.01, "kappa_2": -0.02, "length": 1.5}
    assert info.waveform == {"name": "double_step"} | slips


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


def test_a_silent_step_repeats_its_line_with_the_time(monkeypatch):
    said, repeated = [], threading.Event()

    def hear(text: str = "", **_options: object) -> None:
        said.append(text)
        if "of this step" in text:
            repeated.set()

    monkeypatch.setattr("builtins.print", hear)
    with StepPrinter(1, quiet=0.02) as printer:
        printer.step("a fit")
        printer.print_progress("20% refits")
        assert repeated.wait(60.0)
        printer.close(["the end"])
    assert any(text.strip().startswith("20% refits (0 s") for text in said)
    assert "the end" in said[-1]
