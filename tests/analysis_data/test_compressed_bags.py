# SPDX-License-Identifier: Apache-2.0
"""Bags that rosbag2 compressed by file or by message, in both storages, and other formats."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import numpy as np
import pytest
import yaml
import zstandard
from bagmaker import write_run
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from steptable import step_table

from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError

NAME = "TOY_REL_LNG_5perc_T_p25_Fz3700_1"
RECORD = "kappa: 0.05\nfz: 3700.0\nstep_position: 1.5\neffective_rolling_radius: 0.31\n"
COLUMNS = ["fx", "fz", "mz", "plank_position", "wheel_angle", "wheel_velocity", "loaded_radius"]
PIECE = 1 << 16


@pytest.fixture(scope="module")
def source():
    return step_table(0.05)


@pytest.fixture(scope="module")
def messages(tmp_path_factory, source):
    """Schema, channel and message of a bench bag."""
    folder = tmp_path_factory.mktemp("plain") / NAME
    write_run(folder, dict(source.columns), RECORD, NAME)
    with open(next(folder.glob("*.mcap")), "rb") as stream:
        return list(make_reader(stream).iter_messages())


def mcap_storage(path: Path, messages, packed) -> Path:
    path = path.with_suffix(".mcap")
    channels: dict[str, int] = {}
    with open(path, "wb") as stream:
        writer = Writer(stream, chunk_size=100_000, compression=CompressionType.NONE)
        writer.start(profile="ros2")
        for schema, channel, message in messages:
            if channel.topic not in channels:
                number = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.topic] = writer.register_channel(channel.topic, "cdr", number)
            data = packed(message.data)
            writer.add_message(channels[channel.topic], message.log_time, data, message.log_time)
        writer.finish()
    return path


def sqlite_storage(path: Path, messages, packed) -> Path:
    """Tables as in schema version 4 of rosbag2_storage_sqlite3."""
    path = path.with_suffix(".db3")
    base = sqlite3.connect(path)
    base.execute(
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, "
        "serialization_format TEXT, offered_qos_profiles TEXT, type_description_hash TEXT)"
    )
    base.execute(
        "CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT, "
        "encoding TEXT, encoded_message_definition TEXT, type_description_hash TEXT)"
    )
    base.execute(
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, "
        "data BLOB)"
    )
    numbers: dict[str, int] = {}
    for schema, channel, message in messages:
        if channel.topic not in numbers:
            numbers[channel.topic] = len(numbers) + 1
            row = (numbers[channel.topic], channel.topic, schema.name, "cdr", "", "")
            base.execute("INSERT INTO topics VALUES(?,?,?,?,?,?)", row)
            row = (schema.name, "ros2msg", schema.data.decode(), "")
            base.execute("INSERT INTO message_definitions VALUES(NULL,?,?,?,?)", row)
        row = (numbers[channel.topic], message.log_time, packed(message.data))
        base.execute("INSERT INTO messages VALUES(NULL,?,?,?)", row)
    base.commit()
    base.close()
    return path


def write_bag(folder: Path, messages, storage, mode: str, kind: str = "zstd") -> Path:
    """A bag folder as rosbag2 leaves it; files are compressed as a stream, messages at once."""
    folder.mkdir(parents=True)
    pack = zstandard.ZstdCompressor().compress if mode == "MESSAGE" else bytes
    file = storage(folder / f"{folder.name}_0", messages, pack)
    if mode == "FILE":
        stream = zstandard.ZstdCompressor().compressobj()
        data = file.read_bytes()
        pieces = [stream.compress(data[at : at + PIECE]) for at in range(0, len(data), PIECE)]
        file.with_name(f"{file.name}.zstd").write_bytes(b"".join(pieces) + stream.flush())
        file.unlink()
    information = {"version": 9, "compression_format": kind, "compression_mode": mode}
    text = yaml.safe_dump({"rosbag2_bagfile_information": information})
    (folder / "metadata.yaml").write_text(text)
    return folder


@pytest.mark.parametrize("mode", ["FILE", "MESSAGE"])
@pytest.mark.parametrize("storage", [mcap_storage, sqlite_storage])
def test_compressed_bags_read_as_plain_ones(tmp_path, messages, source, storage, mode):
    write_bag(tmp_path / NAME, messages, storage, mode)
    campaign = Campaign.load(tmp_path)
    (table,) = campaign.tables()
    for name in COLUMNS:
        np.testing.assert_array_equal(table[name], source[name])
    assert campaign.infos[0].step_position == 1.5 and table.info.status == "complete"
    assert not campaign.problems


def test_a_compressed_file_by_itself_and_one_that_lies_unpacked_beside(tmp_path, messages, source):
    folder = write_bag(tmp_path / "bags" / NAME, messages, mcap_storage, "FILE")
    alone = tmp_path / "alone"
    alone.mkdir()
    (file,) = folder.glob("*.zstd")
    (alone / f"{NAME}.mcap.zstd").write_bytes(file.read_bytes())
    (run,) = Campaign.load(alone).runs
    assert run.info.name == NAME and run.info.start == 1
    np.testing.assert_array_equal(run.table()["fx"], source["fx"])
    mcap_storage(folder / f"{NAME}_0", messages, bytes)  # `ros2 bag play` leaves it there
    (table,) = Campaign.load(folder.parent).tables()
    np.testing.assert_array_equal(table["fx"], source["fx"])


def test_a_compressed_file_without_its_end_is_read_as_far_as_it_goes(tmp_path, messages, source):
    folder = write_bag(tmp_path / NAME, messages, mcap_storage, "FILE")
    (folder / "run.yaml").write_text(RECORD + "status: complete\n")
    (file,) = folder.glob("*.zstd")
    file.write_bytes(file.read_bytes()[:-40_000])
    campaign = Campaign.load(tmp_path)
    (table,) = campaign.tables()
    assert 0.5 * len(source["fx"]) < len(table) < len(source["fx"])
    assert ["no end" in str(p) for p in campaign.problems] == [True]


@pytest.mark.parametrize("mode", ["FILE", "MESSAGE"])
def test_another_compression_is_refused_with_its_name_and_the_command(tmp_path, messages, mode):
    write_bag(tmp_path / NAME, messages, mcap_storage, mode, "lz4")
    with pytest.raises(FlatplankError, match=f"compressed by {mode.lower()} with 'lz4'") as caught:
        Campaign.load(tmp_path).runs[0].table()
    assert f"ros2 bag convert -i {NAME} -o plain.yaml" in str(caught.value)


def test_what_only_calls_itself_zstd_is_told(tmp_path):
    (tmp_path / NAME).mkdir()
    (tmp_path / NAME / "metadata.yaml").write_text("rosbag2_bagfile_information: {}\n")
    (tmp_path / NAME / f"{NAME}_0.mcap.zstd").write_bytes(b"not at all" * 10)
    with pytest.raises(FlatplankError, match="no zstd file"):
        Campaign.load(tmp_path)
