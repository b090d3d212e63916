# SPDX-License-Identifier: Apache-2.0
"""Repairs bags that a killed recorder left open, at its next start."""

from __future__ import annotations

import fcntl
import re
from io import FileIO
from pathlib import Path
from typing import NamedTuple

from rosbags.serde import SerdeError

from flatplank_control.recording.bag_writer import (
    METADATA,
    RESERVE_NAME,
    bag_file_name,
    finish_bag,
)
from flatplank_control.recording.bus_cycles import TOPIC as BUS_TOPIC
from flatplank_control.recording.bus_cycles import CycleCount, read_bus_image
from flatplank_control.recording.mcap_file import McapFile
from flatplank_control.recording.mcap_scan import Scan, scan, stored_messages
from flatplank_control.recording.topics import RUN_TOPIC, run_message
from flatplank_control.recording.typestore import typestore
from flatplank_data import run_record
from flatplank_data.errors import RecordingError
from flatplank_data.files import PART
from flatplank_data.run_record import RunRecord

_OPEN_STATUSES = ("described", "armed", "recording")
_STATUS = re.compile(r"^status: (\w+)", re.MULTILINE)
_REASON = "the recorder ended without closing the bag; repaired at the next start"


class RepairedBag(NamedTuple):
    """A bag that was repaired, or could not be."""

    path: Path
    messages: int
    note: str
    """what was done, or why nothing could be done"""

    def __str__(self) -> str:
        return f"{self.path.name}: {self.note}"


def repair(folder: Path | str) -> list[RepairedBag]:
    """Repair every bag of this recorder in the data folder, except those being written."""
    repaired = []
    for path in sorted(path for path in Path(folder).iterdir() if path.is_dir()):
        if not (path / bag_file_name(path.name)).is_file():
            continue
        try:
            result = repair_bag(path)
        except (RecordingError, OSError) as error:
            result = RepairedBag(path, 0, f"not repaired: {error}")
        if result is not None:
            repaired.append(result)
    return repaired


def repair_bag(path: Path) -> RepairedBag | None:
    """Repair one bag; None when there is nothing to do."""
    if _is_whole(path):
        return None
    file = path / bag_file_name(path.name)
    with FileIO(file, "r+b") as stream:
        try:
            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return None
        found = scan(file)
        for leftover in (path / RESERVE_NAME, *path.glob(f"*{PART}")):
            leftover.unlink(missing_ok=True)
        record, is_final, trouble = _readable_record(path, found)
        _finish(stream, path, found, record, is_final)
    if record is not None:
        record.save(path)
    status = record.status if record else "interrupted"
    messages = found.index.messages
    return RepairedBag(path, messages, f"closed as {status} with {messages} messages{trouble}")


def _finish(
    stream: FileIO, path: Path, found: Scan, record: RunRecord | None, is_final: bool
) -> None:
    """Append the last messages, the record, metadata and summary to the complete part."""
    stream.truncate(found.end)
    stream.seek(found.end)
    file = McapFile(stream, found.index, found.end)
    for message in found.rest:
        file.add(*message)
    file.flush()
    channel = _channel_of(found, RUN_TOPIC.name)
    if record is not None and channel is not None and not is_final:
        stamp_ns = file.index.end_ns
        file.add(channel, stamp_ns, run_message(record, stamp_ns), stamp_ns)
        file.flush()
    custom = {"status": "interrupted"}
    if record is not None:
        custom = {"status": record.status, "uuid": record.uuid, "tire": record.tire}
    finish_bag(file, path, custom)


def _is_whole(path: Path) -> bool:
    """True for a closed bag: only the run record is written after the metadata."""
    if not (path / METADATA).is_file():
        return False
    run = path / run_record.FILE_NAME
    status = _STATUS.search(run.read_text(encoding="utf-8")) if run.is_file() else None
    return status is None or status[1] not in _OPEN_STATUSES


def _readable_record(path: Path, found: Scan) -> tuple[RunRecord | None, bool, str]:
    """The run record, or a substitute when it cannot be read, so that the messages are saved."""
    try:
        return *_record(path, found), ""
    except (RecordingError, SerdeError) as error:
        return None, False, f"; its run record cannot be read ({error})"


def _record(path: Path, found: Scan) -> tuple[RunRecord | None, bool]:
    """The final run record, and whether the bag already contains it.

    The last message on /run is newer than the file beside it.
    """
    run, bus = (_channel_of(found, topic) for topic in (RUN_TOPIC.name, BUS_TOPIC))
    run_messages: list[bytes] = []
    cycles = CycleCount()
    stored = stored_messages(path / bag_file_name(path.name), found.index)
    for message in (*stored, *found.rest):
        if message.channel == bus:
            cycles.add(read_bus_image(message.data))
        elif message.channel == run:
            run_messages.append(message.data)
    if run_messages:
        message = typestore().deserialize_cdr(run_messages[-1], RUN_TOPIC.type)
        record = run_record.record_from_yaml(message.record, str(path))
    elif (path / run_record.FILE_NAME).is_file():
        record = run_record.load_record(path)
    else:
        return None, False
    if record.status not in _OPEN_STATUSES:
        return record, True
    return cycles.with_bus_cycles(record).with_changes(
        status="interrupted", stop_reason=_REASON
    ), False


def _channel_of(found: Scan, topic: str) -> int | None:
    return next((c.id for c in found.index.channels.values() if c.topic == topic), None)
