# SPDX-License-Identifier: Apache-2.0
"""All tires of the thesis: their own numbers come back, whatever tire they are."""

from __future__ import annotations

import json

import pytest
from plant_tires import plant_campaign

from flatplank_analysis.models.tire_record import shipped_record
from flatplank_analysis.report.analysis import analyse
from flatplank_data.campaign import Campaign
from flatplank_validation.fits import tires

TIRES = {"toyo": "TOY", "continental": "CON", "michelin": "MIC", "racing": "RAC"}
GRAIN = 0.005
"""the plant's bristles are few: its slope at zero slip is up to 0.4 % off its own steady curve"""


@pytest.fixture(scope="module", params=TIRES)
def found(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("four") / request.param
    folder, truth = plant_campaign(folder, request.param)
    return analyse(Campaign.load(folder), tire=shipped_record(request.param)), truth, folder


def test_own_numbers_are_recovered(found):
    result, truth, _ = found
    (point,) = result.points
    free = point.carcass.without_bias()
    assert point.carcass.slip_stiffness.value == pytest.approx(truth.slip_stiffness, rel=GRAIN)
    for name, own in (("c_cx", "carcass_stiffness_x"), ("sigma_x", "relaxation_length_x")):
        low, high = free[name].interval()
        assert low < getattr(truth, own) < high, name
        assert high - low < 0.1 * free[name].value, name
    c = result.magic.tir.coefficients
    config = shipped_record(next(k for k, v in TIRES.items() if v == result.tire))
    assert (config.free_radius, truth.fz) == (c.UNLOADED_RADIUS, c.FNOMIN)
    assert truth.pressure == pytest.approx(1e-5 * c.NOMPRES)


def test_a_contact_point_on_its_spring_follows_large_steps(found):
    """MF-Tyre with a constant sigma misses the first centimetres of a large step."""
    result, truth, _ = found
    (point,) = result.points
    constant, spring = (point.models[name].rmse for name in ("mf", "mf_contact_point"))
    largest = [c for c in constant if abs(c.kappa) == max(abs(k.kappa) for k in constant)]
    for c in largest:
        assert constant[c] > 0.06 * truth.fz
        assert spring[c] < 0.4 * constant[c]
    assert all(c.floor() < 1.0 for c in point.conditions)


def test_the_record_made_from_the_data_gives_the_same_tire(found):
    result, truth, folder = found
    again = analyse(Campaign.load(folder))
    assert again.record.origin.startswith("made from the data")
    assert again.record.nominal_load == truth.fz
    assert again.record.free_radius == pytest.approx(result.record.free_radius, rel=0.015)
    one, two = (r.points[0].carcass.slip_stiffness.value for r in (result, again))
    assert two == pytest.approx(one, rel=1e-3)


@pytest.mark.long
@pytest.mark.timeout(900)
@pytest.mark.parametrize("plant", TIRES)
def test_simulate_fit_and_report_recover_the_tire(plant, tmp_path):
    """By the verbs, on the bench's own cores."""
    found = tires.measure_tire(plant, tmp_path)
    assert found["tire"] == TIRES[plant]
    for name, limit in (("C_Fk", GRAIN), ("c_cx", 0.03), ("sigma_x", 0.03), ("r_e", 0.01)):
        row = found["rows"][name]
        assert row["found"] == pytest.approx(row["true"], rel=limit), (name, row)
        grain = 0.5 * GRAIN * row["true"] if name == "C_Fk" else 0.0
        assert row["low"] - grain < row["true"] < row["high"] + grain, (name, row)
    fit = json.loads((tmp_path / plant / "fit.json").read_text())
    assert fit["tire_record"]["name"] == TIRES[plant]
