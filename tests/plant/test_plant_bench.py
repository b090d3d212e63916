# SPDX-License-Identifier: Apache-2.0
"""The bench around the tire: switches, sensors, determinism, a whole sequence, the campaign
path.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
import yaml
from plant_rig import QUIET, Rig

from flatplank_hw.bus.image import Digital
from flatplank_hw.hub.appendix_a import contact_from_wheel, gains, wheel_from_volts
from flatplank_hw.hub.params import HubParameters
from flatplank_hw.plant import Plant, PlantConfig
from flatplank_hw.plant.campaign import Campaign, CampaignRun


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


def noisy_run(seed: int) -> list:
    plant = Plant(PlantConfig.load(preset="thesis2023"), seed)
    plant.operator.load_to(3000.0)
    plant.operator.plank(1, fast=True)
    return [plant.step() for _ in range(3000)]


def test_the_same_seed_gives_the_same_bits_and_another_does_not() -> None:
    one, two, other = noisy_run(3), noisy_run(3), noisy_run(4)
    assert one == two
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


def test_the_rate_of_the_bus_does_not_change_the_physics() -> None:
    fx = []
    for rate in (250, 1000):
        rig = Rig(rate_hz=rate)
        rig.plant.operator.axle_height(0.30)
        rig.run(6.0)
        rig.enable()
        rig.plant.operator.plank(1, fast=True)
        rig.wheel_velocity(0.03092 * 1.05 / 0.31088)
        rig.run(30.0)
        fx.append(rig.plant.truth.fx)
    assert fx[0] == pytest.approx(fx[1], abs=3.0)


def test_the_plank_starts_stops_and_ends_at_its_switches() -> None:
    rig = Rig()
    operator = rig.plant.operator
    rig.record = True
    operator.plank(1, fast=True)
    rig.run(0.5)
    assert rig.plant.truth.road_velocity == pytest.approx(0.03092)
    moving = rig.column("road_velocity") > 0.0
    assert np.diff(rig.column("road_velocity"))[1:30].max() == pytest.approx(
        0.206 * 0.004, rel=0.01
    )
    assert moving.any()
    operator.plank_stop_at(0.3)
    rig.run(12.0)
    assert rig.plant.truth.plank_position == pytest.approx(0.3, abs=1e-4)
    operator.plank(-1, fast=True)
    rig.run(14.0)
    assert rig.inputs.digital & Digital.LIMIT_REAR
    assert rig.plant.truth.plank_position == pytest.approx(-0.01, abs=0.004)
    operator.plank(1, fast=False)
    rig.run(2.0)
    assert rig.plant.truth.road_velocity == pytest.approx(0.0015)
    rig.plant.operator.plank(1, fast=True)
    rig.run(160.0)
    assert rig.inputs.digital & Digital.LIMIT_FRONT
    assert rig.plant.truth.road_velocity == 0.0
    assert rig.plant.truth.plank_position == pytest.approx(4.22, abs=0.003)


def test_the_trigger_comes_at_its_place_and_counts_the_run() -> None:
    rig = Rig()
    rig.record = True
    rig.plant.operator.plank(1, fast=True, stop_at=0.2)
    rig.run(9.0)
    on = np.array([bool(r.digital & Digital.TRIGGER) for r in rig.raw])
    x = rig.column("plank_position")
    assert x[on].min() == pytest.approx(0.02, abs=2e-4)
    assert x[on].max() == pytest.approx(0.05, abs=2e-4)
    assert rig.plant.operator.view.runs == 1
    assert rig.inputs.plank_counts == pytest.approx(0.2 / (2 * math.pi * 0.05) * 20000, abs=8)


def test_the_emergency_stop_stops_the_plank_at_once_and_not_the_wheel() -> None:
    rig = Rig()
    rig.enable()
    rig.wheel_velocity(0.1)
    rig.plant.operator.plank(1, fast=True)
    rig.run(2.0)
    rig.plant.operator.emergency_stop()
    rig.run(0.06)
    assert rig.plant.truth.road_velocity == 0.0
    assert not rig.inputs.digital & Digital.EMERGENCY_STOP_OK
    rig.run(0.3)
    assert rig.plant.truth.wheel_velocity == pytest.approx(0.1, rel=1e-3)
    rig.plant.operator.emergency_stop(False)
    rig.run(0.5)
    assert rig.inputs.digital & Digital.EMERGENCY_STOP_OK
    assert rig.plant.truth.road_velocity == 0.0, "released, nothing moves by itself"


def test_the_operators_sequence_unload_return_turn_reload_run() -> None:
    rig = Rig(over={"plank.return_speed": 0.3})
    operator = rig.plant.operator
    forces = []
    for start in (0.0, 2.0 * math.pi / 3.0):
        operator.unload()
        rig.until(lambda t: operator.view.at_target)
        operator.plank(-1, fast=True, stop_at=0.0)
        rig.until(lambda t: t.plank_position < 1e-4 and not operator.view.plank_moving)
        rig.enable()
        goal = start - rig.plant.truth.wheel_angle % (2.0 * math.pi)
        rig.wheel_velocity(0.2)
        rig.run((goal % (2.0 * math.pi)) / 0.2)
        rig.wheel_velocity(0.0)
        rig.run(0.5)
        assert rig.plant.truth.fz == 0.0
        operator.load_to(3700.0)
        rig.until(lambda t: operator.view.load_reached)
        assert rig.plant.truth.fz == pytest.approx(3700.0, abs=1.0)
        assert rig.plant.truth.fx == 0.0, "a reloaded tire is straight"
        rig.roll(0.05, 1.6)
        forces.append(rig.plant.truth.fx)
        operator.plank(0)
        rig.wheel_velocity(0.0)
        rig.run(1.0)
    assert operator.view.runs == 2
    assert forces[0] == pytest.approx(forces[1], abs=3.0)


def test_the_operator_refuses_what_cannot_be() -> None:
    operator = Rig().plant.operator
    before = operator.view
    for wrong in (
        lambda: operator.plank(2),
        lambda: operator.plank(1, stop_at=9.0),
        lambda: operator.axle_height(math.nan),
        lambda: operator.load_to(-1.0),
        lambda: operator.steer(1.0),
        lambda: operator.wheel_camber(math.inf),
        lambda: operator.pressure(30.0),
    ):
        with pytest.raises(ValueError, match=r"outside|not -1"):
            wrong()
    assert operator.view == before


def test_load_follows_height_and_pressure() -> None:
    rig = Rig()
    rig.plant.operator.axle_height(0.30)
    rig.run(6.0)
    assert rig.plant.truth.fz == pytest.approx(0.018 * 2.13e5, rel=1e-6)
    rig.plant.operator.pressure(2.0)
    rig.run(0.1)
    assert rig.plant.truth.fz == pytest.approx(0.018 * 1.77e5, rel=2e-3)


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


def test_a_standing_tire_has_a_lateral_stiffness() -> None:
    rig = Rig()
    rig.load()
    rig.plant.operator.lateral(0.001)
    rig.run(1.0)
    t = rig.plant.truth
    stuck = 1.0 / (1.0 / 1.1e5 + 1.0 / (2 * 0.0708 * 5.8e6))
    assert -t.fy / 0.001 == pytest.approx(stuck, rel=0.05)
    rig.plant.operator.lateral(0.0)
    rig.run(1.0)
    assert abs(rig.plant.truth.fy) < 20.0


def test_a_cleat_lifts_the_tire_and_pushes_it_back_and_forth() -> None:
    rig = Rig(over={"cleat": {"height": 0.003, "position": 0.5}})
    rig.load()
    rig.enable()
    rig.record = True
    rig.roll(0.0, 0.8)
    x, fx, fz = rig.column("road_position"), rig.column("fx"), rig.column("fz")
    assert fz.max() == pytest.approx(3700.0 + 0.003 * 2.13e5, rel=0.01)
    assert x[fz.argmax()] == pytest.approx(0.5, abs=0.005)
    near = (x > 0.4) & (x < 0.6)
    assert x[near][fx[near].argmin()] < 0.5 < x[near][fx[near].argmax()]
    assert fx[near].min() < -100.0


def test_the_configuration_survives_yaml_and_names_the_nearest_key(tmp_path) -> None:
    (tmp_path / "bench.yaml").write_text("plank: {road_lenght: 3.0}\n")
    config = PlantConfig.load("continental", preset="thesis2023")
    plain = yaml.safe_load(yaml.safe_dump(config.to_plain()))
    assert PlantConfig.from_plain(plain) == config
    for over, hint in (
        ({"plank.road_lenght": 3.0}, "nearest is 'road_length'"),
        ({"defects": {"road_plai": {}}}, "nearest is 'road_play'"),
        ({"defects": {"road_play": {"gapp": 1.0}}}, "nearest is 'gap'"),
        ({"defects": {"road_play": {"gap": 1.0}}}, "outside"),
        ({"tire.friction": "slippery"}, "expected a number"),
        ({"driven_axes": ["weel"]}, "nearest is 'wheel'"),
        ({"servos": {"whel": {}}}, "nearest is 'wheel'"),
    ):
        with pytest.raises(ValueError, match=hint):
            PlantConfig.load(overrides=over)
    with pytest.raises(ValueError, match=r"bench\.yaml: plank: unknown key"):
        PlantConfig.load(file=tmp_path / "bench.yaml")
    (tmp_path / "bench.yaml").write_text("plank.road_length: 3.0\ndefects: {road_play: {}}\n")
    assert PlantConfig.load(file=tmp_path / "bench.yaml").plank.road_length == 3.0
    with pytest.raises(ValueError, match="nearest is 'toyo'"):
        PlantConfig.load("toio")
    with pytest.raises(ValueError, match="unknown preset"):
        PlantConfig.load(preset="thesis2032")


def test_a_run_of_the_campaign_path_equals_the_bench() -> None:
    config = PlantConfig.load(overrides=QUIET)
    campaign = Campaign(config)
    run = CampaignRun(
        kappa=0.05,
        effective_rolling_radius=0.31088,
        step_position=0.8,
        length=2.0,
        start_delay=0.0355,
    )
    (table,) = campaign.simulate([run])
    rig = Rig()
    rig.plant.operator.axle_height(0.318 - 3700.0 / 2.13e5)
    rig.run(8.0)
    rig.enable()
    rig.record = True
    rig.plant.operator.plank(1, fast=True)
    per_count = 2.0 * math.pi * 0.05 / 20000.0
    while rig.plant.truth.road_position < 2.0:
        x = rig.inputs.plank_counts * per_count
        kappa = 0.05 if x - 0.02 >= 0.8 else 0.0
        rig.wheel_velocity(0.03092 * (1.0 + kappa) / 0.31088 if x > 0.0 else 0.0)
        rig.run(0.004)
    x = rig.column("road_position")
    other = np.interp(x, table["road_position"], table["fx_true"])
    # the servo starts ideally in the campaign path; what that leaves behind rolls out
    difference = np.abs(other - rig.column("fx"))
    assert difference[x > 0.05].max() < 15.0
    assert difference[x > 1.3].max() < 2.0
    k = x > 1.3
    wheel = np.interp(x, table["road_position"], table["wheel_velocity"])
    assert wheel[k] == pytest.approx(rig.column("wheel_velocity")[k], rel=1e-4)
    torque = np.interp(x, table["road_position"], table["motor_torque"])
    assert torque[k] == pytest.approx(rig.column("motor_torque")[k], abs=0.03)


def test_half_the_step_hardly_changes_a_run_of_the_campaign_path() -> None:
    config = PlantConfig.load(overrides=QUIET)
    run = CampaignRun(kappa=0.05, length=1.5, step_position=0.8)
    fx = []
    for step in (0.008, 0.004):
        (table,) = Campaign(config, tire_step=step).simulate([run])
        fx.append(np.interp(np.linspace(0.1, 1.4, 400), table["road_position"], table["fx_true"]))
    assert np.abs(fx[0] - fx[1]).max() < 3.0


def test_a_free_wheel_of_the_campaign_path_has_the_true_radius() -> None:
    campaign = Campaign(PlantConfig.load(overrides=QUIET))
    (table,) = campaign.simulate([CampaignRun(free=True, length=2.0)])
    k = table["road_position"] > 1.0
    radius = np.polyfit(table["wheel_angle"][k], table["road_position"][k], 1)[0]
    assert radius == pytest.approx(0.31088, rel=1e-3)
    assert table["fx_true"][-1] == pytest.approx(-44.0, abs=2.0)


def test_a_campaign_is_the_same_for_the_same_seed_and_knows_all_defects() -> None:
    campaign = Campaign(PlantConfig.load(preset="thesis2023"))
    runs = [
        CampaignRun(kappa=k, length=1.0, step_position=0.5, run_index=i)
        for i, k in enumerate((0.02, -0.02))
    ]
    one = list(campaign.simulate(runs, seed=5))
    two = list(campaign.simulate(runs, seed=5))
    for a, b in zip(one, two, strict=True):
        assert all(np.array_equal(a[key], b[key]) for key in a)
        assert all(np.isfinite(a[key]).all() for key in a)
    assert one[0]["fx"][-1] > 200.0 > -200.0 > one[1]["fx"][-1]
