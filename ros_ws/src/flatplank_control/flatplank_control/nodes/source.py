# SPDX-License-Identifier: Apache-2.0
"""Base of the nodes that send references: they work only while their drive is in their mode."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flatplank_hw.bus.image import AXES
from flatplank_hw.cia402 import in_operation
from flatplank_hw.joining import CycleJoin
from flatplank_hw.nodes import convert, exchanges
from flatplank_hw.nodes.qos import LATCHED, REFERENCE, STREAM
from flatplank_hw.nodes.support import BenchNode
from flatplank_hw.samples import EncoderSample, Reference

WHEEL = AXES.index("wheel")


def named_values(request: Any) -> dict[str, float]:
    """Parameters of a SetWaveform request by name; ValueError when they are no pairs."""
    names, values = list(request.parameters), list(request.values)
    if len(names) != len(values):
        raise ValueError(f"{len(names)} parameters and {len(values)} values: give one for each")
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(f"given twice: {', '.join(twice)}")
    return dict(zip(names, values, strict=True))


class SourceNode(BenchNode):
    """Joins the samples of a cycle, calls its core, and publishes the reference for its drive.

    A subclass has `core` (with `reset()`), `MODE`, the `KINDS` of samples that it needs, and
    `compute(latest)`. Where it has `STATE`, that message shows the `state` of its core.

    The mode of the drive has the stamp of the last cycle before the drive awaits references. The
    samples of the next cycle take other ways and may be here before the mode: so the latest sample
    of each kind is kept, and the source works from the first cycle whose reference is awaited.
    """

    MODE: str
    STATE: type | None = None
    KINDS: tuple[str, ...] = ("encoders", "contact")
    drive = "wheel_drive"

    def connect(self) -> None:
        self.active = False
        self.early: dict[str, tuple[int, Any]] = {}
        """kind -> stamp [ns] and latest sample, while the source does not work"""
        self.publish = self.add_sample_publisher(
            exchanges.REFERENCE, f"{self.drive}/reference", REFERENCE, needed=True
        )
        self.add_sample_subscription(
            exchanges.ENCODERS, "encoders/state", self.on_encoders, STREAM
        )
        if "contact" in self.KINDS:
            topic = "measurement_hub/wrench_contact"
            self.add_sample_subscription(
                exchanges.WRENCH,
                topic,
                lambda s: self.take("contact", s.stamp_ns, s.wrench),
                STREAM,
            )
        if self.STATE is not None:
            exchange = exchanges.state_exchange(self.STATE)
            self.publish_state = self.add_sample_publisher(exchange, "~/state", STREAM)
        self.add_sample_subscription(exchanges.MODE, f"{self.drive}/mode", self.on_mode, LATCHED)

    def on_mode(self, stamped: convert.StampedMode) -> None:
        was_active, self.active = self.active, stamped.mode == self.MODE
        if self.active and not was_active:
            self.core.reset()
            self.join = CycleJoin(self.KINDS, self.on_cycle)
            for kind, (stamp_ns, sample) in self.early.items():
                if stamp_ns > stamped.stamp_ns:
                    self.join.put(kind, stamp_ns, sample)
            self.early.clear()

    def on_encoders(self, sample: EncoderSample) -> None:
        self.take("encoders", sample.stamp_ns, sample)

    def take(self, kind: str, stamp_ns: int, sample: Any) -> None:
        """Take a sample of the cycle of that stamp [ns]."""
        if self.active:
            self.join.put(kind, stamp_ns, sample)
        else:
            self.early[kind] = stamp_ns, sample

    def on_cycle(self, _at: int, latest: Mapping[str, Any]) -> None:
        if any(sample is None for sample in latest.values()):
            return  # the first cycle is incomplete: no reference yet
        reference: Reference = self.compute(latest)
        self.publish(reference)
        if self.STATE is not None:
            state = self.core.state
            self.publish_state(convert.StampedState(reference.stamp_ns, reference.cycle, state))


class WheelSourceNode(SourceNode):
    """Source of the wheel drive. While the drive is not in operation the core starts anew in each
    cycle: what the wheel loses then is not to be recovered."""

    KINDS: tuple[str, ...] = ("encoders", "inputs")

    def connect(self) -> None:
        super().connect()
        self.add_sample_subscription(exchanges.INPUTS, "bus/inputs", self.on_inputs, STREAM)

    def on_inputs(self, batch: convert.Batch) -> None:
        inputs = batch.cycles[-1]
        self.take("inputs", inputs.stamp_ns, inputs)

    def compute(self, latest: Mapping[str, Any]) -> Reference:
        if not in_operation(latest["inputs"].axes[WHEEL].status_word):
            self.core.reset()
        return self.step(latest)

    def step(self, latest: Mapping[str, Any]) -> Reference:
        """Reference of a cycle, by the core."""
        raise NotImplementedError


class FollowerNode(SourceNode):
    """Controller of a further driven axis; its core has `reference(hub, encoders)`."""

    MODE = "follow"

    def compute(self, latest: Mapping[str, Any]) -> Reference:
        encoders = latest["encoders"]
        return self.core.reference(convert.hub_of_contact(latest["contact"], encoders), encoders)
