# SPDX-License-Identifier: Apache-2.0
"""Runs that could be made are predicted with the sizes of the campaign, told against its runs."""

from __future__ import annotations

import numpy as np
import pytest
from bristles import Truth, campaign

from flatplank_analysis.contact_patch.data import from_tables
from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.contact_patch.plans import planned
from flatplank_analysis.discovery.model import ParameterSet
from flatplank_analysis.effects.registry import library

USUAL = {"kappa": 0.02, "pressure": 2.5, "step_position": 1.5, "start": 1}


@pytest.fixture(scope="module")
def model() -> TireModel:
    return TireModel(from_tables(campaign(Truth(seed=91, slips=(-0.02, 0.0, 0.02)))))


def change(model: TireModel, name: str, values: dict[str, float]) -> np.ndarray:
    """What an effect changes in Fx, (runs, samples)."""
    effect = library()[name]
    base = np.array([p.null for p in model.parameters])
    sets = [ParameterSet(base), ParameterSet(base, ((effect, effect.vector(values)),))]
    without, with_it = model.predict(sets)[:, 0]
    return with_it - without


def test_a_run_at_another_load_tells_the_tire_from_the_shaft(model):
    """Non-uniformity grows with the load, the force of the shaft does not."""
    load = float(np.median(model.data.nominal))
    usual, more = (planned(model, "", USUAL | {"fz": share * load}).model for share in (1.0, 1.3))
    tire = [change(m, "nonuniformity_1", {"fx_cos": 50.0}) for m in (usual, more)]
    shaft = [change(m, "parasitic_force", {"fx_cos": 50.0}) for m in (usual, more)]
    assert tire[1] == pytest.approx(1.3 * tire[0])
    assert shaft[1] == pytest.approx(shaft[0])


def test_the_next_run_has_the_wear_of_the_campaign_and_a_little_more(model):
    usual = planned(model, "", USUAL | {"fz": float(np.median(model.data.nominal))}).model
    runs = model.runs.runs
    drift = change(usual, "zero_drift_runs", {"drift": 60.0})
    assert drift == pytest.approx(60.0 * (0.5 + 1.0 / (runs - 1)))
    assert np.abs(change(usual, "wear", {"loss": 0.2})).max() > 1.0


def test_other_runs_are_told_against_those_of_the_fit(model):
    other = TireModel(from_tables(campaign(Truth(seed=92, slips=(0.02,), repeats=2))))
    own = other.data.reference
    other.take_references(model)
    assert other.data.reference == model.data.reference != own
