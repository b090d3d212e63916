# SPDX-License-Identifier: Apache-2.0
"""Writes one measurement as a rosbag2 bag in MCAP."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from flatplank_control.recording.blocks import TopicBlock, merge_blocks
from flatplank_control.recording.mcap_file import Index, McapFile
from flatplank_control.recording.topics import TopicSpec, qos_text
from flatplank_control.recording.typestore import message_definition, type_hash
from flatplank_data.errors import RecordingError
from flatplank_data.files import write_atomic
from flatplank_data.naming import check_name
from flatplank_data.yaml_text import dump_yaml, parse_yaml

CHUNK_SIZE = 512 * 1024
"""size at which a chunk is written to disk [bytes]"""
FLUSH_PERIOD = 0.5
"""longest time between two writes to disk [s]; a kill loses the messages since the last one"""
RESERVE_NAME = ".reserve"
RESERVE_SIZE = 1024 * 1024
"""disk space reserved to finish the bag when the disk is full [bytes]"""


def bag_file_name(name: str) -> str:
    """File name in a bag: rosbag2 numbers the files, and ours are never split."""
    return f"{name}_0.mcap"


class BagWriter:
    """A folder `name` with `name_0.mcap`; `metadata.yaml` appears when it is closed.

    After a kill only the last half second is missing on disk. While no message comes, `poll`
    flushes in place of `write`.
    """

    def __init__(
        self,
        folder: Path | str,
        name: str,
        topics: Sequence[TopicSpec],
        *,
        flush_period: float = FLUSH_PERIOD,
        chunk_size: int = CHUNK_SIZE,
        clock: Callable[[], float] = time.monotonic,
        open_file: Callable[[Path], McapFile] = McapFile.create,
    ) -> None:
        """The bag's folder is made in the existing `folder`; periods in s, sizes in bytes."""
        self.path = Path(folder) / check_name(name)
        self.file_name = bag_file_name(name)
        self.error: str | None = None
        self._closed = False
        self._flush_period = flush_period
        self._chunk_size = chunk_size
        self._clock = clock
        self._next_flush = clock() + flush_period
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        definitions = {spec.type: message_definition(spec.type) for spec in topics}
        try:
            self.path.mkdir()
            self._reserve()
            self._file = open_file(self.path / self.file_name)
            for spec in topics:
                self._add_topic(spec, definitions[spec.type])
        except OSError as error:
            raise RecordingError(f"{self.path}: cannot be written ({error.strerror})") from error

    @property
    def message_count(self) -> int:
        """Number of messages written to disk."""
        return self._file.index.messages

    def write(self, topic: str, cdr: bytes, stamp_ns: int, received_ns: int | None = None) -> None:
        """Write a serialised message; its stamp is the publish time, its reception (by default
        its stamp) the log time, both in bench time [ns]."""
        if self.error or self._closed:
            raise RecordingError(self.error or f"{self.path}: the bag is closed")
        try:
            channel = self._channels[topic]
        except KeyError:
            raise self._unknown(topic) from None
        file = self._file
        file.add(channel, stamp_ns if received_ns is None else received_ns, cdr, stamp_ns)
        if file.pending >= self._chunk_size or self._clock() >= self._next_flush:
            self.flush()

    def write_blocks(self, blocks: Sequence[TopicBlock]) -> None:
        """Write many messages of many topics, merged in time order; see `TopicBlock`."""
        if self.error or self._closed:
            raise RecordingError(self.error or f"{self.path}: the bag is closed")
        for block in blocks:
            if block.topic not in self._channels:
                raise self._unknown(block.topic)
        self.flush()
        chunk = merge_blocks(blocks, self._channels)
        if chunk is not None:
            self._guarded(lambda: self._file.add_chunk(*chunk))

    def poll(self) -> None:
        """Flush when it is due; call it regularly while no message comes."""
        if not self.error and not self._closed and self._clock() >= self._next_flush:
            self.flush()

    def flush(self) -> None:
        """Write everything to disk."""
        self._next_flush = self._clock() + self._flush_period
        self._guarded(self._file.flush)

    def close(self, status: str, custom: Mapping[str, str] | None = None) -> None:
        """Finish the bag; also after an error, as far as the disk allows.

        `status` and `custom` (text) go into `custom_data` of the metadata.
        """
        if self._closed:
            return
        self._closed = True
        (self.path / RESERVE_NAME).unlink(missing_ok=True)
        try:
            if self.error:
                self._file.drop_pending()
            self._file.flush()
            finish_bag(self._file, self.path, {"status": status, **(custom or {})})
        except OSError as error:
            self._file.abandon()
            self.error = (
                f"{self.path}: not finished ({error.strerror}); what is written is kept, "
                "free the disk and start the recorder again to repair it"
            )
            raise RecordingError(self.error) from error

    def discard(self) -> None:
        """Close and delete the bag."""
        self._closed = True
        self._file.abandon()
        shutil.rmtree(self.path)

    def _guarded(self, write: Callable[[], None]) -> None:
        try:
            write()
        except OSError as error:
            self.error = (
                f"{self.path}: recording stopped, the disk does not take more "
                f"({error.strerror}); what is written stays readable"
            )
            raise RecordingError(self.error) from error

    def _unknown(self, topic: str) -> RecordingError:
        return RecordingError(f"{topic}: not a topic of {self.path.name}; name it at the start")

    def _add_topic(self, spec: TopicSpec, definition: str) -> None:
        schema = self._schemas.get(spec.type)
        if schema is None:
            schema = self._schemas[spec.type] = self._file.add_schema(spec.type, definition)
        information = {
            "offered_qos_profiles": qos_text(spec.qos),
            "topic_type_hash": type_hash(spec.type),
        }
        self._channels[spec.name] = self._file.add_channel(spec.name, schema, information)

    def _reserve(self) -> None:
        with open(self.path / RESERVE_NAME, "wb") as reserve:
            os.posix_fallocate(reserve.fileno(), 0, RESERVE_SIZE)


