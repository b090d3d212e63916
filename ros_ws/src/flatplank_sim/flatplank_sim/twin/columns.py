# SPDX-License-Identifier: Apache-2.0
"""Converts the cycles of the twin to columns of messages per topic, as the nodes publish them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import chain
from typing import Any, NamedTuple

import numpy as np

from flatplank_hw.bus.image import AXES, CHANNELS, PER_CYCLE, AxisInputs
from flatplank_hw.drive import REASONS
from flatplank_hw.samples import (
    JOINTS,
    RADIUS_JOINT,
    SOURCES,
    DriveSample,
    EncoderSample,
    HubSample,
)
from flatplank_sim.twin.twin import Cycle


class TopicColumns(NamedTuple):
    """Functions that fill the messages of a topic."""

    fixed: Callable[[int], Mapping[str, Any]]
    """batch size -> texts and lengths of the messages"""
    pick: Callable[[Cycle], Any]
    """cycle -> sample; None: the topic has no message"""
    columns: Callable[[list[Any]], Mapping[str, Any]]
    texts: Callable[[Any], Mapping[str, str]] | None = None
    """sample -> texts, where they vary"""


def _array(samples: Sequence[Any]) -> np.ndarray:
    return np.array(samples, dtype=np.float64)


def _flat(tuples: Iterable[tuple], dtype: type) -> np.ndarray:
    """All numbers of tuples in a row; `np.array` takes several times as long for tuples."""
    return np.fromiter(chain.from_iterable(tuples), dtype)


def _by_name(samples: Sequence[Any]) -> dict[str, tuple]:
    """Values of named tuples by name."""
    return dict(zip(samples[0]._fields, zip(*samples, strict=True), strict=True))


def _bus_fixed(n: int) -> dict[str, Any]:
    return {
        "header.frame_id": "bus",
        "bridge_volts": CHANNELS * n,
        **dict.fromkeys(PER_CYCLE, n),
        **dict.fromkeys(AxisInputs._fields, len(AXES) * n),
    }


def _bus(batches: list[tuple]) -> dict[str, Any]:
    n = len(batches[0])
    images = [image for batch in batches for image in batch]
    rows, by_name = len(batches), _by_name(images)
    out: dict[str, Any] = {
        "cycle": [batch[-1].cycle for batch in batches],
        "count": n,
        "health": [batch[-1].health for batch in batches],
        "bridge_volts": _flat(by_name["bridge_volts"], np.float64).reshape(rows, -1),
    }
    for name in PER_CYCLE:
        out[name] = np.array(by_name[name]).reshape(rows, n)
    axes = _flat(chain.from_iterable(by_name["axes"]), np.int64)
    axes = axes.reshape(-1, len(AxisInputs._fields))
    for k, name in enumerate(AxisInputs._fields):
        out[name] = axes[:, k].reshape(rows, -1)
    return out


def _outputs(commands: list) -> dict[str, Any]:
    return {n: np.array(values, dtype=np.int64) for n, values in _by_name(commands).items()}


def _wrench(samples: list) -> dict[str, Any]:
    rows = _flat(samples, np.float64).reshape(len(samples), -1)
    names = [f"wrench.{kind}.{axis}" for kind in ("force", "torque") for axis in "xyz"]
    return {name: rows[:, k] for k, name in enumerate(names)}


def _fields(cls: Any, leave: tuple[str, ...] = ("stamp_ns",)) -> Callable[[list], dict[str, Any]]:
    names = [n for n in cls._fields if n not in leave]

    def columns(samples: list) -> dict[str, Any]:
        by_name = _by_name(samples)
        return {n: np.array(by_name[n]) for n in names}

    return columns


def _encoder_joints(samples: list[EncoderSample]) -> dict[str, Any]:
    return {
        "position": _array(
            [(s.plank_position, s.wheel_angle, s.steer_angle, s.road_camber) for s in samples]
        ),
        "velocity": _array([(s.plank_velocity, s.wheel_velocity, 0.0, 0.0) for s in samples]),
    }


def _drive_joints(samples: list[DriveSample]) -> dict[str, Any]:
    return {
        "position": _array([(s.position,) for s in samples]),
        "velocity": _array([(s.velocity,) for s in samples]),
        "effort": _array([(s.torque,) for s in samples]),
    }


def _reference(samples: list) -> dict[str, Any]:
    return {
        "cycle": [r.cycle for r in samples],
        "source": SOURCES.index(samples[0].source),
        "value": _array([r.value for r in samples]),
        "valid": [r.valid for r in samples],
    }


def _inside(source: str) -> Callable[[Cycle], Any]:
    def pick(cycle: Cycle) -> Any:
        reference = cycle.reference
        return (cycle, cycle.inside) if reference and reference.source == source else None

    return pick


def _inside_columns(pairs: list) -> dict[str, Any]:
    by_name = _by_name([s for _, s in pairs])
    out: dict[str, Any] = {n: np.array(values) for n, values in by_name.items()}
    out["cycle"] = [cycle.encoders.cycle for cycle, _ in pairs]
    return out


def _frame(frame: str, /, **lengths: Any) -> Callable[[int], Mapping[str, Any]]:
    return lambda _n: {"header.frame_id": frame, **lengths}


TOPICS: dict[str, TopicColumns] = {
    "/bus/inputs": TopicColumns(_bus_fixed, lambda c: c.batch, _bus),
    "/bus/outputs": TopicColumns(_frame("wheel"), lambda c: c.command, _outputs),
    "/measurement_hub/wrench_wheel": TopicColumns(
        _frame("wheel_center"), lambda c: c.hub.wheel, _wrench
    ),
    "/measurement_hub/wrench_contact": TopicColumns(
        _frame("contact_point"), lambda c: c.hub.contact, _wrench
    ),
    "/measurement_hub/state": TopicColumns(
        _frame("contact_point"),
        lambda c: c.hub,
        _fields(HubSample, ("stamp_ns", "wheel", "contact")),
    ),
    "/measurement_hub/joint_states": TopicColumns(
        _frame("", name=[RADIUS_JOINT], position=1),
        lambda c: c.hub,
        lambda samples: {"position": _array([(s.loaded_radius,) for s in samples])},
    ),
    "/encoders/state": TopicColumns(_frame("bus"), lambda c: c.encoders, _fields(EncoderSample)),
    "/encoders/joint_states": TopicColumns(
        _frame("", name=list(JOINTS), position=4, velocity=4),
        lambda c: c.encoders,
        _encoder_joints,
    ),
    "/wheel_drive/status": TopicColumns(
        _frame("wheel"),
        lambda c: c.drive,
        _fields(DriveSample),
        lambda sample: {"stop_text": REASONS[sample.stop_reason]},
    ),
    "/wheel_drive/joint_states": TopicColumns(
        _frame("", name=["wheel"], position=1, velocity=1, effort=1),
        lambda c: c.drive,
        _drive_joints,
    ),
    "/wheel_drive/reference": TopicColumns(lambda _n: {}, lambda c: c.reference, _reference),
    "/slip_sequencer/state": TopicColumns(_frame(""), _inside("slip"), _inside_columns),
    "/free_rolling_controller/state": TopicColumns(
        _frame(""), _inside("free_rolling"), _inside_columns
    ),
}
"""topics in the order in which messages of one stamp are written"""


def table_columns(cycles: Sequence[Cycle]) -> dict[str, np.ndarray]:
    """Columns of a measurement table; units and axes as defined there."""
    encoders = [c.encoders for c in cycles]
    wrench = _array([c.hub.contact for c in cycles]).reshape(-1, 6)
    out = {"time": np.array([e.stamp_ns for e in encoders]) * 1e-9}

    def put(*names: str) -> None:
        for name in names:
            out[name] = _array([getattr(e, name) for e in encoders])

    put("plank_position", "plank_velocity", "wheel_angle", "wheel_velocity", "motor_velocity")
    out["motor_torque"] = _array([c.drive.torque for c in cycles])
    for k, name in enumerate(("fx", "fy", "fz", "mx", "my", "mz")):
        out[name] = wrench[:, k]
    out["loaded_radius"] = _array([c.hub.loaded_radius for c in cycles])
    out["motion_trigger"] = _array([e.trigger for e in encoders])
    out["drive_state"] = _array([c.drive.state for c in cycles])
    out["stop_reason"] = _array([c.drive.stop_reason for c in cycles])
    put("steer_angle", "road_camber")
    out["total_camber"] = _array([c.hub.total_camber for c in cycles])
    return out
