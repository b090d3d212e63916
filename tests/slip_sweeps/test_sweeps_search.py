# SPDX-License-Identifier: Apache-2.0
"""The search on sweeps: what a tire file lacks is named, on a brush that shares no code."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import flatplank_analysis as fp
from flatplank_analysis.discovery.model import ParameterSet
from flatplank_analysis.slip_sweeps.effects import effects, that_can_show
from flatplank_analysis.slip_sweeps.model import sweep_model
from flatplank_analysis.slip_sweeps.study import study
from flatplank_data.errors import FlatplankError
from flatplank_tire import read_tir
from flatplank_validation.sweep_sets.brush import BASE, Brush, Plan, sweeps, text_of


def written(path: Path, brush: Brush, plan: Plan | None = None, seed: int = 1) -> Path:
    path.write_text(text_of(sweeps(brush, plan or Plan(), seed)), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def hot(tmp_path_factory) -> Path:
    """Friction that falls by 0.3 % for each kelvin."""
    path = tmp_path_factory.mktemp("hot") / "hot.csv"
    return written(path, Brush(over_temperature=0.003))


@pytest.fixture(scope="module")
def model(hot):
    return sweep_model([study(hot)], read_tir(BASE))


def test_friction_over_temperature_is_named_and_nothing_else(hot) -> None:
    """Up and down differ by heat: neither relaxation nor wear nor drift."""
    found = fp.sweeps(hot).diagnose(BASE)
    told = found.to_dict()
    assert [e["name"] for e in told["effects"]] == ["grip_temperature"]
    assert told["effects"][0]["size"] == pytest.approx(-0.003, rel=0.15)
    assert told["rmse_after"] < 0.4 * told["rmse_before"]
    assert found.verdict == "found"
    assert "camber" in found.next_run["what"] and found.to_do["do"][0].startswith("measure")


def test_a_tire_as_the_file_says_has_nothing_named(tmp_path) -> None:
    found = fp.sweeps(written(tmp_path / "null.csv", Brush(), seed=4)).diagnose(BASE)
    assert found.to_dict()["effects"] == []
    assert found.verdict == "at floor"


def test_the_same_law_at_all_pressures_lets_friction_over_pressure_be_named(tmp_path) -> None:
    path = written(tmp_path / "p.csv", Brush(over_pressure=0.3), seed=5)
    found = fp.sweeps(path).diagnose(BASE)
    assert [e["name"] for e in found.to_dict()["effects"]] == ["grip_pressure"]
    assert found.verdict == "found"


def test_a_stiffness_over_load_that_no_tire_file_has_is_a_law_and_no_fault(tmp_path) -> None:
    path = written(tmp_path / "l.csv", Brush(longer=0.3), seed=6)
    assert fp.sweeps(path).diagnose(BASE).verdict == "tire law only"


def test_a_run_is_a_visit_and_a_node_a_bin_up_then_down(model) -> None:
    runs = model.runs
    assert runs.measured.shape == (1, 12, 60)
    assert all(len(group) == 2 for group in runs.groups)
    alpha = runs.coordinates["alpha"].values
    assert (np.diff(alpha[:, :30]) > 0.0).all() and (np.diff(alpha[:, 30:]) < 0.0).all()


def test_effects_show_only_where_the_sweeps_have_what_they_need(model, tmp_path) -> None:
    names = {e.identifier for e in that_can_show(model.runs)}
    assert {"grip_temperature", "wear", "grip_pressure", "relaxation", "conicity"} <= names
    assert not names & {"camber_thrust", "camber_stiffness", "grip_speed"}  # neither varies
    cold = {k: v for k, v in sweeps(Brush(), Plan(), 1).items() if k != "TSTC"}
    path = tmp_path / "cold.csv"
    path.write_text(text_of(cold), encoding="utf-8")
    runs = sweep_model([study(path)], read_tir(BASE)).runs
    assert "grip_temperature" not in {e.identifier for e in that_can_show(runs)}


@pytest.mark.parametrize("effect", effects(), ids=lambda e: e.identifier)
def test_an_effect_does_nothing_at_its_null_and_says_what_it_is(effect, model) -> None:
    base = np.array([p.null for p in model.parameters])
    plain = model.predict([ParameterSet(base)])
    null = ParameterSet(base, ((effect, effect.vector({})),))
    np.testing.assert_array_equal(model.predict([null]), plain)
    assert effect.needs and effect.title and effect.what and effect.check and effect.removes
    assert "Source:" in (effect.__doc__ or "")
    if effect.can_show(model.runs):
        moved = effect.vector({}) + [p.screen for p in effect.parameters()]
        assert np.ptp(model.predict([ParameterSet(base, ((effect, moved),))]) - plain) > 0.1


def test_closed_forms_of_the_effects(model) -> None:
    """A ply steer is added to the slip angle, a conicity is a share of the load; and so on."""
    by_name = {e.identifier: e for e in effects()}

    def state(name: str, value: float):
        one = by_name[name](value)
        s = model.state()
        s.force = np.zeros(s.fz.shape)
        one.tire(s)
        one.bench(s)
        return s

    plain = model.state()
    np.testing.assert_allclose(state("ply_steer", 0.01).alpha, plain.alpha + 0.01)
    np.testing.assert_allclose(state("conicity", 0.01).force, 0.01 * plain.fz)
    middle = np.median(plain.temperature)
    np.testing.assert_allclose(
        state("grip_temperature", -0.01).grip, np.exp(-0.01 * (plain.temperature - middle))
    )
    lag = plain.alpha - 0.3 * plain.rate / plain.speed
    np.testing.assert_allclose(state("relaxation", 0.3).alpha, lag)


def test_a_slip_that_was_not_swept_is_told(hot) -> None:
    with pytest.raises(FlatplankError, match="no sweep of the"):
        fp.sweeps(hot).diagnose(BASE, swept="kappa")
