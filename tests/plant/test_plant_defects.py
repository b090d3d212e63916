# SPDX-License-Identifier: Apache-2.0
"""Every registered defect shows in the channels that it must touch and leaves alone those that it
must not.
"""

from __future__ import annotations

import math
from dataclasses import fields
from functools import cache

import numpy as np
import pytest
from plant_rig import Rig, wrap_free

from flatplank_hw.hub.appendix_a import contact_from_wheel, gains, wheel_from_volts
from flatplank_hw.hub.params import HubParameters
from flatplank_sim.plant import PlantConfig
from flatplank_sim.plant.defects.base import defects

NEGLIGIBLE = {
    "fx": 2.0, "fy": 2.0, "fz": 2.0, "mz": 0.5, "fx_true": 0.5, "lvdt_volts": 1e-4, "c4": 1e-5,
    "plank_counts": 2, "wheel_counts": 3, "steer_counts": 0, "motor_position": 2**23 * 0.01,
}  # fmt: skip
"""what counts as no difference, in the unit of the channel"""

STEP = (0.0, 0.06, -0.06)
SCENES: dict[str, dict] = {
    "steering_play": {"alpha": 1.0},
    "plank_wander": {"alpha": 0.5},
    "rotation_support_play": {"alpha": 1.5},
    "carcass_load": {"fz": 2500.0},
    "carcass_pressure": {"pressure": 2.0},
    "sandpaper_wear": {"slips": (0.0, 0.12, -0.12)},
    "crosstalk": {"alpha": 0.5},
    "hub_gain": {"alpha": 0.5},
    "lvdt_error": {"alpha": 0.5},
    # a load that moves, so that its lateness shows
    "force_lag": {"also": {"load_change": {}}},
    "time_skew": {"also": {"load_change": {}}},
}
SIZES: dict[str, dict] = {
    "support_bearings": {"positions": [0.3, 0.6], "heights": [1.5e-4]},
    "worn_patches": {"positions": [0.6, 1.0]},
    "sandpaper_wear": {"per_run": 0.005},
    "zero_drift": {"rate": [1e-4] * 6},
    "mains_hum": {"amplitude": 0.01},
    "force_lag": {"time": 0.1},
}


@cache
def scene(name: str, on: bool) -> dict[str, np.ndarray]:
    """Channels of a run: load, roll, drive, brake; all by the clock, so that runs compare cycle by
    cycle.
    """
    how = SCENES.get(name, {})
    switched = dict(how.get("also", {}))
    if on:
        switched[name] = SIZES.get(name, {})
    rig = Rig(over={"defects": switched})
    operator = rig.plant.operator
    if "pressure" in how:
        operator.pressure(how["pressure"])
    operator.steer(math.radians(how.get("alpha", 0.0)))
    operator.axle_height(0.318 - how.get("fz", 3700.0) / 2.13e5)
    rig.run(9.0)
    rig.enable()
    rig.record = True
    re = 0.31088
    operator.plank(1, fast=True)
    for kappa in how.get("slips", STEP):
        rig.wheel_velocity(0.03092 * (1.0 + kappa) / re)
        rig.run(12.0)
    return channels(rig)


def channels(rig: Rig) -> dict[str, np.ndarray]:
    factors = gains(HubParameters())
    out: dict[str, list[float]] = {k: [] for k in NEGLIGIBLE}
    for truth, raw in zip(rig.rows, rig.raw, strict=True):
        wheel = wheel_from_volts(raw.bridge_volts, factors)
        w = contact_from_wheel(wheel, truth.axle_height, 1.0, 0.0)
        values = (
            w.fx, w.fy, w.fz, w.mz, truth.fx, raw.lvdt_volts, raw.bridge_volts[3],
            raw.plank_counts, raw.wheel_counts, raw.steer_counts, raw.axes[0].position,
        )  # fmt: skip
        for key, value in zip(NEGLIGIBLE, values, strict=True):
            out[key].append(value)
    result = {k: np.array(v) for k, v in out.items()}
    result["motor_position"] = wrap_free(result["motor_position"])
    return result


@pytest.mark.parametrize("name", defects())
def test_a_defect_shows_where_it_must_and_nowhere_else(name: str) -> None:
    cls = defects()[name]
    without, with_it = scene(name, False), scene(name, True)
    change = {k: float(np.abs(with_it[k] - without[k]).max()) for k in NEGLIGIBLE}
    assert cls.touches, "a defect says which channels it touches"
    hidden = {k: change[k] for k in cls.touches if change[k] <= NEGLIGIBLE[k]}
    assert not hidden, f"{name} must show in {hidden}; changes {change}"
    wrong = {k: change[k] for k in cls.spares if change[k] > NEGLIGIBLE[k]}
    assert not wrong, f"{name} must not show in {wrong}"


def test_every_parameter_has_a_unit_a_note_and_a_default_inside_its_bounds() -> None:
    for name, cls in defects().items():
        for info in fields(cls):
            assert info.metadata["unit"] and info.metadata["note"], (name, info)
            values = info.default if isinstance(info.default, tuple) else (info.default,)
            low, high = info.metadata["bounds"]
            assert all(low <= v <= high for v in values), (name, info)
        assert cls.source, f"{name} says where it comes from"


def test_only_sensor_noise_is_on_by_default() -> None:
    assert set(PlantConfig.load().defects) == {"sensor_noise", "mains_hum"}


def test_the_preset_of_the_thesis_has_its_plays() -> None:
    preset = PlantConfig.load(preset="thesis2023").defects
    assert preset["road_play"].gap == 0.00115
    assert preset["sensor_noise"].bridge > 0.0
    assert len(preset) > 15
