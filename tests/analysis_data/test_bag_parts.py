# SPDX-License-Identifier: Apache-2.0
"""Files of a bag, what its metadata say, its run record, waveforms and stop texts."""

from __future__ import annotations

from pathlib import Path

import bagmaker
import numpy as np
import pytest
from bagmaker import Bag, write_run

from flatplank_data.bags.topics import OWN, topic_map
from flatplank_data.errors import FlatplankError, YamlError
from flatplank_data.readers import bag, cache
from flatplank_data.readers.bag import arrays_of, describe_bag, import_bag, read_bag
from flatplank_data.readers.base import Request
from flatplank_data.store import LocalStore

RUN, TEXT = "flatplank_msgs/msg/Run", "std_msgs/msg/String"
STORE = bagmaker.store()


class Small(Bag):
    """A bag without a folder of its own: one file with a few messages."""

    def __init__(self, file: Path) -> None:
        self.types = STORE
        self.stream = file.open("wb")
        self.writer = bagmaker.Writer(self.stream)
        self.writer.start(profile="ros2")
        self.channels = {}

    def say(self, topic: str, text: str, stamp: int = 1) -> None:
        self.write(topic, TEXT, stamp, self.types.types[TEXT](text))

    def run(self, status: str, record: str, uuid: str = "", stamp: int = 1) -> None:
        message = self.types.types[RUN](self.header(stamp), uuid, "", status, record)
        self.write("/run", RUN, stamp, message)

    def values(self, topic: str, stamp: int, value: float) -> None:
        kind = "std_msgs/msg/Float64"
        self.write(topic, kind, stamp, self.types.types[kind](value))


def filled(file: Path, *messages: tuple) -> Path:
    """A file with run messages (status, record, uuid, stamp)."""
    made = Small(file)
    for one in messages:
        made.run(*one)
    made.close()
    return file


# the run record


@pytest.mark.parametrize("name", ["r.mcap", "bag/r.mcap", "bag"])
def test_the_record_beside_a_bag_counts(tmp_path, name):
    (tmp_path / "bag").mkdir()
    for folder, load in ((tmp_path, 1.0), (tmp_path / "bag", 2.0)):
        filled(folder / "r.mcap", ("complete", "fz: 9", "u"))
        (folder / "run.yaml").write_text(f"fz: {load}\nfile: x\n")
    expected = {"fz": 2.0 if "bag" in name else 1.0}
    assert describe_bag(LocalStore(str(tmp_path)), name) == expected


@pytest.mark.parametrize(
    ("messages", "facts"),
    [
        ([("complete", "fz: 9\nfile: x", "u")], {"fz": 9, "uuid": "u", "status": "complete"}),
        ([("", "fz: 9\nuuid: own", "")], {"fz": 9, "uuid": "own"}),
        ([("armed", "fz: 9\nstatus: x", "u"), ("complete", "fz: 8\nnotes: n", "v", 2)],
         {"fz": 8, "notes": "n", "uuid": "v", "status": "complete"}),
        # the last one is the shorter one
        ([("recording", "{fz: 9, notes: long}", "u"), ("complete", "fz: 8", "u", 2)],
         {"fz": 8, "notes": "long", "uuid": "u", "status": "complete"}),
        ([("complete", "fz: 8", "u", 2), ("armed", "fz: 9", "u", 1)],
         {"fz": 8, "uuid": "u", "status": "complete"}),
        ([("failed", "", "")], {"status": "failed"}), ([("", "- 1", "u")], {"uuid": "u"}),
        ([], {}),
    ],
)  # fmt: skip
def test_the_last_message_of_a_run_counts_where_no_file_does(tmp_path, messages, facts):
    filled(tmp_path / "r.mcap", *messages)
    assert describe_bag(LocalStore(str(tmp_path)), "r.mcap") == facts


def test_a_record_that_is_no_yaml_is_refused_with_its_topic(tmp_path):
    filled(tmp_path / "r.mcap", ("complete", "fz: [", "u"))
    with pytest.raises(YamlError, match="run record on /run"):
        describe_bag(LocalStore(str(tmp_path)), "r.mcap")


