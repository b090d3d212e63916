# SPDX-License-Identifier: Apache-2.0
"""Every effect of the library recovers what another world hides: size, sign, order, place.

The tire is known from the same runs with nothing hidden; then the effect's own numbers are fitted,
with the search's own least squares. `within` is what the other form of the other world may cost.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from other_world import WORLDS, Wrong, blinded, runs_of

from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.discovery.fit import Fit, Fitter, Term
from flatplank_analysis.discovery.model import ParameterSet
from flatplank_analysis.discovery.state import make_candidates
from flatplank_analysis.effects.registry import library
from flatplank_validation.blind.second import SecondTire

WEIGHT = np.full((3, 1, 1), 0.1)


@dataclass(frozen=True)
class Hidden:
    """What is hidden, and the numbers that must come out."""

    name: str
    wrong: Wrong
    wanted: Mapping[str, float]
    within: float = 0.05
    """of the largest number that is wanted"""
    design: str = "plain"
    setting: Mapping[str, float] = field(default_factory=dict)
    """numbers that are not fitted"""
    begin: Mapping[str, float] = field(default_factory=dict)
    """numbers that are fitted from another start than their null"""
    left: float = 0.2
    """share of the error that may be left"""
    world: str = "second"
    unseen: bool = False
    """the load channel shows nothing of it"""
    free: tuple[str, ...] = ()
    """numbers of the base that the hidden thing moves as well"""

    @property
    def id(self) -> str:
        return f"{self.name}{'-unseen' if self.unseen else ''}"


def _kernel(**numbers: float) -> Wrong:
    return {"kernel": numbers}


def _wave(size: float, phase: float, cos: str = "cos", sin: str = "sin") -> dict[str, float]:
    """size cos(angle - phase)."""
    return {cos: size * np.cos(phase), sin: size * np.sin(phase)}


def _mixed(source: str, goal: str, share: float, **kernel: float) -> Wrong:
    return {"mix": {(source, goal): share}, "kernel": kernel}


def _out(order: int, phase: float) -> Hidden:
    wrong = _kernel(**{f"out_{order}": 5e-4, "out_load": 1.2e5})
    return Hidden(f"runout_{order}", wrong, _wave(5e-4, phase) | {"radial": 1.2e5}, 0.03)


def _uneven(order: int) -> Hidden:
    sizes = tuple(60.0 * (n == order) for n in (1, 2, 3))
    wanted = _wave(60.0, 0.3 * order, "fx_cos", "fx_sin")
    return Hidden(f"nonuniformity_{order}", {"uneven": sizes}, wanted, 0.03)


NOT_TARED, TARED = {"tared": 0.0}, {"tared": 1.0}

CASES = (
    # machine: the road and what drives it
    Hidden("road_play", _kernel(play=1e-3), {"gap": 1e-3}),
    Hidden("drive_backlash", _kernel(drive_gap=1e-3), {"gap": 1e-3}),
    Hidden("rack_backlash", _kernel(rack_gap=1e-3), {"gap": 1e-3}),
    Hidden(
        "mesh_ripple", _kernel(ripple=2e-4, ripple_period=0.2, ripple_phase=0.7),
        # sin(phase + 0.7)
        {"cos": 2e-4 * np.sin(0.7), "sin": 2e-4 * np.cos(0.7)}, 0.2, setting={"period": 0.2},
        left=0.4,
    ),
    # the filter of the measured motion takes a third of so short a wave
    Hidden(
        "mesh_ripple", _kernel(ripple=2e-4, ripple_period=0.03, ripple_phase=0.7),
        {"cos": 2e-4 * np.sin(0.7), "sin": 2e-4 * np.cos(0.7)}, 0.25, setting={"period": 0.03},
        left=0.6,
    ),
    # the bristle plant finds the force that the crack holds by its own true force, in each run
    Hidden("torn_weld", {"torn_weld": {"gap": 1.5e-3, "hold": 2000.0, "spread": 0.0, "seen": 0.0}},
           {"gap": 1.5e-3, "hold": 2000.0}, 0.1, begin={"hold": 1700.0}, world="plant", left=0.4),
    Hidden("road_speed_error", _kernel(scale_error=3e-3), {"error": 3e-3}),
    Hidden("speed_droop", _kernel(droop=1.5e-6), {"give": 1.5e-6}),
    Hidden("worn_patch", {"patches": ((2.4, 2.7, 0.2),)},
           {"depth": 0.2, "position": 2.55, "width": 0.3}, 0.08,
           begin={"position": 2.5, "width": 0.2, "blur": 0.07}),
    Hidden("wear", {"wear": 0.1}, {"loss": 0.1}),
    # machine: the wheel and its support
    _out(1, 0.7), _out(2, 0.4), _out(3, -0.5),
    Hidden("load_undulation", _kernel(wave_load=0.05, wave_period=0.7, wave_phase=1.0),
           {"cos": 0.05 * np.sin(1.0), "sin": 0.05 * np.cos(1.0), "period": 0.7},
           begin={"period": 0.69}),
    # the load that the hub shows
    Hidden("load_loss_braking", _kernel(loss_brake=0.08), {"loss": 0.08},
           setting={"seen": 1.0}, left=0.5),
    Hidden("load_loss_braking", _kernel(loss_brake=0.08), {"loss": 0.08},
           setting={"seen": 0.0}, unseen=True),
    Hidden("support_play_z", _kernel(sink_gap=1e-3), {"gap": 1e-3}, left=0.4),
    Hidden("measured_load", _kernel(felt=0.6, uneven=300.0), {"share": 0.6}, left=0.3),
    # steering and side force
    # 1 mrad is there with nothing hidden
    Hidden("steering_zero", {"steer_zero": 6e-3}, {"zero": 5e-3}, design="angles"),
    Hidden("ply_steer", {"steer_zero": -4e-3}, {"angle": 5e-3}, design="angles"),
    # the whole play
    Hidden("steering_play", {"steering_play": {"angle": 0.012, "friction": 1.0}},
           {"play": 0.006}, 0.15, "side slip", left=0.4, world="plant"),
    Hidden("support_play_y", _kernel(side_gap=2e-3), {"gap": 2e-3}, design="angles"),
    Hidden("camber_thrust", {"camber_share": 0.1}, {"share": 0.1}, 0.15, "cambers"),
    Hidden("conicity", {"cone": 0.02}, {"share": 0.02}, design="loads"),
    # sensors
    Hidden("parasitic_force", {"parasitic": (60.0, 48.0)},
           _wave(60.0, 1.1, "fx_cos", "fx_sin") | _wave(48.0, -0.4, "fz_cos", "fz_sin")),
    Hidden("time_skew", {"skew": 0.3}, {"skew": 0.3}),
    Hidden("force_lag", {"lag": 0.5}, {"lag": 0.5}),
    Hidden("hub_gain", _mixed("fx", "fx", 0.05), {"gain": 0.05}),
    # without it the zero of Fx takes its mean: only what varies with the load is left to show it
    Hidden("crosstalk_fz", _mixed("fz", "fx", 0.1, uneven=300.0), {"share": 0.1}, 0.1, "twice",
           setting=NOT_TARED, begin={"share": 0.02}, free=("fx_zero",), left=0.4),
    Hidden("crosstalk_fy", _mixed("fy", "fx", 0.1), {"share": 0.1}, 0.05, "angles twice",
           setting=TARED),
    Hidden("crosstalk_mx", _mixed("mx", "fx", 8.0), {"share": 8.0}, 0.1, "twice", setting=TARED,
           left=0.35),
    Hidden("crosstalk_mz", _mixed("mz", "fx", 8.0), {"share": 8.0}, 0.15, "twice", setting=TARED,
           left=0.5),
    Hidden("crosstalk_fx_fy", _mixed("fx", "fy", 0.05), {"share": 0.05}),
    Hidden("crosstalk_fx_fz", _mixed("fx", "fz", 0.05), {"share": 0.05}, 0.15, left=0.35),
    Hidden("zero_drift", {"drift": 1.0}, {"drift": 1.0}),
    Hidden("zero_drift_runs", {"drift_runs": 80.0}, {"drift": 80.0}),
    # the tire
    _uneven(1), _uneven(2), _uneven(3),
    Hidden("drive_brake_asymmetry", _kernel(brake_grip=0.1), {"less": 0.1}, 0.1),
    Hidden("drive_brake_stiffness", _kernel(brake_tread=0.1), {"less": 0.1}),
    Hidden("carcass_load", {"load_stiff": 0.6}, {"slope": 0.6}, design="loads"),
    Hidden("carcass_pressure", {"pressure_stiff": 1.0}, {"slope": 1.0}, design="pressures"),
    # deflection F/(c - F s) here, F (1 + soften F/4 kN)/c there: alike for small F only
    Hidden("carcass_softening", _kernel(softening=61.0 * 0.25 / 1.25), {"soften": 0.25}, 0.15),
    Hidden("carcass_creep", _kernel(creep=0.5), {"share": 0.5, "time": 8.0}),
    Hidden("rolling_resistance", {"rolling_share": 0.02}, {"share": 0.02}, 0.15, "loads",
           free=("fx_offset",)),
    Hidden("combined_slip", _kernel(circle=1.0), {"share": 1.0}, 0.2, "angles", left=0.35),
    # the base knows the first 6 % of it; 2 mm/s there, 1.5 mm/s here
    Hidden("sliding_friction", _kernel(grip_lost=0.26), {"drop": 0.2}, 0.1, "speeds"),
    Hidden("tire_law", _kernel(tread_x=0.9 * SecondTire().tread_x), {"at_1": -0.1, "at_2": -0.09},
           0.1),
    Hidden("tire_law", _kernel(grip=0.9 * SecondTire().grip), {"at_10": -0.095}, 0.1),
    # the cells of the second tire go through the contact with the wheel
    Hidden("slip_definition", {}, {"more": 1.0}, 0.2, left=0.7),
)  # fmt: skip


def _model(hidden: Hidden, columns: Sequence[Any]) -> TireModel:
    model = TireModel(runs_of(hidden.design, columns))
    if hidden.name == "slip_definition":
        model.parameters = tuple(
            replace(p, null=0.0, screen=0.0) if p.name == "denom" else p for p in model.parameters
        )
    return model


@cache
def _columns(world: str, design: str) -> list[Any]:
    return WORLDS[world](design, {})


@cache
def _tire(world: str, design: str) -> np.ndarray:
    """The base, fitted to runs with nothing hidden."""
    model = TireModel(runs_of(design, _columns(world, design)))
    base = np.array([p.null for p in model.parameters])
    fit = Fitter(model, WEIGHT).fit(base, iterations=12)
    error = np.sqrt(np.mean(fit.residual(model.runs.measured) ** 2, axis=(1, 2)))
    assert np.all(error < 15.0), error
    return fit.base


def _recovered(hidden: Hidden) -> tuple[Fit, float]:
    """The fit of the effect, and the share of the error that it leaves in its main channel."""
    columns = WORLDS[hidden.world](hidden.design, hidden.wrong)
    if hidden.unseen:
        columns = blinded(columns, _columns(hidden.world, hidden.design))
    model = _model(hidden, columns)
    base = _tire(hidden.world, hidden.design).copy()
    held = {p.name: p for p in model.parameters if p.name not in hidden.free}
    for i, p in enumerate(model.parameters):
        base[i] = p.null if p.name == "denom" and not p.screen else base[i]
    model.parameters = tuple(
        replace(p, screen=0.0) if p.name in held else p for p in model.parameters
    )
    effect = library()[hidden.name]
    values = {p.name: p.null + p.screen for p in effect.parameters()}
    term = Term(effect, effect.vector(values | {**hidden.begin, **hidden.setting}),
                tuple(hidden.setting))  # fmt: skip
    fitter = Fitter(model, WEIGHT)
    fit = fitter.fit(base, [term], iterations=15)
    none = fitter.fit(base, iterations=5) if hidden.free else None
    before = model.predict([ParameterSet(base)])[0] if none is None else none.predicted
    measured = model.runs.measured
    one, two = (np.sum((measured - p) ** 2, axis=(1, 2)) for p in (before, fit.predicted))
    shown = one > 0.0
    return fit, float(np.sqrt(np.min(two[shown] / one[shown])))


def test_every_effect_has_a_case():
    assert {c.name for c in CASES} == set(library())


@pytest.mark.parametrize("hidden", CASES, ids=lambda c: c.id)
def test_what_another_world_hides_is_recovered(hidden):
    fit, left = _recovered(hidden)
    found = fit.terms[0].named()
    kinds = {p.name: p.unit for p in fit.terms[0].effect.parameters()}
    for name, value in hidden.wanted.items():
        scale = max(abs(v) for n, v in hidden.wanted.items() if kinds[n] == kinds[name])
        assert abs(found[name] - value) < hidden.within * scale, (found, left)
    assert left < hidden.left, (found, left)


@pytest.mark.parametrize(("design", "asked"), [("speeds", True), ("angles", False)])
def test_friction_over_speed_is_asked_of_two_speeds_only(design, asked):
    """At one speed it is a part of the force law, and the error of its form looks like it."""
    model = TireModel(runs_of(design, _columns("second", design)))
    fit = Fitter(model, WEIGHT).fit(_tire("second", design), iterations=0)
    effect = library()["sliding_friction"]
    found = make_candidates(model, fit, [effect], fit.residual(model.runs.measured))
    assert [c.effect is effect for c in found] == [True] * asked
