# SPDX-License-Identifier: Apache-2.0
"""Raw inputs of the bench: volts, counts, noise, stamps."""

from __future__ import annotations

import math

import numpy as np
import pytest
from plant_rig import Rig

from flatplank_hw.hub.appendix_a import contact_from_wheel, gains, wheel_from_volts
from flatplank_hw.hub.params import HubParameters
from flatplank_sim.plant import Plant, PlantConfig


@pytest.mark.parametrize("gamma_deg", [0.0, 5.0, -4.0])
def test_volts_give_the_forces_back_exactly(gamma_deg: float) -> None:
    rig = Rig()
    operator = rig.plant.operator
    operator.steer(0.03)
    operator.wheel_camber(math.radians(gamma_deg) / 2)
    operator.road_camber(math.radians(gamma_deg) / 2)
    rig.load()
    rig.enable()
    rig.roll(0.03, 0.3)
    t, raw = rig.plant.truth, rig.inputs
    wheel = wheel_from_volts(raw.bridge_volts, gains(HubParameters()))
    height = 0.3 + 0.02 * raw.lvdt_volts
    w = contact_from_wheel(wheel, height, math.cos(t.gamma), math.sin(t.gamma))
    assert height == pytest.approx(t.axle_height, abs=1e-12)
    assert (w.fx, w.fy, w.fz) == pytest.approx((t.fx, t.fy, t.fz), rel=1e-12, abs=1e-9)
    assert w.mx == pytest.approx(t.mx, abs=1e-9)
    assert w.mz == pytest.approx(t.mz, abs=1e-9)


def test_spin_axis_moment_is_an_option() -> None:
    rig = Rig(over={"hub.spin_axis_moment": True})
    rig.plant.operator.wheel_camber(math.radians(5.0))
    rig.load()
    rig.enable()
    rig.roll(0.03, 0.3)
    t = rig.plant.truth
    wheel = wheel_from_volts(rig.inputs.bridge_volts, gains(HubParameters()))
    # equilibrium of the contact wrench about the wheel's z axis
    expected = math.cos(t.gamma) * t.mz - math.sin(t.gamma) * t.my
    assert wheel.mz == pytest.approx(expected, abs=1e-9)


NOISE = {"defects": {"sensor_noise": {"bridge": 0.003}}}


def noisy_run(seed: int, **what) -> list:
    plant = Plant(PlantConfig.load(**what), seed)
    plant.operator.load_to(3000.0)
    plant.operator.plank(1, fast=True)
    return [plant.step() for _ in range(3000)]


def test_the_same_seed_gives_the_same_bits_and_another_does_not() -> None:
    one, two, other = (noisy_run(seed, preset="thesis2023") for seed in (3, 3, 4))
    assert one == two
    assert one != other


def test_noise_moves_nothing() -> None:
    one, other = (noisy_run(seed, overrides=NOISE) for seed in (3, 4))
    assert one != other
    assert [r.plank_counts for r in one] == [r.plank_counts for r in other]


def test_noise_is_as_large_as_said() -> None:
    rig = Rig(over={"defects": {"sensor_noise": {"bridge": 0.003}}})
    rig.record = True
    rig.run(20.0)
    volts = np.array([r.bridge_volts for r in rig.raw])
    assert volts.std(axis=0) == pytest.approx(np.full(6, 0.003), rel=0.05)
    step = 20.0 / 2**18
    assert np.abs(volts / step - np.round(volts / step)).max() < 1e-6


def test_cycles_and_stamps() -> None:
    for rate in (250, 1000):
        plant = Plant(PlantConfig.load(), 0, rate_hz=rate)
        rows = [plant.step() for _ in range(3)]
        assert [r.cycle for r in rows] == [0, 1, 2]
        assert [r.stamp_ns for r in rows] == [0, 10**9 // rate, 2 * 10**9 // rate]
    with pytest.raises(ValueError, match="rate_hz"):
        Plant(PlantConfig.load(), 0, rate_hz=300)


def test_a_second_road_encoder_sees_what_the_pinion_encoder_cannot() -> None:
    over = {"encoders.road_encoder_fitted": True, "defects": {"mesh_ripple": {"turn": 1e-3}}}
    rig = Rig(over=over)
    rig.record = True
    rig.plant.operator.plank(1, fast=True)
    rig.run(12.0)
    resolution = 2.0 * math.pi * 0.05 / 20000.0
    road = np.array([r.road_counts for r in rig.raw]) * resolution
    pinion = np.array([r.plank_counts for r in rig.raw]) * resolution
    assert np.abs(road - rig.column("road_position")).max() < 1.01 * resolution
    assert np.ptp(road - pinion) == pytest.approx(0.002, rel=0.05)
    assert Rig().inputs.road_counts == 0, "not fitted by default"
