# SPDX-License-Identifier: Apache-2.0
"""The file of a bag byte by byte, as the package `mcap` understands it; scans of cut files."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import NonSeekingReader, SeekingReader, make_reader

from flatplank_control.recording import typestore as types
from flatplank_control.recording.bag_writer import _information, bag_file_name
from flatplank_control.recording.cdr_layout import CdrLayout, set_stamps
from flatplank_control.recording.mcap_file import MAGIC, McapFile
from flatplank_control.recording.mcap_scan import scan, stored_messages
from flatplank_data.errors import RecordingError

MESSAGES = [(1, 50, b"abc", 40), (2, 30, b"", 31), (1, 60, b"defgh", 60)]
MORE = [(2, 90, b"x" * 10, 80), (2, 95, b"y", 96)]


def written(path: Path, end: str = "finish") -> McapFile:
    """A file of two chunks, of two channels of one schema."""
    file = McapFile.create(path)
    schema = file.add_schema("a/msg/B", "int32 x")
    for topic in ("/one", "/two"):
        file.add_channel(topic, schema, {"of": topic})
    for message in MESSAGES:
        file.add(*message)
    assert file.pending == 3 * 31 + 8
    file.flush()
    file.flush()
    assert file.pending == 0
    for message in MORE:
        file.add(*message)
    if end == "finish":
        file.add_metadata("rosbag2", {"a": "b"})
        file.finish()
    elif end == "drop":
        file.drop_pending()
        file.finish()
    else:
        file.abandon()
    return file


def test_the_summary_is_that_which_another_program_reads(tmp_path):
    written(tmp_path / "a.mcap")
    data = (tmp_path / "a.mcap").read_bytes()
    with (tmp_path / "a.mcap").open("rb") as stream:
        summary = make_reader(stream).get_summary()
    s = summary.statistics
    assert (s.message_count, s.chunk_count, s.channel_count, s.schema_count) == (5, 2, 2, 1)
    assert (s.message_start_time, s.message_end_time, s.metadata_count) == (30, 95, 1)
    assert (s.channel_message_counts, s.attachment_count) == ({1: 2, 2: 3}, 0)
    assert {c.topic: c.metadata for c in summary.channels.values()} == {
        "/one": {"of": "/one"}, "/two": {"of": "/two"},
    }  # fmt: skip
    spans = [(c.message_start_time, c.message_end_time) for c in summary.chunk_indexes]
    assert spans == [(30, 60), (90, 95)]
    for chunk in summary.chunk_indexes:
        at = chunk.chunk_start_offset
        opcode, length = struct.unpack_from("<BQ", data, at)
        assert (opcode, 9 + length) == (6, chunk.chunk_length)
        ends = [at + chunk.chunk_length]
        for channel, offset in chunk.message_index_offsets.items():
            opcode, length, of, size = struct.unpack_from("<BQHI", data, offset)
            assert (opcode, of, length) == (7, channel, 6 + size) and offset in ends
            ends.append(offset + 9 + length)
        assert ends[-1] == ends[0] + chunk.message_index_length
    (entry,) = summary.metadata_indexes
    assert (data[entry.offset], entry.name) == (0x0C, "rosbag2")
    assert 9 + struct.unpack_from("<Q", data, entry.offset + 1)[0] == entry.length
    assert data.startswith(MAGIC) and data.endswith(MAGIC)
    start, offsets, crc = struct.unpack("<QQI", data[-28:-8])
    assert crc == zlib.crc32(data[start:-12]) and data[start] == 3 and data[offsets] == 0x0E


@pytest.mark.parametrize("reader", [SeekingReader, NonSeekingReader])
def test_every_message_is_read_by_another_program(tmp_path, reader):
    written(tmp_path / "a.mcap")
    with (tmp_path / "a.mcap").open("rb") as stream:
        options = {"validate_crcs": True}
        found = [(c.id, m.log_time, m.data, m.publish_time)
                 for _, c, m in reader(stream, **options).iter_messages()]  # fmt: skip
    assert found == sorted([*MESSAGES, *MORE], key=lambda message: message[1])


@pytest.mark.parametrize(("end", "messages"), [("drop", MESSAGES), ("abandon", MESSAGES)])
def test_what_is_pending_can_be_left(tmp_path, end, messages):
    file = written(tmp_path / "a.mcap", end)
    found = scan(tmp_path / "a.mcap")
    assert (found.finished, found.index.messages) == (end == "drop", 3)
    stored = [tuple(m) for m in stored_messages(tmp_path / "a.mcap", found.index)]
    assert stored == messages and found.rest == []
    assert (file.index.start_ns, file.index.end_ns) == (30, 60)


def test_a_cut_file_gives_its_whole_messages(tmp_path):
    written(tmp_path / "whole.mcap")
    whole = scan(tmp_path / "whole.mcap")
    assert whole.finished and whole.index.messages == 5 and len(whole.index.chunks) == 2
    data = (tmp_path / "whole.mcap").read_bytes()
    second = whole.index.chunks[1]
    content = second.chunk_start_offset + 49
    for cut, rest, chunks in (
        (second.chunk_start_offset, 0, 1), (content, 0, 1), (content + 40, 0, 1),
        (content + 41, 1, 1), (content + 72, 1, 1), (content + 73, 2, 1),
        (content + 73 + 15, 2, 1), (content + 73 + 15 + 32, 0, 2),
    ):  # fmt: skip
        path = tmp_path / "cut.mcap"
        path.write_bytes(data[:cut])
        found = scan(path)
        assert (len(found.rest), len(found.index.chunks)) == (rest, chunks), cut
        assert [tuple(m) for m in found.rest] == MORE[:rest]
        end = second.chunk_start_offset if chunks == 1 else cut
        assert found.end == end and not found.finished


@pytest.mark.parametrize("data", [b"", MAGIC[:5], MAGIC])
def test_a_file_that_has_hardly_begun_is_empty(tmp_path, data):
    (tmp_path / "a.mcap").write_bytes(data)
    found = scan(tmp_path / "a.mcap")
    assert (found.index.messages, found.rest, found.finished) == (0, [], False)


def test_a_changed_byte_is_found(tmp_path):
    written(tmp_path / "a.mcap")
    chunk = scan(tmp_path / "a.mcap").index.chunks[0]
    data = bytearray((tmp_path / "a.mcap").read_bytes())
    data[chunk.chunk_start_offset + 49 + 31] ^= 1
    (tmp_path / "a.mcap").write_bytes(data)
    with pytest.raises(RecordingError, match=f"damaged at byte {chunk.chunk_start_offset};"):
        scan(tmp_path / "a.mcap")


def test_the_metadata_of_a_bag(tmp_path):
    file = written(tmp_path / "a.mcap")
    found = _information(file.index, bag_file_name("a"), {"status": "complete", "n": 3})
    topics = found.pop("topics_with_message_count")
    times = {"duration": {"nanoseconds": 65},
             "starting_time": {"nanoseconds_since_epoch": 30}, "message_count": 5}  # fmt: skip
    assert found == {
        "version": 9, "storage_identifier": "mcap", **times, "compression_format": "",
        "compression_mode": "", "relative_file_paths": ["a_0.mcap"],
        "files": [{"path": "a_0.mcap", **times}],
        "custom_data": {"status": "complete", "n": "3"}, "ros_distro": "jazzy",
    }  # fmt: skip
    assert [(t["topic_metadata"]["name"], t["message_count"]) for t in topics] == [
        ("/one", 2), ("/two", 3),
    ]  # fmt: skip
    assert topics[0]["topic_metadata"] == {
        "name": "/one", "type": "a/msg/B", "serialization_format": "cdr",
        "offered_qos_profiles": [], "type_description_hash": "",
    }  # fmt: skip
    assert _information(file.index, "a_0.mcap", {})["custom_data"] is None


@pytest.mark.parametrize(
    ("fixed", "said"),
    [
        ({"header.frame_idd": "x"}, r"nothing is fixed at 'header.frame_idd'.*header.frame_id"),
        ({"header.frame_id": 3}, "header.frame_id needs str, not 3"),
        ({"position": True}, "position needs int, not True"),
        ({"name": "x"}, "name needs list, not 'x'"),
    ],
)
def test_what_is_fixed_has_the_type_of_its_place(fixed, said):
    with pytest.raises(RecordingError, match=said):
        CdrLayout("sensor_msgs/msg/JointState", fixed)


def test_a_message_in_bytes():
    """Texts with their length and zero, numbers at multiples of their size."""
    layout = CdrLayout("sensor_msgs/msg/JointState", {"header.frame_id": "ab", "name": ["wheel"],
                                                      "position": 2})  # fmt: skip
    messages = layout.new(2)
    set_stamps(messages, np.array([3_000_000_007, 5]))
    messages["position"] = [[1.0, 2.0], [3.0, 4.0]]
    text = struct.pack("<I", 3) + b"ab\0" + b"\0" + struct.pack("<II", 1, 6) + b"wheel\0"
    body = struct.pack("<iI", 3, 7) + text + b"\0\0" + struct.pack("<I", 2)
    body += b"\0" * (-len(body) % 8) + struct.pack("<dd", 1.0, 2.0) + struct.pack("<II", 0, 0)
    assert messages[:1].tobytes() == b"\0\1\0\0" + body
    assert messages["header.stamp.sec"].tolist() == [3, 0]
    assert messages["header.stamp.nanosec"].tolist() == [7, 5]


def test_definitions_and_hashes_of_types(tmp_path, monkeypatch):
    text = types.message_definition("geometry_msgs/msg/WrenchStamped")
    parts = text.split("=" * 80 + "\n")
    assert [part.split("\n")[0] for part in parts[1:]] == [
        "MSG: std_msgs/Header", "MSG: geometry_msgs/Wrench", "MSG: builtin_interfaces/Time",
        "MSG: geometry_msgs/Vector3",
    ]  # fmt: skip
    assert types.type_hash("std_msgs/msg/String").startswith("RIHS01_")
    for ask in (types.type_hash, types.message_definition):
        with pytest.raises(RecordingError, match="a/msg/B: unknown message type"):
            ask("a/msg/B")
    installed = tmp_path / "share" / "mine" / "msg"
    installed.mkdir(parents=True)
    monkeypatch.setenv("AMENT_PREFIX_PATH", f":{tmp_path}")
    with pytest.raises(RecordingError, match=r"mine: no .msg files"):
        types.message_folder("mine")
    (installed / "A.msg").write_text("int32 x")
    assert types.message_folder("mine") == installed
