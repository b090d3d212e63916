# SPDX-License-Identifier: Apache-2.0
"""Files of a bag, what its metadata say, its run record, waveforms and stop texts."""

from __future__ import annotations

from pathlib import Path

import bagmaker
import numpy as np
import pytest
from bagmaker import Bag

from flatplank_data.errors import YamlError
from flatplank_data.readers.bag import arrays_of, describe_bag
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
