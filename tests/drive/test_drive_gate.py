# SPDX-License-Identifier: Apache-2.0
"""Numbers that are not finite or beyond a limit enter no drive: a request is refused, a reference
does not count, and the axis stops when no good one comes.
"""

from __future__ import annotations

import math

import pytest
from drive_rig import PERIOD, Rig, up

from flatplank_hw.drive.road_trigger import BIT, RoadTrigger
from flatplank_hw.drive.safety import RULES
from flatplank_hw.samples import EncoderSample, HubSample, Reference

BAD = (math.nan, math.inf, -math.inf, 1e308, -1e308)
SOURCES = {"slip": ("slip", 0.1, 0.301), "free_rolling": ("free_rolling", 3.0, 12.1)}
"""mode -> source, a good reference, one just beyond the limit of the drive"""


def rolling(mode: str) -> Rig:
    """A loaded wheel that follows a good reference."""
    source, good, _ = SOURCES[mode]
    rig = up(mode)
    rig.load()
    rig.source, rig.reference = source, good
    rig.plank(True)
    rig.run(50)
    assert rig.velocity > 0.0
    return rig


def fastest(rig: Rig, cycles: int) -> float:
    """Largest speed of the motor in the next cycles, and at their end it must rest."""
    most = 0.0
    for _ in range(cycles):
        rig.cycle()
        most = max(most, abs(rig.velocity))
    assert rig.velocity == 0.0
    return most


@pytest.mark.parametrize("mode", SOURCES)
@pytest.mark.parametrize("value", (*BAD, "beyond"))
def test_a_bad_reference_does_not_move_the_axis_and_stops_it(mode, value):
    rig = rolling(mode)
    before = rig.velocity
    rig.reference = SOURCES[mode][2] if value == "beyond" else value
    assert fastest(rig, 25) <= before
    assert rig.samples[-1].stop_reason == RULES["reference"].code
    assert "reference is " in rig.drive.troubles["reference"]


@pytest.mark.parametrize("mode", SOURCES)
def test_a_single_bad_reference_is_bridged(mode):
    rig = rolling(mode)
    before, good = rig.velocity, rig.reference
    rig.reference = math.inf
    rig.run(3)
    rig.reference = good
    rig.run(20)
    assert rig.velocity == before
    assert not rig.drive.troubles


def test_a_reference_at_the_limit_is_followed():
    rig = rolling("slip")
    rig.reference = rig.drive.parameters.speed_limit
    rig.run(50)
    assert rig.velocity == pytest.approx(0.3, rel=1e-6)


def test_a_reference_from_before_the_enabling_is_not_used():
    """An invalid reference comes after the enabling: the good one of before must not count."""
    rig = rolling("slip")
    rig.drive.disable()
    rig.run(30)
    assert rig.velocity == 0.0
    rig.drive.enable()
    rig.reference = math.inf
    assert fastest(rig, 40) == 0.0


def stepped(rig: Rig, stamps: dict[str, int]) -> int:
    """Stop reason after a cycle whose samples have stamps shifted by so much [ns]."""
    n, stamp = rig.n, rig.n * PERIOD
    inputs = rig.image(n, stamp + stamps.get("inputs", 0))
    encoders: EncoderSample = rig._encoders._replace(stamp_ns=stamp + stamps.get("encoders", 0))
    hub: HubSample = rig._hub._replace(stamp_ns=stamp + stamps.get("hub", 0))
    reference = Reference(n, stamp + stamps.get("reference", 0), "slip", 0.1, True)
    _, sample = rig.drive.step(inputs, encoders, hub, reference)
    return sample.stop_reason


