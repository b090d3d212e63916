# SPDX-License-Identifier: Apache-2.0
"""Bags as other recorders leave them: SQLite with logs, ROS 1, IDL, no definitions, no index."""

from __future__ import annotations

import shutil
import sqlite3
from contextlib import closing

import numpy as np
import pytest
import yaml
from mcap.writer import CompressionType, IndexType
from rosbags.rosbag1 import Writer as Writer1
from rosbags.typesys import Stores, get_types_from_idl, get_typestore

from flatplank_control.recording.mcap_file import McapFile
from flatplank_data.bags.ros1 import Ros1File
from flatplank_data.bags.topics import topic_map
from flatplank_data.errors import FlatplankError
from flatplank_data.guard import Budget
from flatplank_data.readers.bag import import_bag
from flatplank_validation.trust.files.bags import (
    JOINT,
    PERIOD,
    ROS1,
    ROWS,
    START,
    STORE,
    TOPICS,
    WRENCH,
    create,
    definition,
    insert,
    messages,
    messages_of_ros1,
    plain,
    write_mcap,
    write_ros1,
)


def read(path, topics=None):
    return import_bag(path, topic_map({"topics": topics or TOPICS}))


def assert_rows(loaded, numbers):
    """Exactly these rows."""
    np.testing.assert_array_equal(loaded.columns["fx"], numbers)
    np.testing.assert_allclose(loaded.columns["wheel_angle"], 2e-3 * np.asarray(numbers))
    np.testing.assert_allclose(np.diff(loaded.columns["time"]), 0.1 * np.diff(numbers))


# SQLite


def killed(tmp_path, base: sqlite3.Connection, leave=()):
    """The files as a recorder that is killed now leaves them."""
    folder = tmp_path / "killed"
    folder.mkdir()
    for file in (tmp_path / "live").iterdir():
        if not file.name.endswith(tuple(leave)):
            shutil.copy(file, folder)
    base.close()
    return folder


def counted(folder, tmp_path) -> int:
    """Rows that sqlite3 finds in a copy."""
    copy = shutil.copytree(folder, tmp_path / "copy")
    with closing(sqlite3.connect(next(copy.glob("*.db3")))) as base:
        return base.execute("SELECT count(*) FROM messages").fetchone()[0] // 2


def unchanged(folder):
    return {p.name: (p.stat().st_mtime_ns, p.read_bytes()) for p in folder.iterdir()}


@pytest.mark.parametrize("leave", [(), ("-shm",)], ids=["shm", "no shm"])
@pytest.mark.parametrize("kept", [0, 200, 399])
def test_a_write_ahead_log_is_read_and_nothing_is_written(tmp_path, leave, kept):
    """`kept` rows are in the database itself, the others in the log."""
    (tmp_path / "live").mkdir()
    base = create(tmp_path / "live" / "r.db3", "WAL")
    base.execute("PRAGMA wal_autocheckpoint=0")
    for first in range(0, ROWS, 50):
        insert(base, first, first + 50)
        base.execute("COMMIT")
        if first < kept <= first + 50:
            base.execute("PRAGMA wal_checkpoint(PASSIVE)")
    folder = killed(tmp_path, base, leave)
    folder.chmod(0o555)
    before = unchanged(folder)
    loaded = read(folder)
    assert unchanged(folder) == before
    assert counted(folder, tmp_path) == ROWS and not loaded.remarks
    assert_rows(loaded, np.arange(ROWS))


def test_a_damaged_or_unfinished_log_is_told(tmp_path):
    (tmp_path / "live").mkdir()
    base = create(tmp_path / "live" / "r.db3", "WAL")
    base.execute("PRAGMA wal_autocheckpoint=0")
    for first in range(0, ROWS, 50):
        insert(base, first, first + 50)
        base.execute("COMMIT")
    folder = killed(tmp_path, base)
    log = folder / "r.db3-wal"
    data = bytearray(log.read_bytes())
    data[len(data) // 2] ^= 1
    log.write_bytes(data)
    loaded = read(folder)
    rows = counted(folder, tmp_path)
    assert 100 < rows < ROWS
    assert_rows(loaded, np.arange(rows))
    (remark,) = loaded.remarks
    assert "pages of the log r.db3-wal are whole" in remark


def test_a_rollback_journal_is_applied(tmp_path):
    """A transaction that had begun to change the database is not half there."""
    (tmp_path / "live").mkdir()
    base = create(tmp_path / "live" / "r.db3", "DELETE")
    insert(base, 0, 300)
    base.execute("COMMIT")
    base.execute("PRAGMA cache_size=2")
    insert(base, 300, ROWS)
    folder = killed(tmp_path, base)
    assert (folder / "r.db3-journal").stat().st_size > 0
    before = unchanged(folder)
    loaded = read(folder)
    assert unchanged(folder) == before
    rows = counted(folder, tmp_path)
    assert rows == 300
    assert_rows(loaded, np.arange(rows))


def test_messages_that_the_metadata_count_and_the_bag_has_not_are_told(tmp_path):
    base = create(tmp_path / "r.db3", "DELETE")
    insert(base, 0, 337)
    base.execute("COMMIT")
    base.close()
    entry = {"topic_metadata": {"name": "/hub"}, "message_count": ROWS}
    text = yaml.safe_dump({"rosbag2_bagfile_information": {"topics_with_message_count": [entry]}})
    (tmp_path / "metadata.yaml").write_text(text)
    loaded = read(tmp_path)
    assert loaded.remarks == ["337 of the 400 messages on /hub that metadata.yaml counts"]


@pytest.mark.parametrize(
    "sql",
    ["CREATE VIEW messages AS SELECT 1 AS topic_id, 2 AS timestamp, x'00' AS data",
     "CREATE TABLE messages(topic_id INTEGER, timestamp INTEGER)", ""],
)  # fmt: skip
def test_another_database_is_refused(tmp_path, sql):
    with closing(sqlite3.connect(tmp_path / "r.db3")) as base:
        base.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT)")
        base.execute(sql)
        base.commit()
    with pytest.raises(FlatplankError, match="no table 'messages' with data, timestamp, topic_id"):
        read(tmp_path)


