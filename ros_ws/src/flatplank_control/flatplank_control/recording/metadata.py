# SPDX-License-Identifier: Apache-2.0
"""`metadata.yaml` of a rosbag2 bag, version 9, as Jazzy writes it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from flatplank_control.recording.mcap_file import Index
from flatplank_data.files import write_atomic

FILE_NAME = "metadata.yaml"
VERSION = 9


def bag_information(index: Index, file_name: str, custom: Mapping[str, str]) -> dict[str, Any]:
    """Content of `rosbag2_bagfile_information`; `custom` is free text for people and programs."""
    duration = {"nanoseconds": index.end_ns - index.start_ns}
    start = {"nanoseconds_since_epoch": index.start_ns}
    return {
        "version": VERSION,
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
                "offered_qos_profiles": yaml.safe_load(
                    channel.metadata.get("offered_qos_profiles", "[]")
                ),
                "type_description_hash": channel.metadata.get("topic_type_hash", ""),
            },
            "message_count": index.counts.get(channel.id, 0),
        }
        for channel in index.channels.values()
    ]


def text(information: Mapping[str, Any]) -> str:
    return yaml.safe_dump(dict(information), sort_keys=False)


def write(folder: Path, information: Mapping[str, Any]) -> None:
    """Replace the folder's metadata in one step."""
    content = text({"rosbag2_bagfile_information": dict(information)})
    write_atomic(folder / FILE_NAME, content, durable=False)