@pytest.mark.parametrize(
    ("what", "rule"),
    [
        ("inputs", "inputs"),
        ("encoders", "samples"),
        ("hub", "samples"),
        ("reference", "reference"),
    ],
)
@pytest.mark.parametrize("seconds", [-10, 10])
def test_a_stamp_of_another_time_counts_as_lost(what, rule, seconds):
    rig = rolling("slip")
    assert stepped(rig, {}) == 0
    rig.n += 1
    shift = {what: seconds * 1_000_000_000}
    if what == "reference":
        codes = []
        for _ in range(15):
            codes.append(stepped(rig, shift))
            rig.n += 1
        assert codes[-1] == RULES[rule].code
        return
    assert stepped(rig, shift) == RULES[rule].code


REQUESTS = {
    "move_to": lambda d, x: d.move_to(x),
    "speed of a move": lambda d, x: d.move_to(0.1, x),
    "position": lambda d, x: d.set_operation_mode("position", x),
    "velocity": lambda d, x: d.set_operation_mode("velocity", x),
    "torque": lambda d, x: d.set_operation_mode("torque", x),
}


@pytest.mark.parametrize("what", REQUESTS)
@pytest.mark.parametrize("value", BAD)
def test_a_request_with_a_bad_number_is_refused_in_one_line(what, value):
    rig = up("position")
    answer = REQUESTS[what](rig.drive, value)
    assert not answer.accepted
    assert "must be" in answer.reason and "\n" not in answer.reason
    rig.run(10)
    assert rig.velocity == 0.0


@pytest.mark.parametrize("distance", [math.nan, math.inf, 1e308, 5e-324, 1e-7, 4.3])
def test_the_road_trigger_takes_only_distances_of_the_road(distance):
    rig = up("slip")
    assert "must be" in rig.drive.set_trigger(distance).reason
    rig.plank(True)
    rig.run(10)
    assert not any(c.digital_outputs for c in rig.commands)


@pytest.mark.parametrize("distance", [0.0, -1.0, 1e-5, 0.01, 4.2])
def test_the_road_trigger_is_set(distance):
    rig = up("slip")
    assert rig.drive.set_trigger(distance).accepted
    rig.load()
    rig.reference = 0.1
    rig.plank(True)
    rig.run(10)
    assert rig.drive.road_trigger.armed is (distance >= 0.0)


def test_the_road_trigger_gives_one_pulse_per_distance():
    trigger = RoadTrigger()
    trigger.arm(1e-3)
    step = 1.25e-4  # a cycle at 31 mm/s
    bits = [trigger.step(0.01 + step * (k + 0.5), True) for k in range(81)]
    assert [k for k, bit in enumerate(bits) if bit] == list(range(8, 81, 8))
    assert trigger.pulses == 10
    assert not any(trigger.step(0.0205, False) for _ in range(5))


def test_a_road_trigger_that_is_not_armed_gives_nothing_and_a_new_one_counts_from_zero():
    trigger = RoadTrigger()
    assert not any(trigger.step(0.01 * k, True) for k in range(3))
    trigger.arm(1e-3)
    assert any(trigger.step(0.0001 * k, True) for k in range(20))
    trigger.disarm()
    assert not any(trigger.step(0.01 * k, True) for k in range(3))
    trigger.arm(0.0)
    assert trigger.pulses == 0 and trigger.step(0.0, False) == BIT


def test_before_the_first_inputs_nothing_has_moved():
    rig = Rig()
    assert rig.drive.position == 0.0
    assert "start the bus" in rig.drive.enable().reason
    assert rig.drive.set_operation_mode("velocity", 0.1).accepted  # the axis does not turn


def test_a_constant_level_of_the_road_trigger_counts_as_one_pulse():
    trigger = RoadTrigger()
    trigger.arm(0.0)
    assert [trigger.step(0.1 * k, True) for k in range(4)] == [trigger.step(0.0, False)] * 4
    assert trigger.pulses == 1


def test_commands_are_whole_numbers():
    """As the frames need them."""
    for mode, reference in (("free_rolling", 3.14159), ("slip", 0.0987654)):
        rig = rolling(mode)
        rig.reference = reference
        rig.run(10)
        assert all(type(value) is int for value in rig.commands[-1])
