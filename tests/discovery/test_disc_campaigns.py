# SPDX-License-Identifier: Apache-2.0
"""Whole searches on made-up bristle campaigns: what is hidden is named, what is not is not."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from bristles import Truth, campaign

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery import verdict

SMALL = (-0.05, -0.01, 0.0, 0.01, 0.05)


def session_of(truth: Truth) -> Session:
    """A session without files."""
    return Session.of_tables(campaign(truth))


def diagnosis_of(**truth) -> dict:
    return session_of(Truth(slips=SMALL, **truth)).diagnose().to_dict()


def test_nothing_hidden_is_at_the_floor_and_what_would_have_shown_is_told():
    """`detectable` answers what these runs could have shown."""
    result = session_of(Truth(slips=SMALL, seed=21)).diagnose()
    told = result.to_dict()
    assert told["verdict"] == "at floor", told
    assert told["effects"] == []
    json.dumps(told, allow_nan=False)
    sizes = result.detectable
    assert 0.0 < sizes["drive_backlash"][0] < 1e-3
    assert "road_speed_error" not in sizes
    assert np.isfinite([v for v, _ in sizes.values()]).all()


@pytest.mark.long
def test_scatter_of_the_tire_is_no_effect():
    result = diagnosis_of(seed=22, scatter=0.03, tire="relaxation")
    assert result["effects"] == [], result
    assert result["verdict"] == "at floor"


def test_parasitic_force_is_named_with_its_size():
    result = diagnosis_of(seed=24, parasitic=40.0)
    names = [e["name"] for e in result["effects"]]
    assert names == ["parasitic_force"], result
    assert result["effects"][0]["size"] == pytest.approx(40.0, rel=0.1)


@pytest.mark.long
def test_what_is_in_no_library_is_said_to_be_unknown_and_where_it_is():
    result = diagnosis_of(seed=25, pull=80.0)
    assert result["verdict"] in ("none of these", "partly"), result
    places = {w["coordinate"]: w["range"] for w in result["unexplained"]["where"]}
    low, high = places["plank position"]
    assert low > 1.9 and high < 2.9
    assert "second step position" in result["next_run"]["what"]


def test_few_runs_are_not_decidable():
    few = session_of(Truth(seed=26, slips=(0.0, 0.02), repeats=2))
    assert few.diagnose().verdict == verdict.UNDECIDED


@pytest.mark.parametrize(
    ("seed", "tire", "noise", "scatter"),
    [
        pytest.param(27, "bristles", 1.0, 0.0, marks=pytest.mark.long),
        pytest.param(33, "bristles", 1.0, 0.02, marks=pytest.mark.long),
        (36, "relaxation", 0.1, 0.01),
    ],
)
def test_runs_without_repeats_stand_on_a_lower_bound(seed, tire, noise, scatter):
    """Nothing is hidden; the lower bound knows slow noise by the runs at rest, and what a scatter
    of the tire explains is no evidence, since no repeat shows the scatter."""
    made = Truth(seed=seed, repeats=1, tire=tire, noise=noise, scatter=scatter)
    result = session_of(made).diagnose().to_dict()
    assert result["verdict"] == verdict.AT_FLOOR and result["floor_is_lower_bound"]
    assert (
        result["floor_from"].startswith("noise at rest")
        and result["verdict_at_most"] == verdict.PARTLY
    )
    json.dumps(result, allow_nan=False)


def test_a_force_of_no_library_stays_visible_without_repeats():
    result = session_of(Truth(seed=43, repeats=1, pull=80.0)).diagnose().to_dict()
    assert result["verdict"] == verdict.NONE and result["effects"] == [], result


@pytest.mark.long
@pytest.mark.timeout(900)
@pytest.mark.parametrize(
    ("truth", "names"),
    [
        ({"play": 6e-4}, {"road_play"}),
        ({"ripple": 6e-5}, {"mesh_ripple"}),
        ({"asymmetry": 0.06}, {"drive_brake_asymmetry", "load_loss_braking"}),
        ({"lag": 0.2}, {"force_lag", "time_skew"}),
        ({"runout": 3e-4}, {"runout_1"}),
        ({"patch": 0.2}, {"worn_patch"}),
    ],
)
@pytest.mark.parametrize("tire", ["bristles", "relaxation"])
def test_single_effects(truth, names, tire):
    made = replace(Truth(seed=31, tire=tire), **truth)
    result = session_of(made).diagnose().to_dict()
    assert len(result["effects"]) == 1, result
    assert {result["effects"][0]["name"], *result["effects"][0]["class"]} & names
