# SPDX-License-Identifier: Apache-2.0
"""The bus changes nothing: the same commands give the same motion as on the plant alone."""

from __future__ import annotations

from ethercat_rig import TURNING, VELOCITY_MODE, Bench

from flatplank_hw.bus.image import AxisCommand, BusInputs
from flatplank_sim.plant import Plant, PlantConfig

UPWARD = {0x40: 0x06, 0x60: 0x06, 0x21: 0x07, 0x23: 0x0F, 0x27: 0x0F}
SETTLED, LENGTH, TRIALS = 200, 60, 3
"""cycles at rest first; cycles compared"""


def answer(inputs: BusInputs, speed: int) -> AxisCommand:
    """Towards enabled, at a speed [counts/s]."""
    word = UPWARD.get(inputs.axes[0].status_word & 0x6F, 0)
    return AxisCommand(0, inputs.cycle, word, VELOCITY_MODE, 0, speed, 0, 0)


def alone() -> list[tuple[int, int, int]]:
    """Motion of the plant after a step of the speed, and its wheel encoder."""
    plant = Plant(PlantConfig.load("toyo"), 1, 250)
    plant.operator.unload()
    inputs, seen = plant.step(), []
    for n in range(SETTLED + LENGTH):
        inputs = plant.step((answer(inputs, TURNING if n >= SETTLED else 0),))
        if n >= SETTLED:
            seen.append(motion(inputs))
    return seen


def motion(inputs: BusInputs) -> tuple[int, int, int]:
    """Integers that carry no noise."""
    return inputs.axes[0].position, inputs.axes[0].velocity, inputs.wheel_counts


def over_the_bus(bench: Bench) -> list[tuple[int, int, int]]:
    """The same over frames; from rest."""
    node, seen = bench.node, []
    node.insists, node.speed = True, 0
    node.cycles(SETTLED)
    node.speed = TURNING
    start = node.last.cycle

    def look(inputs: BusInputs) -> bool:
        if inputs.cycle > start + 1:
            seen.append(motion(inputs))
        return len(seen) == LENGTH

    node.run(look)
    return seen


def test_same_motion_with_the_same_delay() -> None:
    """A command delivered a cycle late spoils a trial; three are made at most."""
    expected = alone()
    assert any(velocity for _, velocity, _ in expected)
    for _ in range(TRIALS):
        bench = Bench()
        try:
            bench.unload()
            seen = over_the_bus(bench)
        finally:
            bench.close()
        if seen == expected:
            break
    assert seen == expected
