# SPDX-License-Identifier: Apache-2.0
"""Files that version 0.1.0 wrote are read as they were: they are never written anew.

The bag has the 400 cycles around a step of 5 %, at a bus rate of 50 Hz.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml

from flatplank_analysis.contact_patch.session import base_of
from flatplank_analysis.discovery.modelfile import load_model, save_model
from flatplank_analysis.effects.registry import library
from flatplank_analysis.models.tire_record import read_record
from flatplank_control.runner.campaign.journal import Journal
from flatplank_control.runner.campaign.plan import load_plan
from flatplank_data.campaign import Campaign
from flatplank_data.run_record import load_record, read_run
from flatplank_sim.sealed.seal import unseal

HERE = Path(__file__).parent / "0.1.0"
RUN = "TOY_REL_LNG_5perc_T_p25_Fz3700_1"


@pytest.fixture
def old(tmp_path):
    """A copy: readers may keep something beside what they read."""
    return shutil.copytree(HERE, tmp_path / "old")


def test_bag_and_campaign(old) -> None:
    campaign = Campaign.load(old / "campaign")
    (info,) = campaign.infos
    assert (campaign.tire, info.measurement, info.kappa, info.fz) == ("TOY", "slip", 0.05, 3700.0)
    assert (info.pressure, info.step_position) == (2.5, 1.5)
    (table,) = campaign.tables()
    assert len(table) == 400
    assert np.median(np.diff(table["time"])) == pytest.approx(0.02, rel=1e-6)
    assert np.mean(table["fz"]) == pytest.approx(3700.0, rel=0.02)
    assert np.all(np.diff(table["plank_position"]) > 0.0)


def test_run_record_and_tire_record(old) -> None:
    record = load_record(old / "campaign" / RUN)
    assert (record.name, record.kappa, record.effective_rolling_radius) == (RUN, 0.05, 0.3108)
    text = (old / "campaign" / RUN / "run.yaml").read_text()
    of_a_later_version = {"cycles_late": None}
    assert yaml.safe_load(record.to_yaml()) == yaml.safe_load(text) | of_a_later_version
    assert read_run(yaml.safe_load(text), "run.yaml") == (record, [])  # the analysis has it, too
    tire = read_record(old / "campaign" / "tire.yaml")
    assert (tire.name, tire.nominal_load) == ("TOY", 3700.0)


def test_plan_and_journal(old) -> None:
    plan = load_plan(old / "plan.yaml")
    journal = Journal(old / "plan.journal.jsonl", plan.name, plan.digest)
    assert len(plan.runs) == 8
    assert all(journal.finished(run.key) for run in plan.runs)


def test_model_file(old) -> None:
    model = load_model(old / "model.yaml")
    (entry,) = model.effects
    assert entry.name == "rack_backlash" and entry.name in library()
    assert entry.parameters["gap"] == 0.0007403559069402984
    save_model(model, old / "again.yaml")
    before, after = (yaml.safe_load((old / n).read_text()) for n in ("model.yaml", "again.yaml"))
    assert after == before
    assert model.undone().effects == ()
    start = base_of(model)
    assert (start["patch_order"], start["denom"]) == (1.0822649551218924, 1.269716306624831)


def test_sealed_answer(old) -> None:
    (effect,) = unseal(old)["effects"]
    assert (effect["name"], effect["unit"]) == ("road_play", "m")
