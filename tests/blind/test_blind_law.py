# SPDX-License-Identifier: Apache-2.0
"""On the bristle plant up to 10 % of slip, a force law of another form is no machine effect."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flatplank_analysis.contact_patch.data import from_tables
from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.effects.registry import library
from flatplank_data.campaign import Campaign
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_sim.sealed.conditions import STEP, Run, Setting
from flatplank_validation.blind.cases import Case, make
from flatplank_validation.blind.noise import NOISES, RELATIVE, Noise, noise
from flatplank_validation.blind.worlds import PlantWorld, Scatter

SLIPS = (-0.1, -0.02, 0.02, 0.1)
OTHER_LAW = {"shape": 2.0, "fall": 0.0, "round": 0.0}
"""a form that the base is held to, and the plant's bristles do not have"""


@pytest.fixture(scope="module")
def data():
    """Nothing hidden, little noise on Fx: four slips, twice each."""
    random = np.random.default_rng(7)
    world = PlantWorld.drawn()
    order = random.permutation(2 * len(SLIPS))
    runs = [Run(Setting(SLIPS[i // 2]), 1 + i % 2, n) for n, i in enumerate(order)]
    columns = world.run(runs, {}, random, Scatter.drawn(len(runs), 0.0, random))
    kinds = dict.fromkeys(RELATIVE, NOISES["quiet"]) | {"fx": Noise(6.0, 0.5)}
    tables = []
    for c, run in zip(columns, runs, strict=True):
        dt = float(c["time"][1] - c["time"][0])
        for name, share in RELATIVE.items():
            c[name] = c[name] + noise(kinds[name], len(c["time"]), dt, random, share)
        info = RunRecord(
            file=f"{run.index}.parquet", tire="LAW", kappa=run.setting.kappa, fz=run.setting.fz,
            pressure=run.setting.pressure, start=run.start, run_index=run.index,
            effective_rolling_radius=world.radius, step_position=STEP,
        )  # fmt: skip
        tables.append(MeasurementTable(c, info))
    return from_tables(tables)


def _diagnosis(data, held) -> dict:
    model = TireModel(data)
    model.parameters = tuple(
        replace(p, null=held[p.name], screen=0.0) if p.name in held else p
        for p in model.parameters
    )
    return Session(Campaign("law", []), data, model, library()).diagnose().to_dict()


def test_the_base_takes_the_plant_to_ten_percent(data):
    assert _diagnosis(data, {})["verdict"] == "at floor"


@pytest.mark.long
def test_a_law_that_the_base_is_held_to_is_taken_for_a_softer_carcass(data):
    """Nothing is hidden, only the law is another one: a known fault of the search, which
    docs/explanation/search.md tells. With the base's own freedom nothing is named (above)."""
    result = _diagnosis(data, OTHER_LAW)
    assert result["rmse_before"] > 1.5 * result["floor_rmse"]
    assert "carcass_softening" in {e["name"] for e in result["effects"]}


@pytest.mark.long
@pytest.mark.timeout(300)
def test_less_friction_when_braking_is_not_another_law():
    """A law with a table for each direction contained it, and so always stood for it."""
    case = Case("single", "plant", ("drive_brake_asymmetry",), 3.0, "quiet", 0.0, rung="c")
    session = Session.of_tables(make(case, 86243)[0])
    names = ("drive_brake_asymmetry", "load_loss_braking", "tire_law")
    session.effects = {name: library()[name] for name in names}
    (effect,) = session.diagnose().to_dict()["effects"]
    assert "drive_brake_asymmetry" in (effect["name"], *effect["class"]), effect
    assert effect["size"] == pytest.approx(0.03, rel=0.2)


@pytest.mark.long
@pytest.mark.timeout(300)
def test_a_law_found_first_does_not_make_the_tests_of_an_effect_stricter():
    """A wear that saturates differs a little among conditions: surely there among repeats, it was
    refused because another form of the law had been found before it."""
    case = Case("single", "forms", ("wear",), 4.0, "quiet", 0.03)
    session = Session.of_tables(make(case, 86243)[0])
    named = {e["name"] for e in session.diagnose().to_dict()["effects"]}
    assert "wear" in named and named <= {"tire_law", "wear"}, named
