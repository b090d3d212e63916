# SPDX-License-Identifier: Apache-2.0
"""Damaged bags: what is read is what was written; what is missing is told; the rest is refused."""

from __future__ import annotations

import sqlite3
from contextlib import closing

import numpy as np
import pytest
import yaml
import zstandard
from bagmaker import write_run
from damage import damaged
from mcap.writer import CompressionType
from steptable import step_table
from test_bag_kinds import JOINT, STORE, TOPICS, WRENCH, create, insert, messages

from flatplank_control.recording.mcap_file import McapFile
from flatplank_data.bags.topics import OWN, topic_map
from flatplank_data.errors import FlatplankError
from flatplank_data.readers.bag import import_bag

COUNT = {True: 20_000, False: 120}
"""number of damaged files per test, with --long and without"""
RECORD = "kappa: 0.05\n"


def as_a_stream(path):
    """The file packed block by block, as rosbag2 does."""
    packer, data = zstandard.ZstdCompressor(write_checksum=True).compressobj(), path.read_bytes()
    parts = []
    for at in range(0, len(data), 4096):
        parts += [packer.compress(data[at : at + 4096])]
        parts += [packer.flush(zstandard.COMPRESSOBJ_FLUSH_BLOCK)]
    packed = path.with_name(f"{path.name}.zstd")
    packed.write_bytes(b"".join(parts) + packer.flush())
    path.unlink()
    return packed


def outcomes(path, topics, count, seed):
    """What is read of damaged copies of the file, but for those refused in one line."""
    whole = path.read_bytes()
    for what, data in damaged(whole, count, seed):
        path.write_bytes(data)
        try:
            yield what, import_bag(path if path.suffix == ".mcap" else path.parent, topics)
        except FlatplankError as error:
            assert "\n" not in str(error), what
    path.write_bytes(whole)


@pytest.mark.parametrize("packing", ["NONE", "ZSTD", "LZ4", "file"])
def test_no_value_of_a_damaged_mcap_bag_is_wrong(tmp_path, packing, pytestconfig):
    """Chunks have checksums: each row is one that was written, and no row is missing unsaid."""
    run = step_table(0.05).rows(slice(0, 150))
    kind = CompressionType["NONE" if packing == "file" else packing]
    options = {"compression": kind, "chunk_size": 8000}
    write_run(tmp_path / "b", dict(run.columns), RECORD, "b", **options)
    path = tmp_path / "b" / "b_0.mcap"
    written = import_bag(path, OWN).columns
    row_of = {place: i for i, place in enumerate(written["plank_position"])}
    if packing == "file":
        path = as_a_stream(path)
    read = 0
    for what, loaded in outcomes(path, OWN, COUNT[bool(pytestconfig.getoption("--long"))], 7):
        rows = [row_of[place] for place in loaded.columns["plank_position"]]
        for name, values in loaded.columns.items():
            if name != "time":
                np.testing.assert_array_equal(values, written[name][rows], what)
        assert loaded.remarks or len(rows) == len(row_of), what
        assert loaded.remarks or set(loaded.columns) == set(written), what
        read += 1
    assert read > 5


def test_a_damaged_sqlite_bag_is_what_sqlite3_and_rosbags_read(tmp_path, pytestconfig):
    path = tmp_path / "r.db3"
    base = create(path, "DELETE")
    base.execute("PRAGMA page_size=512")
    insert(base, 0, 100)
    base.execute("COMMIT")
    base.close()
    counts = [{"topic_metadata": {"name": t}, "message_count": 100} for t in TOPICS]
    text = yaml.safe_dump({"rosbag2_bagfile_information": {"topics_with_message_count": counts}})
    (tmp_path / "metadata.yaml").write_text(text)
    count = COUNT[bool(pytestconfig.getoption("--long"))]
    read = 0
    for what, loaded in outcomes(path, topic_map({"topics": TOPICS}), count, 8):
        with closing(sqlite3.connect(f"{path.as_uri()}?immutable=1", uri=True)) as base:
            rows = base.execute("SELECT data FROM messages WHERE topic_id=1").fetchall()
        places = {STORE.deserialize_cdr(data, JOINT).position[0] for (data,) in rows}
        found = set(loaded.columns["plank_position"])
        assert found <= places, what
        assert loaded.remarks or len(found) == 100, what
        read += 1
    assert read > 20


def test_one_bit_of_a_bag_of_the_bench_is_found_and_its_rows_are_named(tmp_path):
    """The recorder writes a checksum per chunk; here 50 rows, 5 s."""
    path = tmp_path / "b_0.mcap"
    file = McapFile.create(path)
    numbers = {}
    for topic, kind in (("/enc", JOINT), ("/hub", WRENCH)):
        schema = file.add_schema(kind, STORE.generate_msgdef(kind, ros_version=2)[0])
        numbers[topic] = file.add_channel(topic, schema, {})
    for i, (topic, kind, at, message) in enumerate(messages()):
        file.add(numbers[topic], at, bytes(STORE.serialize_cdr(message, kind)))
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