METADATA = "metadata.yaml"


def finish_bag(file: McapFile, folder: Path, custom: Mapping[str, str]) -> None:
    """Finish the file and write the folder's metadata; `custom`: goes into `custom_data`."""
    content = _information(file.index, bag_file_name(folder.name), custom)
    text = dump_yaml(content)
    file.add_metadata("rosbag2", {"serialized_metadata": text})
    file.finish()
    text = dump_yaml({"rosbag2_bagfile_information": content})
    write_atomic(folder / METADATA, text, durable=False)


def _information(index: Index, file_name: str, custom: Mapping[str, str]) -> dict[str, Any]:
    """Content of `rosbag2_bagfile_information`, version 9, as Jazzy writes it."""
    duration = {"nanoseconds": index.end_ns - index.start_ns}
    start = {"nanoseconds_since_epoch": index.start_ns}
    return {
        "version": 9,
        "storage_identifier": "mcap",
        "duration": duration,
        "starting_time": start,
        "message_count": index.messages,
        "topics_with_message_count": _topics(index),
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [file_name],
        "files": [
            {
                "path": file_name,
                "starting_time": dict(start),
                "duration": dict(duration),
                "message_count": index.messages,
            }
        ],
        "custom_data": {key: str(value) for key, value in custom.items()} or None,
        "ros_distro": "jazzy",
    }


def _topics(index: Index) -> list[dict[str, Any]]:
    return [
        {
            "topic_metadata": {
                "name": channel.topic,
                "type": index.schemas[channel.schema_id].name,
                "serialization_format": channel.message_encoding,
                "offered_qos_profiles": parse_yaml(
                    channel.metadata.get("offered_qos_profiles", "[]")
                ),
                "type_description_hash": channel.metadata.get("topic_type_hash", ""),
            },
            "message_count": index.counts.get(channel.id, 0),
        }
        for channel in index.channels.values()
    ]
