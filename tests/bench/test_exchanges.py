# SPDX-License-Identifier: Apache-2.0
"""Samples that are serialised without messages are read by ROS with the same values."""

from __future__ import annotations

import math
import random
import struct
from types import SimpleNamespace

import numpy as np
import pytest
from rclpy.serialization import deserialize_message

from flatplank_control.recording.cdr_layout import CdrLayout
from flatplank_hw.bus.image import AXES, AxisCommand, AxisInputs, BusInputs
from flatplank_hw.drive import REASONS
from flatplank_hw.drive.modes import MODES
from flatplank_hw.nodes import exchanges
from flatplank_hw.nodes.convert import Batch, StampedCommand, StampedMode, StampedWrench
from flatplank_hw.nodes.exchanges import Exchange
from flatplank_hw.nodes.packing import pack_like
from flatplank_hw.samples import SOURCES, DriveSample, EncoderSample, HubSample, Reference, Wrench
from flatplank_msgs.msg import ControllerState, DriveStatus, SequencerState

STAMP = 1_234_567_890_123_456_789
PERIOD = 4_000_000


def values(rng: random.Random, count: int) -> list[float]:
    return [rng.choice((rng.gauss(0.0, 1e3), -0.0, math.inf, 5e-324)) for _ in range(count)]


def batch(rng: random.Random, count: int) -> Batch:
    def axis() -> AxisInputs:
        return AxisInputs(2**16 - 1, -1, -(2**31), 2**31 - 1, rng.randrange(99), 0x7500)

    cycles = [
        BusInputs(
            2**40 + k, STAMP - (count - 1 - k) * PERIOD, tuple(values(rng, 6)), *values(rng, 1),
            -(2**31), 2**31 - 1, 3, 4, 5, 255, 4, tuple(axis() for _ in AXES),
        )
        for k in range(count)
    ]  # fmt: skip
    return Batch(cycles, PERIOD)


def hub(rng: random.Random) -> HubSample:
    nothing = Wrench(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return HubSample(7, STAMP, nothing, nothing, *values(rng, 3), True, 127)


CASES = {
    "a cycle": (exchanges.INPUTS, lambda rng: batch(rng, 1)),
    "a batch": (exchanges.INPUTS, lambda rng: batch(rng, 4)),
    "command": (
        exchanges.COMMAND,
        lambda rng: StampedCommand(
            STAMP, AxisCommand(4, 2**40, 15, 9, -(2**31), 2**31 - 1, rng.randrange(9), 1)
        ),
    ),
    "wrench": (exchanges.WRENCH, lambda rng: StampedWrench(STAMP, Wrench(*values(rng, 6)))),
    "hub": (exchanges.HUB, hub),
    "encoders": (
        exchanges.ENCODERS,
        lambda rng: EncoderSample(7, STAMP, *values(rng, 9), True, False, *values(rng, 1)),
    ),
    "reference": (
        exchanges.REFERENCE,
        lambda rng: Reference(7, STAMP, rng.choice(SOURCES), *values(rng, 1), False),
    ),
    "mode": (exchanges.MODE, lambda rng: StampedMode(STAMP, rng.choice([*MODES]))),
    "drive": (
        exchanges.DRIVE,
        lambda rng: DriveSample(7, STAMP, 4, 1, *values(rng, 6), rng.choice([*REASONS]), 0x7500),
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_a_sample_comes_back_from_its_message(case: str) -> None:
    exchange, make = CASES[case]
    pack = exchange.packing("here")
    for seed in range(20):
        sample = make(random.Random(seed))
        message = deserialize_message(pack(sample), exchange.msg_type)
        assert message.header.frame_id == "here"
        assert exchange.read(message) == sample


def test_the_reason_of_a_stop_is_there_in_words() -> None:
    pack = exchanges.DRIVE.packing("wheel")
    for reason, text in REASONS.items():
        sample = DriveSample(7, STAMP, 4, 1, *[0.0] * 6, reason, 0)
        message = deserialize_message(pack(sample), DriveStatus)
        assert (message.stop_reason, message.stop_text) == (reason, text)


@pytest.mark.parametrize("kind", [SequencerState, ControllerState])
def test_a_message_without_texts_is_packed_from_its_numbers(kind: type) -> None:
    """Only zeros are between the numbers, as in the bags of the twin."""
    layout = CdrLayout(f"flatplank_msgs/msg/{kind.__name__}", {"header.frame_id": "bus"})
    rows = layout.new(1)
    for number, name in enumerate(layout.dtype.names or ()):
        rows[name] = number % 2
    example = kind()
    example.header.frame_id = "bus"
    numbers = [number % 2 for number in range(len(layout.dtype.names or ()))]
    assert pack_like(example)(numbers) == rows.tobytes()


def test_joint_states_have_their_names_and_arrays() -> None:
    exchange: Exchange = exchanges.joint_of_axis("steer")
    sample = DriveSample(7, STAMP, 4, 1, 0.1, 0.2, 0.3, math.nan, math.nan, math.nan, 0, 0)
    message = deserialize_message(exchange.packing("")(sample), exchange.msg_type)
    assert message.name == ["steer"]
    found = [list(array) for array in (message.position, message.velocity, message.effort)]
    assert found == [[0.1], [0.2], [0.3]]
    encoders = EncoderSample(7, STAMP, *np.arange(9.0), True, True, 0.0)
    exchange = exchanges.ENCODER_JOINTS
    message = deserialize_message(exchange.packing("")(encoders), exchange.msg_type)
    assert list(message.position) == [0.0, 2.0, 4.0, 5.0]
    assert list(message.velocity) == [1.0, 3.0, 0.0, 0.0]
    assert not message.effort
    radius = exchanges.HUB_JOINTS
    sample = SimpleNamespace(stamp_ns=STAMP, loaded_radius=0.305)
    message = deserialize_message(radius.packing("")(sample), radius.msg_type)
    assert (message.name, list(message.position)) == (["loaded_radius"], [0.305])


def test_a_number_out_of_range_is_refused() -> None:
    with pytest.raises(struct.error, match="ubyte format requires 0 <= number <= 255"):
        pack_like(DriveStatus())([0, 0, 0, 256, *[0] * 9])
