# SPDX-License-Identifier: Apache-2.0
"""The recorder without ROS: idle, armed (waits for the motion trigger) or recording."""

from __future__ import annotations

import shutil
from collections import deque
from collections.abc import Callable, Sequence
from enum import Enum
from pathlib import Path
from typing import NamedTuple

import numpy as np

from flatplank_control.recording.bag_writer import BagWriter
from flatplank_control.recording.blocks import TopicBlock, unroll
from flatplank_control.recording.bus_cycles import TOPIC as BUS_TOPIC
from flatplank_control.recording.bus_cycles import BusImage, CycleCount, read_bus_image
from flatplank_control.recording.topics import RUN_TOPIC, TopicSpec, run_message
from flatplank_data.errors import RecordingError
from flatplank_data.measured import STOPPED
from flatplank_data.naming import free_name
from flatplank_data.run_record import RunRecord

NOTHING = "nothing is being recorded; start first"
"""reason for a refused stop or discard"""
FREE_DISK = 200_000_000
"""the disk counts as full below this free space [bytes]"""


SAME_CLOCK_NS = 1_000_000_000
"""a stamp that is further ahead of the bus than this is of another clock [ns]"""
RING_LENGTH = 1_000_000
"""largest number of messages kept before the trigger"""


class _Waiting(NamedTuple):
    """A message received before the trigger."""

    since_ns: int
    """its stamp; the bus time at its arrival when the stamp is of another clock [ns]"""
    topic: str
    cdr: bytes
    stamp_ns: int
    received_ns: int


class State(Enum):
    """State of the session."""

    IDLE = "idle"
    ARMED = "armed"
    RECORDING = "recording"