# files and metadata


def metadata(folder: Path, text: str) -> None:
    (folder / "metadata.yaml").write_text(f"rosbag2_bagfile_information: {text}\n")


def names_read(folder: Path) -> list[str]:
    return [file.path.name for file in bag._files(folder)]


def test_the_files_of_a_bag_in_order(tmp_path):
    for name in ("b.mcap", "a.db3", "c.mcap.zstd", "c.mcap", "d.mcap.zstd", "notes.txt", "e.bag"):
        filled(tmp_path / name)
    assert names_read(tmp_path) == ["a.db3", "b.mcap", "c.mcap", "d.mcap.zstd", "e.bag"]
    assert names_read(tmp_path / "b.mcap") == ["b.mcap"]


@pytest.mark.parametrize(
    "text", ["{}", "none", "[1]", "{compression_format: ''}", "{compression_format: zstd}"]
)
def test_a_bag_without_files_is_refused(tmp_path, text):
    metadata(tmp_path, text)
    with pytest.raises(FlatplankError) as raised:
        names_read(tmp_path)
    assert raised.value.what == "no .mcap, .db3 or .bag file"
    assert raised.value.where == tmp_path.name


@pytest.mark.parametrize("text", ["{compression_format: lz4, compression_mode: FILE}",
                                  "{compression_format: lz4}",
                                  "{compression_format: 7, compression_mode: 5}"])  # fmt: skip
def test_another_compression_is_refused_with_the_command_that_unpacks_it(tmp_path, text):
    filled(tmp_path / "a.mcap")
    metadata(tmp_path, text)
    with pytest.raises(FlatplankError) as raised:
        names_read(tmp_path)
    kind, mode = ("7", "5") if "7" in text else ("lz4", "file" if "mode" in text else "")
    said = f"compressed by {mode} with '{kind}', only zstd is read"
    assert raised.value.what == " ".join(said.split())
    assert raised.value.where == tmp_path.name and "ros2 bag convert" in raised.value.remedy


COUNTED = [
    ("{topic_metadata: {name: /a}, message_count: 3}", []),
    ("{topic_metadata: {name: /a}, message_count: 2}", []),
    ("{topic_metadata: {name: /a}, message_count: 4}",
     ["3 of the 4 messages on /a that metadata.yaml counts"]),
    ("{topic_metadata: {name: /unread}, message_count: 9}", []),
    ("{topic_metadata: {name: /a}}", []), ("{topic_metadata: {name: /a}, message_count: x}", []),
    ("{topic_metadata: 3, message_count: 9}", []), ("7", []),
]  # fmt: skip


@pytest.mark.parametrize(("entry", "remarks"), COUNTED)
def test_messages_that_the_metadata_count_are_missed(tmp_path, entry, remarks):
    made = Small(tmp_path / "a.mcap")
    for i in range(3):
        made.values("/a", 1 + i * 10**7, float(i))
    made.close()
    mapping = {"topics": {"/a": {"plank_position": "data"}}, "time": "log_time"}
    metadata(tmp_path, f"{{topics_with_message_count: [3, {entry}]}}")
    loaded = import_bag(tmp_path, topic_map(mapping))
    assert [text for text in loaded.remarks if "counts" in text] == remarks
    alone = import_bag(tmp_path / "a.mcap", topic_map(mapping))
    assert not [text for text in alone.remarks if "counts" in text]
    np.testing.assert_array_equal(alone.columns["plank_position"], [0.0, 1.0, 2.0])
    np.testing.assert_allclose(alone.columns["time"], [0.0, 0.01, 0.02], atol=1e-12)
    metadata(tmp_path, "{topics_with_message_count: null}")
    assert not import_bag(tmp_path, topic_map(mapping)).remarks


# sequences


