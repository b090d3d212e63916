# SPDX-License-Identifier: Apache-2.0
"""Effects that the blind kit can hide: their sizes, and how each is switched on in the worlds.
Only the names come from the analysis.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from numpy.random import Generator as Random

Plant = Callable[[float, Random], Mapping[str, Mapping[str, Any]]]
Second = Callable[[float, Random], Mapping[str, Any]]


@dataclass(frozen=True)
class Item:
    """One effect. `plant` gives defects of the plant, `second` fields of SecondMachine."""

    unit: str
    typical: float
    """start value for the search of the detectable size"""
    least: float
    """size of no consequence: smaller effects do not matter, whatever the noise"""
    most: float
    plant: Plant | None = None
    second: Second | None = None
    design: str = "plain"
    sized: bool = True
    """False: the effect is present or absent, or its number is not comparable with that of the
    effect"""


def _kernel(*names: str, **fixed: float) -> Second:
    return lambda s, r: {"kernel": {n: s for n in names} | fixed}


def _ripple(size: float, random: Random) -> Mapping[str, Any]:
    period = float(random.choice([0.0157, 0.03, 0.05, 0.1, 0.314]))
    phase = float(random.uniform(0.0, 6.28))
    return {"kernel": {"ripple": size, "ripple_period": period, "ripple_phase": phase}}


def _waving(size: float, random: Random) -> Mapping[str, Any]:
    period, phase = float(random.uniform(0.25, 1.2)), float(random.uniform(0.0, 6.28))
    return {"kernel": {"wave_load": size, "wave_period": period, "wave_phase": phase}}


def _patch(size: float, random: Random) -> Mapping[str, Any]:
    start, length = float(random.uniform(1.9, 3.4)), float(random.uniform(0.12, 0.35))
    return {"patches": ((start, start + length, size),)}


def _plant_patch(size: float, random: Random) -> Mapping[str, Mapping[str, Any]]:
    place, length = float(random.uniform(1.9, 3.6)), float(random.uniform(0.12, 0.3))
    patch = {"positions": [place], "factor": 1.0 - size, "length": length}
    return {"worn_patches": patch}


def _mix(source: str, goal: str) -> Second:
    return lambda s, r: {"mix": {(source, goal): s}}


def _defect(name: str, key: str, factor: float = 1.0, **fixed: Any) -> Plant:
    return lambda s, r: {name: {key: factor * s} | fixed}


# No item for a gap between motor and wheel encoder: the encoder measures the wheel, which is
# the input of the model, so the gap has no effect.
MENU: dict[str, Item] = {
    "road_play": Item(
        "m", 5e-4, 1e-4, 2.5e-3,
        _defect("road_play", "gap"), _kernel("play"),
    ),
    "drive_backlash": Item(
        "m", 5e-4, 1e-4, 2.5e-3, None, _kernel("drive_gap"),
    ),
    "rack_backlash": Item(
        "m", 5e-4, 1e-4, 2.5e-3, _defect("rack_backlash", "gap"), _kernel("rack_gap"),
    ),
    "torn_weld": Item(
        "m", 1e-3, 1e-4, 6e-3, _defect("torn_weld", "gap", seen=0.0),
    ),
    "mesh_ripple": Item(
        "m", 4e-5, 2e-5, 1e-3,
        lambda s, r: {"mesh_ripple": {"tooth": 0.0, "turn": s, "phase": r.uniform(0.0, 6.28)}},
        _ripple,
    ),
    "road_speed_error": Item(
        "1", 1e-3, 5e-4, 0.02,
        _defect("road_speed_error", "unseen", relative=0.0), _kernel("scale_error"),
    ),
    "speed_droop": Item(
        "1/N", 8e-7, 2e-7, 5e-6, None, _kernel("droop"),
    ),
    "time_skew": Item(
        "s", 0.1, 0.02, 0.9,
        _defect("time_skew", "delay"), lambda s, r: {"skew": s},
    ),
    "force_lag": Item(
        "s", 0.1, 0.02, 1.5,
        _defect("force_lag", "time"), lambda s, r: {"lag": s},
    ),
    "measured_load": Item(
        "1", 0.5, 0.3, 1.0, None,
        lambda s, r: {"kernel": {"felt": s, "uneven": 40.0}},
    ),
    "load_loss_braking": Item(
        "1", 0.04, 0.01, 0.2,
        lambda s, r: {"load_change": {"brake": s / 3.7, "drive": 0.0}}, _kernel("loss_brake"),
    ),
    "runout_1": Item(
        "m", 2e-4, 5e-5, 3e-3,
        # a tenth of the deflection reduces the rolling radius
        lambda s, r: {"run_out": {"amplitude": s / 0.2, "rolling_share": 0.3}},
        _kernel("out_1", out_load=1.2e5),
    ),
    "runout_2": Item(
        "m", 2e-4, 5e-5, 3e-3, None, _kernel("out_2", out_load=1.2e5),
    ),
    "runout_3": Item(
        "m", 2e-4, 5e-5, 3e-3, None, _kernel("out_3", out_load=1.2e5),
    ),
    "nonuniformity_1": Item(
        "N", 40.0, 5.0, 500.0, None,
        lambda s, r: {"uneven": (s, 0.0, 0.0)},
    ),
    "nonuniformity_2": Item(
        "N", 40.0, 5.0, 500.0, None, lambda s, r: {"uneven": (0.0, s, 0.0)},
    ),
    "nonuniformity_3": Item(
        "N", 40.0, 5.0, 500.0, None, lambda s, r: {"uneven": (0.0, 0.0, s)},
    ),
    "load_undulation": Item(
        "1", 0.02, 5e-3, 0.2, None, _waving,
    ),
    "worn_patch": Item(
        "1", 0.1, 0.01, 0.6, _plant_patch, _patch,
    ),
    "wear": Item(
        "1", 0.05, 0.01, 0.4,
        lambda s, r: {"sandpaper_wear": {"per_run": s / 26.0}}, lambda s, r: {"wear": s},
    ),
    "parasitic_force": Item(
        "N", 40.0, 5.0, 400.0,
        lambda s, r: {"parasitic_shaft": {"fx": s, "fz": 0.8 * s}},
        lambda s, r: {"parasitic": (s, 0.8 * s)},
    ),
    "hub_gain": Item(
        "1", 0.02, 0.01, 0.3,
        lambda s, r: {"hub_gain": {"fx": s, "fz": 0.0}}, lambda s, r: {"mix": {("fx", "fx"): s}},
    ),
    "crosstalk_fz": Item(
        "1", 0.05, 0.01, 0.3, None,
        lambda s, r: {"mix": {("fz", "fx"): s}, "load_waves": 110.0},
    ),
    "crosstalk_fy": Item(
        "1", 0.1, 0.02, 0.3, None, _mix("fy", "fx"), "angles",
    ),
    "crosstalk_mx": Item(
        "1/m", 3.0, 0.5, 30.0, None, _mix("mx", "fx"),
    ),
    "crosstalk_mz": Item(
        "1/m", 3.0, 0.5, 30.0, None, _mix("mz", "fx"),
    ),
    "crosstalk_fx_fy": Item(
        "1", 0.03, 5e-3, 0.3,
        lambda s, r: {"crosstalk": {"fz_to_fx": 0.0, "fx_to_fy": s}}, _mix("fx", "fy"),
    ),
    "crosstalk_fx_fz": Item(
        "1", 0.03, 0.01, 0.3, None, _mix("fx", "fz"),
    ),
    "zero_drift": Item(
        "N/s", 0.5, 0.04, 3.0, None, lambda s, r: {"drift": s},
    ),
    "zero_drift_runs": Item(
        "N", 60.0, 5.0, 300.0, None, lambda s, r: {"drift_runs": s},
    ),
    "steering_play": Item(
        "rad", 3e-3, 5e-4, 0.03, None, _kernel("steer_play"), "angles",
    ),
    "steering_zero": Item(
        # a protractor is read to a tenth of a degree
        "rad", 2e-3, 2e-3, 0.05, None,
        lambda s, r: {"steer_zero": s}, "angles",
    ),
    "support_play_y": Item(
        "m", 1e-3, 2e-4, 6e-3, None, _kernel("side_gap"), "angles",
    ),
    "support_play_z": Item(
        "m", 5e-4, 1e-4, 2e-3, None,
        _kernel("sink_gap"),
    ),
    "drive_brake_asymmetry": Item(
        "1", 0.05, 0.01, 0.4,
        _defect("drive_brake_asymmetry", "friction"), _kernel("brake_grip"),
    ),
    "drive_brake_stiffness": Item(
        "1", 0.05, 0.01, 0.4, None,
        _kernel("brake_tread"),
    ),
    "carcass_load": Item(
        "1", 0.5, 0.05, 1.8, None, lambda s, r: {"load_stiff": s}, "loads",
    ),
    "carcass_pressure": Item(
        "1", 1.0, 0.05, 2.8, None, lambda s, r: {"pressure_stiff": s},
        "pressures",
    ),
    "carcass_softening": Item(
        "1", 0.5, 0.05, 2.0,
        # at 4 kN the deflection is 4000/c/(1 - 4000 per_metre/c)
        lambda s, r: {"carcass_softening": {"per_metre": 60.0 * s / (1.0 + s)}},
        lambda s, r: {"kernel": {"softening": 61.0 * s / (1.0 + s)}},
    ),
    "carcass_creep": Item(
        "1", 0.3, 0.05, 1.8,
        _defect("carcass_creep", "share", time=8.0), _kernel("creep"),
    ),
    "rolling_resistance": Item(
        "1", 0.02, 2e-3, 0.05, None,
        lambda s, r: {"rolling_share": s}, "loads",
    ),
    "combined_slip": Item(
        "1", 1.0, 1.0, 1.0, None, _kernel("circle"), "angles", sized=False,
    ),
    "camber_thrust": Item(
        "1", 0.1, 0.01, 0.5, None, lambda s, r: {"camber_share": s}, "cambers",
    ),
    "conicity": Item(
        "1", 0.01, 2e-3, 0.05, None,
        lambda s, r: {"cone": s}, "loads",
    ),
}  # fmt: skip

KIN: dict[str, tuple[str, ...]] = {
    "drive_backlash": ("rack_backlash",),
    "rack_backlash": ("drive_backlash", "road_play"),
    "torn_weld": ("road_play", "rack_backlash", "drive_backlash"),
    "speed_droop": ("carcass_softening",),
    "time_skew": ("force_lag",),
    "force_lag": ("time_skew",),
    "load_loss_braking": ("crosstalk_fx_fz", "drive_brake_asymmetry"),
    "runout_1": ("nonuniformity_1",),
    "runout_2": ("nonuniformity_2",),
    "runout_3": ("nonuniformity_3", "mesh_ripple", "load_undulation"),
    "nonuniformity_1": ("parasitic_force", "runout_1"),
    "nonuniformity_2": ("runout_2",),
    "nonuniformity_3": ("runout_3", "mesh_ripple", "load_undulation"),
    "parasitic_force": ("nonuniformity_1",),
    "crosstalk_fx_fz": ("load_loss_braking",),
    "steering_zero": ("ply_steer",),
    "support_play_z": ("load_loss_braking", "crosstalk_fx_fz"),
    "drive_brake_asymmetry": ("load_loss_braking", "crosstalk_fx_fz", "drive_brake_stiffness"),
    "drive_brake_stiffness": ("drive_brake_asymmetry",),
    "carcass_softening": ("speed_droop",),
    "carcass_creep": ("carcass_softening", "speed_droop"),
    "conicity": ("ply_steer", "steering_zero"),
}
"""hidden effect -> similar effects; they are reported beside the score, never counted as right"""

PAIRS: tuple[tuple[str, str], ...] = (
    ("drive_backlash", "drive_brake_asymmetry"), ("road_play", "parasitic_force"),
    ("worn_patch", "parasitic_force"), ("mesh_ripple", "drive_backlash"),
    ("runout_1", "drive_brake_asymmetry"), ("wear", "road_play"), ("time_skew", "parasitic_force"),
    ("load_loss_braking", "worn_patch"), ("zero_drift", "road_play"),
    ("zero_drift_runs", "parasitic_force"), ("runout_2", "drive_backlash"),
    ("mesh_ripple", "worn_patch"), ("load_undulation", "parasitic_force"),
    ("crosstalk_fx_fy", "road_play"), ("speed_droop", "parasitic_force"),
    ("nonuniformity_2", "worn_patch"), ("drive_brake_asymmetry", "mesh_ripple"),
    ("force_lag", "drive_brake_asymmetry"), ("wear", "parasitic_force"),
    ("crosstalk_mz", "worn_patch"),
)  # fmt: skip
