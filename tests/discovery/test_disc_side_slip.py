# SPDX-License-Identifier: Apache-2.0
"""A wheel that is turned under load pulls sideways before the plank moves; a quiet channel does
not ask for more than the form of the model can give."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from ball import throw
from third_campaigns import tables

from flatplank_analysis.contact_patch import kernel, laws
from flatplank_analysis.contact_patch.data import from_tables
from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery.model import FormError
from flatplank_analysis.discovery.noise import ChannelNoise, no_quieter
from flatplank_analysis.discovery.state import channel_weights
from flatplank_analysis.discovery.verdict import AT_FLOOR, LAW, Diagnosis
from flatplank_data.table import MeasurementTable
from flatplank_sim.cli.simulate import main as simulate
from flatplank_sim.plant.config import PlantConfig

PLAN = """
format: flatplank-plan/1
name: both
tire: TOY
common: {{pressure: 2.5, end_position: 2.2}}
runs:
- {{measurement: slip, {settings}, kappa: [0.02, -0.05], start: [1, 2, 3]}}
"""
NUMBERS = {
    "stiff": 6e4, "peak": 1.0, "shape": 4.0, "carcass": 1.2e5, "half": 0.05, "tread": 1.0,
    "patch_order": 0.8, "play_soft": 10.0, "creep_time": 10.0, "load_share": 1.0, "round": 0.4,
}  # fmt: skip


def rolled(slip: float, node: float, start: float, **more: float) -> np.ndarray:
    """Lateral force over 400 nodes of a way [m] at a slip, from a force at rest [N]."""
    params = np.zeros((2, 1, kernel.WIDTH))
    for name, value in (NUMBERS | more).items():
        params[..., kernel.NAMES.index(name)] = value
    params[1, 0, kernel.START] = start
    ds = np.full((1, 400), node)
    ds[:, 0] = 0.0
    force = np.empty((2, 1, 400))
    ones = np.ones((1, 400))
    kernel.sweep(
        kernel.blocks_of(np.arange(1)), True, True, ds, np.stack([0.0 * ds, slip * ds]),
        ds / 0.03, 3700.0 * ones, ones, params, np.full(1, 3700.0), 0.03, force, None,
    )  # fmt: skip
    return force[1, 0]


@pytest.mark.parametrize("more", [{}, {"soften": 0.3, "play": 5e-4}])
@pytest.mark.parametrize("start", [0.0, -110.0, 900.0])
def test_a_force_at_rest_stays_until_the_plank_moves(start, more):
    np.testing.assert_allclose(rolled(0.02, 0.0, start, **more), start, atol=1e-6)


def test_it_goes_on_from_there_to_where_it_goes_anyway():
    free, bent = (rolled(0.02, 1e-2, start) for start in (0.0, -300.0))
    gap = free - bent
    assert gap[:2] == pytest.approx([300.0, 300.0], rel=0.05)
    assert np.all(np.diff(gap[:200]) <= 1e-6) and abs(gap[-1]) < 0.5


def test_more_than_the_friction_is_not_held():
    assert rolled(0.0, 0.0, 9000.0)[-1] == pytest.approx(laws.HELD * 3700.0)


def test_the_force_at_rest_is_that_of_turned_wheels_without_the_zero_of_the_channel():
    made = tables("combined", seed=3)
    turned = np.array([t.info.alpha_deg != 0.0 for t in made])
    shown = []
    for t in made:
        columns = {n: t[n] for n in t.columns}
        columns["fy"] = columns["fy"] + 40.0 - (150.0 if t.info.alpha_deg else 0.0)
        shown.append(MeasurementTable(columns, t.info))
    before, after = from_tables(made).side_force, from_tables(shown).side_force
    assert not before.any()  # this bench starts without: what is seen is noise
    assert turned.any() and not turned.all() and not after[~turned].any()
    assert np.ptp(after[turned]) == 0.0 and after[turned][0] == pytest.approx(-150.0, abs=10.0)
    (one,) = [t for t in shown if t.info.alpha_deg][:1]
    assert not from_tables([one]).side_force.any()


def test_a_quiet_channel_weighs_what_the_form_of_the_model_allows():
    model = throw(1, 0.0)
    largest = float(model.runs.largest[0])
    model.form = FormError(mean=0.01)
    (weight,) = channel_weights(model, [0.0])[:, 0, 0]
    assert weight == pytest.approx(100.0 / largest)
    (weight,) = channel_weights(model, [0.03 * largest])[:, 0, 0]
    assert weight == pytest.approx(1.0 / (largest * np.hypot(0.03, 0.01)))


def test_with_side_slip_or_several_loads_the_form_of_the_law_is_known_less_well():
    straight, turned, loaded = (
        TireModel(from_tables(tables(d, 1))).form for d in ("plain", "combined", "wide_loads")
    )
    assert straight == TireModel.form and turned.law == 2.0 * straight.law
    assert turned.stretch > 2.0 * straight.stretch
    assert replace(turned, law=straight.law, stretch=straight.stretch) == straight
    assert loaded.law == turned.law and replace(loaded, law=straight.law) == straight


def test_what_the_form_misses_beside_the_first_channel_is_no_evidence():
    noise = ChannelNoise(np.array([0.04, 0.0, 0.02, 0.0, 0.0, 0.0, 0.0, 0.03]), np.ones(6))
    assert no_quieter(noise, 0.2) is noise
    loud = no_quieter(noise, 3.0)
    assert float(loud.weights.sum()) == pytest.approx(9.0)
    np.testing.assert_allclose(loud.weights[:2], noise.weights[:2])  # the sensor is what it was
    assert np.ptp(loud.weights[2:] - noise.weights[2:]) < 1e-12


def diagnosed(settings: str, folder: Path) -> Diagnosis:
    """Diagnosis of runs of the bench, in which nothing is wrong with the machine."""
    plan = folder / "plan.yaml"
    plan.write_text(PLAN.format(settings=settings))
    assert simulate([str(folder / "runs"), "--plan", str(plan)]) == 0
    return Session.open(str(folder / "runs")).diagnose()


@pytest.mark.long
def test_of_the_bench_with_two_loads_only_what_its_tire_has_is_named(tmp_path):
    """Was `found: worn_patch`. The carcass of this tire does follow the load."""
    result = diagnosed("fz: [2500, 4500], alpha_deg: [0, 3]", tmp_path)
    true = {"carcass_load": PlantConfig.load("toyo").tire.carcass_stiffness_x_load}
    for found in (f.decision for f in result.found):
        name, (low, high) = found.term.effect.identifier, found.interval
        assert name in true and low < true[name] < high
    assert result.verdict in ("found", AT_FLOOR), result.reason


@pytest.mark.parametrize(
    ("settings", "named"),
    [
        ("fz: 3700, alpha_deg: [0, 2]", set()),
        pytest.param("fz: 3700, gamma_deg: [0, 3]", {"camber_thrust"}, marks=pytest.mark.long),
    ],
)
def test_the_bench_with_side_slip_and_camber(settings, named, tmp_path):
    """Nothing is wrong with the machine. Were `none of these` with 8 N left in Fx, and `none of
    these` with 90 N left in Fy."""
    result = diagnosed(settings, tmp_path)
    names = {f.decision.term.effect.identifier for f in result.found}
    # the friction of its tire is shared by both directions
    assert names - {"tire_law", "combined_slip"} == named, result.reason
    assert result.verdict == ("found" if named else LAW if names else AT_FLOOR), result.reason
