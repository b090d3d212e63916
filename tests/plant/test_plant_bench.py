# SPDX-License-Identifier: Apache-2.0
"""The bench around the tire: configuration, rate, outputs."""

from __future__ import annotations

import pytest
import yaml
from plant_rig import Rig

from flatplank_hw.bus.image import AXES, AxisCommand
from flatplank_sim.plant import Plant, PlantConfig
from flatplank_sim.plant.yamlconfig import to_plain


def test_the_configuration_survives_yaml_and_names_the_nearest_key(tmp_path) -> None:
    (tmp_path / "bench.yaml").write_text("plank: {road_lenght: 3.0}\n")
    config = PlantConfig.load("continental", preset="thesis2023")
    plain = yaml.safe_load(yaml.safe_dump(to_plain(config)))
    assert PlantConfig.from_plain(plain) == config
    for over, hint in (
        ({"plank.road_lenght": 3.0}, "nearest is 'road_length'"),
        ({"defects": {"road_plai": {}}}, "nearest is 'road_play'"),
        ({"defects": {"road_play": {"gapp": 1.0}}}, "nearest is 'gap'"),
        ({"defects": {"road_play": {"gap": 1.0}}}, "must be within"),
        ({"tire.friction": "slippery"}, "friction must be a number, not 'slippery'"),
        ({"driven_axes": ["weel"]}, "nearest is 'wheel'"),
        ({"servos": {"whel": {}}}, "nearest is 'wheel'"),
    ):
        with pytest.raises(ValueError, match=hint):
            PlantConfig.load(overrides=over)
    with pytest.raises(ValueError, match=r"bench\.yaml: plank: unknown parameter"):
        PlantConfig.load(file=tmp_path / "bench.yaml")
    (tmp_path / "bench.yaml").write_text("plank.road_length: 3.0\ndefects: {road_play: {}}\n")
    assert PlantConfig.load(file=tmp_path / "bench.yaml").plank.road_length == 3.0
    with pytest.raises(ValueError, match="nearest is 'toyo'"):
        PlantConfig.load("toio")
    with pytest.raises(ValueError, match="unknown preset"):
        PlantConfig.load(preset="thesis2032")


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


def test_digital_outputs_are_those_of_all_axes() -> None:
    """The trigger of the wheel's drive stays on whatever another drive commands."""
    plant = Plant(PlantConfig.load(overrides={"driven_axes": ["wheel", "steer"]}))
    wheel, steer = AXES.index("wheel"), AXES.index("steer")

    def run(wheel_bits: int, steer_bits: int) -> int:
        for _ in range(5):
            commands = [
                AxisCommand(axis, plant.cycle, 0, 9, 0, 0, 0, bits)
                for axis, bits in ((wheel, wheel_bits), (steer, steer_bits))
            ]
            plant.step(commands)
        return plant.digital_outputs

    assert run(1, 0) == 1
    assert run(1, 6) == 7
    assert run(0, 6) == 6
    assert run(0, 0) == 0
