# SPDX-License-Identifier: Apache-2.0
"""A bag as rosbag2, rosbags and mcap expect it."""

from __future__ import annotations

import errno
import re
import time
from io import FileIO
from pathlib import Path

import pytest
import rec_samples as samples
import yaml
from mcap.reader import NonSeekingReader, make_reader
from rosbags.highlevel import AnyReader

from flatplank_control.recording.bag_writer import BagWriter
from flatplank_control.recording.mcap_file import McapFile
from flatplank_control.recording.topics import LATCHED, REFERENCE, Qos, TopicSpec, qos_text
from flatplank_control.recording.typestore import message_definition, type_hash
from flatplank_data.errors import RecordingError

NAME = "TOY_REL_LNG_5perc_T_p25_Fz5550_2"


def small_bag(folder: Path, count: int = 100, **options) -> BagWriter:
    bag = BagWriter(folder, NAME, samples.TOPICS, **options)
    for cycle in range(count):
        bag.write(samples.BUS, samples.bus_bytes(cycle), cycle * samples.PERIOD_NS)
        bag.write(samples.WRENCH, samples.wrench_bytes(cycle), cycle * samples.PERIOD_NS)
    return bag


def test_bag_is_read_by_rosbags(tmp_path):
    bag = small_bag(tmp_path)
    bag.close("complete", {"uuid": "u"})
    with AnyReader([bag.path]) as reader:
        assert reader.message_count == 200
        assert reader.duration == 99 * samples.PERIOD_NS + 1
        assert {c.topic: c.msgtype for c in reader.connections} == {
            t.name: t.type for t in samples.TOPICS
        }
        wrench = [c for c in reader.connections if c.topic == samples.WRENCH]
        forces = [
            reader.deserialize(data, c.msgtype).wrench.force.x
            for c, _, data in reader.messages(wrench)
        ]
    assert forces == list(range(100))


def test_bag_is_read_by_mcap(tmp_path):
    bag = small_bag(tmp_path, chunk_size=2000)
    bag.close("complete")
    with (bag.path / bag.file_name).open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        assert summary.statistics.message_count == 200
        assert summary.statistics.chunk_count > 5
        assert {c.message_encoding for c in summary.channels.values()} == {"cdr"}
        assert {s.encoding for s in summary.schemas.values()} == {"ros2msg"}
        stamps = [message.log_time for _, _, message in reader.iter_messages()]
        assert stamps == sorted(stamps)
        assert len(stamps) == 200
        stored = next(record for record in reader.iter_metadata() if record.name == "rosbag2")
    information = yaml.safe_load(stored.metadata["serialized_metadata"])
    beside = yaml.safe_load((bag.path / "metadata.yaml").read_text())
    assert beside == {"rosbag2_bagfile_information": information}
    with (bag.path / bag.file_name).open("rb") as file:
        assert sum(1 for _ in NonSeekingReader(file, validate_crcs=True).iter_messages()) == 200


def test_reception_is_the_log_time_and_the_stamp_the_publish_time(tmp_path):
    bag = BagWriter(tmp_path, NAME, samples.TOPICS, chunk_size=2000)
    stamps = [cycle * samples.PERIOD_NS for cycle in range(100)]
    received = [stamp + 1000 * (1 + stamp % 7) for stamp in stamps]
    for cycle, (stamp, at) in enumerate(zip(stamps, received, strict=True)):
        bag.write(samples.WRENCH, samples.wrench_bytes(cycle), stamp, at)
    bag.close("complete")
    with (bag.path / bag.file_name).open("rb") as file:
        found = [(m.log_time, m.publish_time) for _, _, m in make_reader(file).iter_messages()]
    assert found == list(zip(received, stamps, strict=True))
    assert [stamp for _, stamp, _ in samples.read(bag.path)] == received