# other definitions and serialisations


@pytest.mark.parametrize(
    "options",
    [
        {"use_chunking": False},
        {"index_types": IndexType.NONE},
        {"use_statistics": False, "use_summary_offsets": False, "repeat_channels": False},
        {"compression": CompressionType.LZ4, "chunk_size": 2000},
        {"compression": CompressionType.ZSTD, "enable_crcs": False},
        {"enable_data_crcs": True, "chunk_size": 3000, "compression": CompressionType.NONE},
    ],
    ids=lambda o: ", ".join(o),
)
def test_mcap_as_others_write_it(tmp_path, options):
    path = write_mcap(tmp_path / "r.mcap", plain(), "ros2msg", definition, **options)
    loaded = read(path)
    assert not loaded.remarks
    assert_rows(loaded, np.arange(ROWS))


IDL = """module rig { module msg {
  struct Place { double plank; double wheel; };
  typedef float float__3[3];
  struct Sample {
    builtin_interfaces::msg::Time stamp; string note; rig::msg::Place place; float__3 force;
  };
}; };
"""


def test_definitions_in_idl(tmp_path):
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_idl(IDL))
    t, kind = store.types, "rig/msg/Sample"

    def rows():
        for i in range(ROWS):
            at = START + i * PERIOD
            stamp = t["builtin_interfaces/msg/Time"](at // 10**9, at % 10**9)
            place = t["rig/msg/Place"](1e-3 * i, 2e-3 * i)
            force = np.array([i, 0.0, 3700.0], dtype=np.float32)
            message = t[kind](stamp, "x" * (i % 5), place, force)
            yield "/rig", kind, at, bytes(store.serialize_cdr(message, kind))

    path = write_mcap(tmp_path / "r.mcap", rows(), "ros2idl", lambda kind: IDL)
    columns = {"plank_position": "place.plank", "wheel_angle": "place.wheel", "fx": "force[0]"}
    mapping = {"topics": {"/rig": columns}, "time": "stamp"}
    assert_rows(import_bag(path, topic_map(mapping)), np.arange(ROWS))


def test_standard_types_need_no_definition(tmp_path):
    """`rosbags` has those of all packages of a distribution."""
    t, kind = STORE.types, "geometry_msgs/msg/AccelStamped"
    vector = t["geometry_msgs/msg/Vector3"]
    base = create(tmp_path / "r.db3", "DELETE")
    base.execute("UPDATE topics SET type=? WHERE id=2", (kind,))
    base.execute("BEGIN")
    for topic, _, at, message in messages():
        one, what = message, JOINT
        if topic == "/hub":
            accel = t["geometry_msgs/msg/Accel"](message.wrench.force, vector(0.0, 0.0, 0.0))
            one, what = t[kind](message.header, accel), kind
        row = (1 + (topic == "/hub"), at, bytes(STORE.serialize_cdr(one, what)))
        base.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES(?,?,?)", row)
    base.execute("COMMIT")
    base.close()
    topics = {"/enc": TOPICS["/enc"], "/hub": {"fx": "accel.linear.x"}}
    assert_rows(read(tmp_path, topics), np.arange(ROWS))


def test_a_type_that_nobody_defines_is_named(tmp_path):
    path = write_mcap(tmp_path / "r.mcap", plain(), "", lambda kind: "")
    assert_rows(read(path), np.arange(ROWS))
    rows = ((topic, f"own/msg/{topic[1:]}", at, data) for topic, _, at, data in plain())
    write_mcap(path, rows, "", lambda kind: "")
    with pytest.raises(FlatplankError, match="own/msg/enc of /enc cannot be read .*unknown"):
        read(path)


PACKINGS = [None, Writer1.CompressionFormat.LZ4, Writer1.CompressionFormat.BZ2]


@pytest.mark.parametrize("packing", PACKINGS)
def test_bags_of_ros_1(tmp_path, packing):
    path = write_ros1(tmp_path / "r.bag", packing, chunk=3000)
    assert_rows(read(path), np.arange(ROWS))
    found = messages_of_ros1(path.read_bytes())  # an independent reader
    places = [ROS1.deserialize_ros1(data, JOINT).position[1] for data in found["/enc"]]
    np.testing.assert_array_equal(read(path).columns["wheel_angle"], places)


@pytest.mark.parametrize("packing", PACKINGS[1:])
def test_a_chunk_of_ros_1_that_fills_the_memory_is_refused(tmp_path, packing):
    """The chunk unpacks to 320 MB; only as much as the file may have is unpacked."""
    rows = (("/enc", JOINT, START + i, bytes(1 << 26)) for i in range(5))
    path = write_ros1(tmp_path / "r.bag", packing, rows)
    # bz2 and lz4 pack zeros by more than 200: as bombs they are told by their size alone
    file = Ros1File(path, Budget(path.name, 1 << 25))
    with pytest.raises(FlatplankError, match="unpacks to more than 1000 times its size"):
        list(file.blocks({"/enc"}))


def test_an_index_of_ros_1_that_lacks_messages_is_refused(tmp_path):
    path = write_ros1(tmp_path / "r.bag")
    data = bytearray(path.read_bytes())
    head = data.rindex(b"count=" + (ROWS).to_bytes(4, "little"))  # of an index of the chunk
    at = data.rindex((12 * ROWS).to_bytes(4, "little"))
    assert at > head
    data[head + 6 : head + 10] = (ROWS - 5).to_bytes(4, "little")
    data[at : at + 4] = (12 * (ROWS - 5)).to_bytes(4, "little")
    path.write_bytes(data)
    with pytest.raises(FlatplankError, match="not a whole bag of ROS 1"):
        read(path)


def test_messages_of_ros_1_in_mcap_and_messages_in_json(tmp_path):
    rows = [
        (topic, kind.replace("/msg/", "/"), at, bytes(ROS1.serialize_ros1(message, kind)))
        for topic, kind, at, message in messages(ROS1, seq=7)
    ]

    def text(kind):
        return ROS1.generate_msgdef(kind.replace("/", "/msg/"), ros_version=1)[0]

    path = write_mcap(tmp_path / "r.mcap", rows, "ros1msg", text, "ros1")
    assert_rows(read(path), np.arange(ROWS))
    write_mcap(path, rows, "jsonschema", text, "json")
    with pytest.raises(FlatplankError, match="messages of /enc are 'json', not CDR"):
        read(path)


# bombs


def test_a_chunk_that_fills_the_memory_is_refused(tmp_path):
    options = {"compression": CompressionType.ZSTD, "chunk_size": 1 << 29}
    rows = (("/enc", JOINT, START + i, bytes(1 << 26)) for i in range(5))
    path = write_mcap(tmp_path / "r.mcap", rows, "ros2msg", definition, **options)
    with pytest.raises(FlatplankError, match="unpacks to more than 1000 times its size"):
        read(path)


def test_one_bit_of_a_bag_of_the_bench_is_found_and_its_rows_are_named(tmp_path):
    """The recorder writes a checksum per chunk; here 50 rows, 5 s."""
    path = tmp_path / "b_0.mcap"
    file = McapFile.create(path)
    numbers = {}
    for topic, kind in (("/enc", JOINT), ("/hub", WRENCH)):
        schema = file.add_schema(kind, STORE.generate_msgdef(kind, ros_version=2)[0])
        numbers[topic] = file.add_channel(topic, schema, {})
    for i, (topic, kind, at, message) in enumerate(messages()):
        file.add(numbers[topic], at, bytes(STORE.serialize_cdr(message, kind)), at)
        if i % 100 == 99:
            file.flush()
    file.finish()
    topics = topic_map({"topics": TOPICS})
    assert not import_bag(path, topics).remarks
    data = bytearray(path.read_bytes())
    force = np.float64(175.0).tobytes() + np.float64(0.0).tobytes() + np.float64(3700.0).tobytes()
    data[data.index(force) + 7] ^= 1  # 175 N becomes 1.3e-153 N
    path.write_bytes(data)
    loaded = import_bag(path, topics)
    kept = np.r_[0:150, 200:400]
    np.testing.assert_array_equal(loaded.columns["fx"], kept)
    assert loaded.remarks == [
        "damaged (checksum): the messages from 14.900 s to 20.000 s are left out; "
        "copy the bag again from where it was recorded"
    ]