def test_sequences_are_joined_over_messages_and_files_by_their_time(tmp_path):
    kind = "sensor_msgs/msg/JointState"
    types = STORE.types
    for file, stamps in (("a.mcap", (3, 1)), ("b.mcap", (2, 9))):
        made = Small(tmp_path / file)
        for stamp in stamps:
            places = np.arange(10.0 * stamp, 10.0 * stamp + (2 if stamp == 2 else 3))
            message = types[kind](made.header(stamp), [], places, places[:1] + 0.5, np.zeros(0))
            made.write("/a", kind, stamp, message)
        made.say("/b", "other")
        made.close()
    found = arrays_of(tmp_path, "/a", ("position", "velocity", "effort"))
    expected = [10, 11, 12, 20, 21, 30, 31, 32, 90, 91, 92]
    np.testing.assert_array_equal(found["position"], expected)
    np.testing.assert_array_equal(found["velocity"], [10.5, 20.5, 30.5, 90.5])
    assert found["effort"].size == 0
    assert arrays_of(tmp_path, "/nowhere", ("position",))["position"].size == 0


# what a run of the bench says of itself

COLUMNS = {
    name: np.linspace(0.0, 1.0, 6)
    for name in ("time", "plank_position", "plank_velocity", "wheel_angle", "wheel_velocity",
                 "motor_velocity", "motor_torque", "loaded_radius", "fx", "fy", "fz", "mx", "my",
                 "mz")
}  # fmt: skip


class Told:
    """A text for each message of the drive, its number in it."""

    def __init__(self) -> None:
        self.count = -1

    def __getitem__(self, code: int) -> str:
        self.count += 1
        return f"text {self.count}" + "!" * code


@pytest.fixture
def own(tmp_path, monkeypatch):
    """A run that stops for the reasons 3, 3, 2 in its rows 2, 3 and 5; and two waveforms."""
    monkeypatch.setattr(bagmaker, "REASONS", Told())
    told = []
    monkeypatch.setattr(bag, "measured_facts", lambda *given: told.append(given) or {"fz": 7.0})
    stops = np.array([0, 0, 3, 3, 0, 2])
    write_run(tmp_path / "own", {**COLUMNS, "stop_reason": stops}, "fz: 5", "own")
    made = Small(tmp_path / "own" / "own_1.mcap")
    for stamp, text in enumerate(("{name: step, slip: 0.1}", "- 1", "{name: sine}")):
        made.say("/slip_sequencer/waveform", text, stamp)
    made.close()
    return tmp_path, told


def test_stop_texts_and_waveforms_are_those_of_the_messages(own):
    folder, told = own
    loaded = import_bag(folder / "own", OWN)
    ((columns, texts, waveforms),) = told
    assert texts == {3: "text 2!!!", 2: "text 5!!"}
    assert waveforms == [{"name": "step", "slip": 0.1}, {"name": "sine"}]
    assert loaded.facts["measured"] == {"fz": 7.0} and loaded.facts["fz"] == 5
    np.testing.assert_allclose(columns["fx"], COLUMNS["fx"])


def test_a_foreign_bag_has_no_facts_of_the_bench(own):
    folder, told = own
    topics = {"/encoders/state": {"plank_position": "plank_position"}}
    loaded = import_bag(folder / "own", topic_map({"topics": topics}))
    assert not told and "measured" not in loaded.facts
    assert set(loaded.columns) == {"time", "plank_position"}


def test_a_bag_is_read_once_and_only_the_wanted_columns_are_given(own):
    folder, told = own
    request = Request(LocalStore(str(folder)), "own")
    wanted = Request(LocalStore(str(folder)), "own", columns=["fx", "time"])
    assert set(read_bag(wanted).columns) == {"fx", "time"} and len(told) == 1
    whole = read_bag(request)
    assert len(told) == 1 and {"fx", "fz", "plank_position"} <= set(whole.columns)
    assert (folder / cache.FOLDER).is_dir()
    assert set(read_bag(wanted).columns) == {"fx", "time"}
    assert whole.facts["fz"] == 5