def test_metadata_has_the_layout_of_jazzy(tmp_path):
    bag = small_bag(tmp_path)
    bag.close("stopped", {"uuid": "u"})
    data = yaml.safe_load((bag.path / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert list(data) == [
        "version",
        "storage_identifier",
        "duration",
        "starting_time",
        "message_count",
        "topics_with_message_count",
        "compression_format",
        "compression_mode",
        "relative_file_paths",
        "files",
        "custom_data",
        "ros_distro",
    ]
    assert (data["version"], data["storage_identifier"]) == (9, "mcap")
    assert data["relative_file_paths"] == [f"{NAME}_0.mcap"]
    assert data["custom_data"] == {"status": "stopped", "uuid": "u"}
    topic = data["topics_with_message_count"][0]
    assert topic["message_count"] == 100
    assert topic["topic_metadata"]["offered_qos_profiles"][0]["reliability"] == "reliable"
    assert topic["topic_metadata"]["type_description_hash"].startswith("RIHS01_")
    assert sorted(path.name for path in bag.path.iterdir()) == [f"{NAME}_0.mcap", "metadata.yaml"]


def reindexed(folder: Path) -> dict:
    """What `ros2 bag reindex` of Jazzy gathers: from each file that its pattern names, by the
    statistics, channels and schemas of the file (Reindexer, MCAPStorage::read_metadata)."""
    (path,) = (p for p in folder.iterdir() if re.fullmatch(r".+_(\d+)\.([a-zA-Z0-9])+", p.name))
    with path.open("rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        stored = next(record for record in reader.iter_metadata() if record.name == "rosbag2")
    own = yaml.safe_load(stored.metadata["serialized_metadata"])
    statistics = summary.statistics
    start, end = statistics.message_start_time, statistics.message_end_time
    topics = [
        {
            "topic_metadata": {
                "name": channel.topic,
                "type": summary.schemas[channel.schema_id].name,
                "serialization_format": channel.message_encoding,
                "offered_qos_profiles": yaml.safe_load(channel.metadata["offered_qos_profiles"]),
                "type_description_hash": channel.metadata["topic_type_hash"],
            },
            "message_count": statistics.channel_message_counts.get(channel.id, 0),
        }
        for channel in summary.channels.values()
    ]
    return {
        "storage_identifier": "mcap",
        "starting_time": {"nanoseconds_since_epoch": start},
        "duration": {"nanoseconds": end - start},
        "message_count": statistics.message_count,
        "topics_with_message_count": topics,
        "relative_file_paths": [path.name],
        "custom_data": own["custom_data"],
        "ros_distro": own["ros_distro"],
    }


def test_a_bag_whose_metadata_is_lost_is_reindexed_to_the_same(tmp_path):
    bag = small_bag(tmp_path)
    bag.close("complete", {"uuid": "u"})
    (bag.path / "run.yaml").write_text("uuid: u\n")
    data = yaml.safe_load((bag.path / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    (bag.path / "metadata.yaml").unlink()
    found = reindexed(bag.path)
    assert {key: data[key] for key in found} == found


def test_channels_carry_hash_and_qos(tmp_path):
    topics = [TopicSpec("/run", "flatplank_msgs/msg/Run", LATCHED)]
    bag = BagWriter(tmp_path, NAME, topics)
    bag.close("complete")
    with (bag.path / bag.file_name).open("rb") as file:
        channel = make_reader(file).get_summary().channels[1]
    assert channel.metadata["topic_type_hash"] == type_hash("flatplank_msgs/msg/Run")
    profile = yaml.safe_load(channel.metadata["offered_qos_profiles"])[0]
    assert (profile["durability"], profile["depth"]) == ("transient_local", 1)
    with AnyReader([bag.path]) as reader:
        assert reader.message_count == 0


def test_qos_durations_are_split_as_rmw_does():
    (deadline,) = (p["deadline"] for p in yaml.safe_load(qos_text(REFERENCE)))
    assert deadline == {"sec": 0, "nsec": 100_000_000}
    (endless,) = (p["deadline"] for p in yaml.safe_load(qos_text(Qos())))
    assert endless == {"sec": 9223372036, "nsec": 854775807}


def test_hashes_are_those_of_the_released_packages():
    """Numbers from the JSON type descriptions that ROS 2 Jazzy installs."""
    released = {
        "geometry_msgs/msg/WrenchStamped": "8dc3deaf06b2ab281f9f9a742a8961c3"
        "28ca7cec16e3fd6586d3a5c83fa78f77",
        "sensor_msgs/msg/JointState": "a13ee3a330e346c9d87b5aa18d24e116"
        "90752bd33a0350f11c5882bc9179260e",
        "std_msgs/msg/Header": "f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01",
    }
    for msgtype, digest in released.items():
        assert type_hash(msgtype) == f"RIHS01_{digest}"


def test_definition_keeps_our_units_and_brings_what_it_needs():
    text = message_definition("flatplank_msgs/msg/HubState")
    assert "[m]" in text
    bar = "=" * 80
    assert f"{bar}\nMSG: std_msgs/Header\n" in text
    assert f"{bar}\nMSG: builtin_interfaces/Time\n" in text


def test_unknown_type_and_topic_are_refused(tmp_path):
    with pytest.raises(RecordingError, match="unknown message type"):
        BagWriter(tmp_path, NAME, [TopicSpec("/x", "no_msgs/msg/Such")])
    bag = BagWriter(tmp_path, NAME, samples.TOPICS)
    with pytest.raises(RecordingError, match="/other: not a topic"):
        bag.write("/other", b"", 0)
    bag.close("complete")
    with pytest.raises(RecordingError, match="closed"):
        bag.write(samples.BUS, b"", 0)


def test_an_existing_bag_is_not_overwritten(tmp_path):
    small_bag(tmp_path).close("complete")
    with pytest.raises(RecordingError, match="cannot be written"):
        BagWriter(tmp_path, NAME, samples.TOPICS)


def test_a_bag_is_made_in_its_folder_and_nowhere_else(tmp_path):
    inside = tmp_path / "inside"
    inside.mkdir()
    with pytest.raises(RecordingError, match="not a name"):
        BagWriter(inside, "../outside", samples.TOPICS)
    assert [path.name for path in tmp_path.rglob("*")] == ["inside"]


def test_discard_leaves_nothing(tmp_path):
    small_bag(tmp_path).discard()
    assert list(tmp_path.iterdir()) == []


def test_everything_is_on_the_disk_half_a_second_later(tmp_path):
    now = [0.0]
    bag = BagWriter(tmp_path, NAME, samples.TOPICS, clock=lambda: now[0])
    bag.write(samples.WRENCH, samples.wrench_bytes(1.0), 0)
    now[0] = 0.4
    bag.poll()
    assert bag.message_count == 0
    now[0] = 0.5
    bag.poll()
    assert bag.message_count == 1
    bag.write(samples.WRENCH, samples.wrench_bytes(1.0), 0)
    now[0] = 1.0
    bag.write(samples.WRENCH, samples.wrench_bytes(1.0), 0)
    assert bag.message_count == 3
    bag.close("complete")


class FullDisk(FileIO):
    """Takes `room` bytes in all, and 100 kB more when the reserve is gone."""

    room = 40_000

    def write(self, data) -> int:
        size = memoryview(data).nbytes
        reserve = Path(self.name).parent / ".reserve"
        left = self.room + (0 if reserve.exists() else 100_000) - self.tell()
        if left <= 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        return super().write(memoryview(data)[: min(size, left)])


def test_full_disk_stops_with_an_error_and_keeps_what_is_written(tmp_path):
    bag = BagWriter(
        tmp_path,
        NAME,
        samples.TOPICS,
        chunk_size=4000,
        open_file=lambda path: McapFile(FullDisk(path, "xb")),
    )
    written = 0
    with pytest.raises(RecordingError, match=r"the disk does not take more.*No space left"):
        while True:
            bag.write(samples.WRENCH, samples.wrench_bytes(written), written)
            written += 1
    with pytest.raises(RecordingError, match="the disk does not take more"):
        bag.write(samples.WRENCH, samples.wrench_bytes(0), 0)
    bag.close("failed")
    messages = samples.read(bag.path)
    chunk = 4000 // len(samples.wrench_bytes(0))
    assert written - 2 * chunk < len(messages) <= written
    assert [stamp for _, stamp, _ in messages] == list(range(len(messages)))


@pytest.mark.long
def test_writes_at_least_100_000_messages_a_second(tmp_path):
    """Ten times less than measured, so that a busy machine does not fail it."""
    bag = BagWriter(tmp_path, NAME, samples.TOPICS)
    data = samples.bus_bytes(1)
    begin = time.perf_counter()
    for stamp in range(50_000):
        bag.write(samples.BUS, data, stamp)
    bag.close("complete")
    assert 50_000 / (time.perf_counter() - begin) > 100_000
