# SPDX-License-Identifier: Apache-2.0
"""Combined slip and several loads: the base against three tires that it does not come from."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from third_campaigns import session, tables

from flatplank_analysis.contact_patch.data import from_tables
from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.discovery.fit import Fitter, Term
from flatplank_analysis.discovery.state import channel_weights, rough_levels, start_base
from flatplank_analysis.effects.registry import library
from flatplank_validation.blind.third_world import ThirdWorld
from flatplank_validation.blind.worlds import WORLDS

FLOORS = 1.15
"""root mean square of Fx and Fy over their floor; scatter of the tire is off"""


def world(name):
    """A world of the blind kit as the maker of campaigns wants it."""
    return ThirdWorld if name == "third" else SimpleNamespace(drawn=WORLDS[name])


def fitted(design, name="third", terms=(), **given):
    """The base fitted to a campaign from its usual start, with its errors over the floors."""
    model = TireModel(from_tables(tables(design, world=world(name), **{"seed": 3} | given)))
    fitter = Fitter(model, channel_weights(model, rough_levels(model)))
    fit = fitter.fit(start_base(model), terms)
    residual = fit.residual(model.runs.measured)
    spare = sum(len(g) - 1 for g in model.runs.groups) * model.runs.samples
    floors = np.sqrt(np.sum(model.runs.contrast(residual) ** 2, axis=(1, 2)) / spare)
    errors = np.array([model.runs.rmse(r) for r in residual]) / floors
    return model, fit, dict(zip(model.runs.channels, errors, strict=True))


def term(name, **values):
    effect = library()[name]
    return Term(effect, effect.vector(values), effect.held())


def number(model, fit, name):
    return fit.base[[p.name for p in model.parameters].index(name)]


@pytest.mark.parametrize(
    ("name", "hidden"),
    [
        ("third", {}),
        pytest.param("plant", {}, marks=pytest.mark.long),
        pytest.param("second", {"combined_slip": 1.0}, marks=pytest.mark.long),
    ],
)
def test_combined_slip_of_another_tire_is_fitted_at_the_floor(name, hidden):
    """Straight and at 5 deg; was 232, 215 and 24 N with floors of 9 N."""
    _, _, errors = fitted("combined", name, **hidden)
    assert errors["fx"] < FLOORS, errors
    assert errors["fy"] < (1.3 if name == "second" else FLOORS), errors


def test_three_side_slips():
    _, _, errors = fitted("angles", seed=4)
    assert max(errors["fx"], errors["fy"]) < FLOORS, errors


@pytest.mark.long
def test_a_wheel_that_runs_along_the_plank_and_one_that_runs_along_itself():
    """The third bench turns its wheel with V cos(alpha), the second with V."""
    model, fit, _ = fitted("combined")
    assert abs(number(model, fit, "slip_turned")) < 0.1
    model, fit, _ = fitted("combined", "second", combined_slip=1.0)
    assert number(model, fit, "slip_turned") == pytest.approx(-1.0, abs=0.1)


def test_loads_from_half_to_one_and_a_half():
    """The plant's rolling radius and carcass go with the load; was 67 N with a floor of 9 N."""
    terms = [term("carcass_load", slope=0.1)]
    _, fit, errors = fitted("wide_loads", "plant", terms)
    assert errors["fx"] < 1.1, errors
    assert 0.05 < fit.terms[0].size < 0.2


def test_the_carcass_over_the_load_is_found_with_its_size():
    """A power of the load; a straight line over it leaves 11 N, the floor is 8.5 N."""
    terms = [term("carcass_load", slope=0.2), term("rolling_resistance", share=0.005)]
    _, fit, errors = fitted("wide_loads", terms=terms, carcass_load=0.5)
    assert errors["fx"] < 1.1, errors
    assert fit.terms[0].size == pytest.approx(0.5, abs=0.05)


def test_without_side_slip_at_one_load_the_base_has_none_of_their_numbers():
    model = TireModel(from_tables(tables("plain", seed=3)[:6]))
    names = {p.name for p in model.parameters}
    assert not names & {
        "other_slip",
        "turn_share",
        "turn_rate",
        "grip_y",
        "slip_turned",
        "slip_load",
    }
    assert len(names) == 19


@pytest.mark.long
@pytest.mark.timeout(900)
def test_steering_play_at_one_side_slip_is_told_as_hardly_shown():
    """Beside straight runs one angle that is off is nearly all the tire's own: it is told, and
    not named, since its size is not to be had."""
    result = session("combined", seed=3, steering_play=4e-3).diagnose().to_dict()
    assert {e["name"] for e in result["effects"]} <= {"tire_law"}, result
    assert result["verdict"] in ("at floor", "tire law only"), result
    (note,) = (n for n in result["notes"] if "imitate" in n)
    assert "steering_play" in note


@pytest.mark.long
@pytest.mark.timeout(900)
@pytest.mark.parametrize(
    ("design", "seed", "scatter"), [("combined", 3, 0.0), ("combined", 5, 0.02)]
)
def test_nothing_hidden_in_combined_slip(design, seed, scatter):
    result = session(design, seed=seed, scatter=scatter).diagnose().to_dict()
    assert result["effects"] == [] and result["verdict"] in ("at floor", "tire law only"), result


@pytest.mark.long
@pytest.mark.timeout(900)
def test_three_loads_with_scatter_name_nothing_but_the_rolling_resistance_that_is_there():
    result = session("wide_loads", seed=3, scatter=0.02).diagnose().to_dict()
    assert {e["name"] for e in result["effects"]} <= {"rolling_resistance"}, result
    assert result["rmse_after"] <= result["rmse_before"]