class RecordingSession:
    """Records one measurement after another into a data folder; the node passes every message to
    it.

    It writes `/run` itself, at the start and end of each bag. A refused call raises RecordingError
    with the reason and changes nothing.
    """

    def __init__(
        self,
        folder: Path | str,
        topics: Sequence[TopicSpec],
        *,
        pre_trigger: float = 2.0,
        open_bag: Callable[..., BagWriter] = BagWriter,
        free_disk: Callable[[Path], int] = lambda folder: shutil.disk_usage(folder).free,
    ) -> None:
        """`pre_trigger`: time before the motion trigger that is recorded [s]."""
        self.folder = Path(folder).absolute()
        self.state = State.IDLE
        self.record: RunRecord | None = None
        """record of the present or last measurement"""
        self.path: Path | None = None
        self.cycles = CycleCount()
        self._topics = [*(t for t in topics if t.name != RUN_TOPIC.name)]
        self._names = {topic.name for topic in self._topics}
        self._latched = {topic.name: b"" for topic in self._topics if topic.qos.latched}
        """topic -> last latched message; every bag begins with these"""
        self._pre_trigger_ns = round(pre_trigger * 1e9)
        self._open_bag = open_bag
        self._free_disk = free_disk
        self._bag: BagWriter | None = None
        self._ring: deque[_Waiting] = deque(maxlen=RING_LENGTH)
        self._trigger_before = True
        self._bus_ns = self._received_ns = 0

    def start(
        self,
        record: RunRecord,
        stamp_ns: int,
        *,
        folder: Path | str | None = None,
        at_once: bool = False,
    ) -> Path:
        """Arm for a run; `at_once` starts without the trigger. Returns the path of the bag."""
        if self.state is not State.IDLE:
            name = self.record.name if self.record else ""
            raise RecordingError(f"{name} is {self.state.value}; stop or discard it first")
        target = Path(folder).expanduser().absolute() if folder else self.folder
        self._check_folder(target)
        record = record.with_changes(name=free_name(target, record.name), status="armed")
        bag = self._open_bag(target, record.name, [RUN_TOPIC, *self._topics])
        self._bag, self.path, self.record = bag, bag.path, record
        self.cycles = CycleCount()
        self._clear_ring()
        self._trigger_before, self._bus_ns, self._received_ns = True, stamp_ns, stamp_ns
        self.state = State.ARMED
        try:
            record.save(bag.path)
            bag.write(RUN_TOPIC.name, run_message(record, stamp_ns), stamp_ns)
            bag.flush()
        except (OSError, RecordingError) as error:
            self._finish("failed", str(error), "")
            raise RecordingError(f"{bag.path}: cannot be written ({error})") from error
        if at_once:
            self._begin()
        return bag.path

    def write(self, topic: str, cdr: bytes, stamp_ns: int, received_ns: int | None = None) -> None:
        """Process a message; when idle only latched messages are kept, for the next bag.

        `received_ns`: bench time of its reception, by default its stamp [ns]. When the disk is
        full, the run is closed as failed and RecordingError is raised, once.
        """
        if topic not in self._names:
            return
        if self.state is State.IDLE:
            self._remember(topic, cdr)
            return
        received_ns = stamp_ns if received_ns is None else received_ns
        self._received_ns = received_ns
        image = read_bus_image(cdr) if topic == BUS_TOPIC else None
        if image is not None:
            if stamp_ns < self._bus_ns:
                self._clear_ring()  # the bus was restarted
            self._bus_ns = stamp_ns
        if self.state is State.RECORDING:
            self._put(topic, cdr, stamp_ns, received_ns, image)
            return
        ahead = stamp_ns > self._bus_ns + SAME_CLOCK_NS
        since_ns = self._bus_ns if ahead else stamp_ns
        self._ring.append(_Waiting(since_ns, topic, cdr, stamp_ns, received_ns))
        if image is not None:
            while self._too_old(self._ring[0]):
                self._drop_oldest()
            if self._rising(image):
                self._begin()

    def write_blocks(self, blocks: Sequence[TopicBlock]) -> None:
        """Process many messages of the twin at once; payloads are arrays of `CdrLayout`."""
        blocks = [block for block in blocks if block.topic in self._names]
        bag = self._bag
        if self.state is not State.RECORDING or bag is None:
            for topic, cdr, stamp_ns in unroll(blocks):
                self.write(topic, cdr, stamp_ns)
            return
        self._guarded(lambda: bag.write_blocks(blocks))
        for block in blocks:
            if block.topic == BUS_TOPIC:
                self._bus_ns = int(np.max(block.stamps_ns, initial=self._bus_ns))
                self._received_ns = self._bus_ns
                last: np.ndarray = block.payload["cycle"].astype(np.int64)
                first = last - np.maximum(block.payload["count"], 1) + 1
                period = int(block.payload["period_ns"][0])
                self.cycles.add_many(first, last, block.stamps_ns, period)

    def poll(self) -> None:
        """Write pending messages to disk; call it a few times a second."""
        if self._bag is not None:
            self._guarded(self._bag.poll)

    def stop(
        self,
        status: str = "stopped",
        *,
        reason: str = "",
        ended: str = "",
        fill: Callable[[RunRecord, Path], RunRecord] | None = None,
    ) -> RunRecord:
        """Close the bag; `ended` is the time of day, ISO 8601. Returns the closed record.

        `fill` completes the record; it may read the messages in the bag's folder. A stop that it
        finds in them is the status.
        """
        bag = self._bag
        if bag is None or self.record is None:
            raise RecordingError(NOTHING)
        self.record.with_changes(status=status)  # refuses an unknown status
        if fill is not None and self.state is State.RECORDING:
            self._guarded(bag.flush)
            self.record = fill(self.record, bag.path)
            if self.record.status == STOPPED:
                status = STOPPED
                reason = "; ".join(filter(None, (self.record.stop_reason, reason)))
        return self._finish(status, reason, ended)

    def discard(self) -> Path:
        """Stop and delete the bag; returns its path."""
        if self._bag is None or self.record is None:
            raise RecordingError(NOTHING)
        bag, self._bag = self._bag, None
        self.record = self.record.with_changes(status="discarded")
        self.state = State.IDLE
        self._clear_ring()
        bag.discard()
        return bag.path

    def close(self) -> None:
        """Close an open bag at the end of the program."""
        if self.state is not State.IDLE:
            self._finish("interrupted", "the recorder was shut down", "")

    def __enter__(self) -> RecordingSession:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _check_folder(self, folder: Path) -> None:
        if not folder.is_dir():
            raise RecordingError(f"{folder}: no such folder; make it or name another")
        free = self._free_disk(folder)
        if free < FREE_DISK:
            raise RecordingError(
                f"{folder}: the disk is full ({free / 1e6:.0f} MB free, "
                f"{FREE_DISK / 1e6:.0f} MB needed); make room"
            )

    def _rising(self, image: BusImage) -> bool:
        before, self._trigger_before = self._trigger_before, image.trigger
        return image.trigger and not before

    def _begin(self) -> None:
        bag = self._bag
        assert bag is not None and self.record is not None
        self.state = State.RECORDING
        self.record = record = self.record.with_changes(status="recording")
        self._guarded(lambda: record.save(bag.path))
        self._drop_old()
        begin_ns = min((w.since_ns for w in self._ring), default=self._bus_ns)
        for topic, cdr in self._latched.items():
            if cdr and self.state is State.RECORDING:
                self._put(topic, cdr, begin_ns, begin_ns, None)
        while self._ring and self.state is State.RECORDING:
            _, topic, cdr, stamp_ns, received_ns = self._ring.popleft()
            image = read_bus_image(cdr) if topic == BUS_TOPIC else None
            self._put(topic, cdr, stamp_ns, received_ns, image)

    def _put(
        self, topic: str, cdr: bytes, stamp_ns: int, received_ns: int, image: BusImage | None
    ) -> None:
        bag = self._bag
        assert bag is not None
        try:
            bag.write(topic, cdr, stamp_ns, received_ns)
        except RecordingError as error:
            self._finish("failed", str(error), "")
            raise
        self._remember(topic, cdr)
        if image is not None:
            self.cycles.add(image)

    def _remember(self, topic: str, cdr: bytes) -> None:
        if topic in self._latched:
            self._latched[topic] = cdr

    def _too_old(self, waiting: _Waiting) -> bool:
        return waiting.since_ns < self._bus_ns - self._pre_trigger_ns

    def _drop_old(self) -> None:
        """Drop what is too old, also where it arrived after younger messages."""
        for _ in range(len(self._ring)):
            if self._too_old(self._ring[0]):
                self._drop_oldest()
            else:
                self._ring.rotate(-1)

    def _drop_oldest(self) -> None:
        dropped = self._ring.popleft()
        self._remember(dropped.topic, dropped.cdr)

    def _clear_ring(self) -> None:
        while self._ring:
            self._drop_oldest()

    def _guarded(self, action: Callable[[], None]) -> None:
        try:
            action()
        except (OSError, RecordingError) as error:
            self._finish("failed", str(error), "")
            raise RecordingError(str(error)) from error

    def _finish(self, status: str, reason: str, ended: str) -> RunRecord:
        """Close the bag in any case; the record states what has failed."""
        bag, self._bag = self._bag, None
        assert bag is not None and self.record is not None
        self.state = State.IDLE
        self._clear_ring()
        self.record = record = self._closed(status, reason, ended)
        if bag.error is None:
            message = run_message(record, self._bus_ns)
            try:
                bag.write(RUN_TOPIC.name, message, self._bus_ns, self._received_ns)
            except RecordingError as error:
                self.record = record = self._closed("failed", str(error), ended)
        try:
            bag.close(record.status, {"uuid": record.uuid, "tire": record.tire})
            record.save(bag.path)
        except (OSError, RecordingError) as error:
            self.record = record = self._closed("failed", f"{reason} {error}".strip(), ended)
        return record

    def _closed(self, status: str, reason: str, ended: str) -> RunRecord:
        assert self.record is not None
        record = self.cycles.with_bus_cycles(self.record)
        return record.with_changes(status=status, stop_reason=reason, ended=ended)
