# SPDX-License-Identifier: Apache-2.0
"""A bag cut anywhere becomes readable again, with all that was whole."""

from __future__ import annotations

import random
import shutil
from pathlib import Path

import pytest
import rec_samples as samples
import yaml
from mcap.reader import make_reader
from mcap.writer import Writer

from flatplank_control.recording.bag_writer import BagWriter, bag_file_name
from flatplank_control.recording.bus_cycles import read_bus_image
from flatplank_control.recording.mcap_scan import scan
from flatplank_control.recording.recovery import repair
from flatplank_control.recording.session import RecordingSession
from flatplank_data.files import PART
from flatplank_data.run_record import load_record

CYCLES = 120
LATE_NS = 1_000_000
"""from the stamp of a wrench to its reception [ns]"""


def recorded(folder: Path) -> Path:
    """A closed bag of several chunks, with its record."""
    folder.mkdir()
    session = RecordingSession(
        folder, samples.TOPICS, open_bag=lambda *args: BagWriter(*args, chunk_size=8000)
    )
    path = session.start(samples.toyo(), 0, at_once=True)
    for cycle in range(CYCLES):
        stamp_ns = cycle * samples.PERIOD_NS
        session.write(samples.BUS, samples.bus_bytes(cycle), stamp_ns)
        session.write(samples.WRENCH, samples.wrench_bytes(cycle), stamp_ns, stamp_ns + LATE_NS)
    session.stop("complete")
    return path


def cut(source: Path, target: Path, size: int) -> Path:
    """The same bag as a kill would leave it after `size` bytes."""
    path = target / source.name
    shutil.copytree(source, path)
    (path / "metadata.yaml").unlink()
    file = path / bag_file_name(path.name)
    file.write_bytes(file.read_bytes()[:size])
    record = load_record(path)
    record.with_changes(status="recording", cycles_received=0, cycle_first=None).save(path)
    (path / ".reserve").write_bytes(b"")
    return path


def bytes_of(path: Path) -> bytes:
    return (path / bag_file_name(path.name)).read_bytes()


def test_cut_anywhere(tmp_path):
    source = recorded(tmp_path / "source")
    all_messages = [m for m in samples.read(source) if m[0] != "/run"]
    size = len(bytes_of(source))
    rng = random.Random(3)
    sizes = [0, 3, 8, 20, size - 1, size - 8, *(rng.randrange(9, size) for _ in range(40))]
    for number, length in enumerate(sizes):
        folder = tmp_path / str(number)
        folder.mkdir()
        path = cut(source, folder, length)
        (path / f".run.yaml.{number}{PART}").touch()
        whole = scan(path / bag_file_name(path.name))
        expected = whole.index.messages + len(whole.rest)
        (result,) = repair(folder)
        assert "not repaired" not in result.note
        messages = samples.read(path)
        data = [m for m in messages if m[0] != "/run"]
        assert data == all_messages[: len(data)]
        assert expected <= len(messages) <= expected + 1
        with (path / bag_file_name(path.name)).open("rb") as file:
            reader = make_reader(file, validate_crcs=True)
            found = [(c.topic, m.log_time - m.publish_time) for _, c, m in reader.iter_messages()]
            assert len(found) == len(messages)
            assert all(late == LATE_NS * (t == samples.WRENCH) for t, late in found if t != "/run")
        assert sorted(p.name for p in path.iterdir()) == [
            bag_file_name(path.name),
            "metadata.yaml",
            "run.yaml",
        ]
        assert repair(folder) == []


def test_whole_messages_of_a_cut_chunk_are_kept(tmp_path):
    source = recorded(tmp_path / "source")
    chunk = scan(source / bag_file_name(source.name)).index.chunks[2]
    (tmp_path / "cut").mkdir()
    path = cut(source, tmp_path / "cut", chunk.chunk_start_offset + chunk.chunk_length - 1)
    repair(tmp_path / "cut")
    stamps = {stamp for _, stamp, _ in samples.read(path)}
    assert max(stamps) >= chunk.message_end_time - samples.PERIOD_NS


def test_record_is_closed_as_interrupted_with_its_counts(tmp_path):
    source = recorded(tmp_path / "source")
    (tmp_path / "cut").mkdir()
    path = cut(source, tmp_path / "cut", len(bytes_of(source)) // 2)
    repair(tmp_path / "cut")
    record = load_record(path)
    messages = samples.read(path)
    count = sum(topic == samples.BUS for topic, _, _ in messages)
    assert 10 < count < CYCLES
    assert (record.status, record.cycles_received, record.cycles_lost) == ("interrupted", count, 0)
    assert (record.cycle_first, record.cycle_last) == (0, count - 1)
    assert record.stop_reason
    assert messages[-1][0] == "/run"
    custom = yaml.safe_load((path / "metadata.yaml").read_text())
    custom = custom["rosbag2_bagfile_information"]["custom_data"]
    assert custom == {"status": "interrupted", "uuid": record.uuid, "tire": "TOY"}


def test_a_kill_between_the_last_message_and_the_summary_keeps_the_status(tmp_path):
    source = recorded(tmp_path / "source")
    (tmp_path / "cut").mkdir()
    path = cut(source, tmp_path / "cut", len(bytes_of(source)) - 100)
    repair(tmp_path / "cut")
    assert load_record(path).status == "complete"
    assert load_record(path).cycles_received == CYCLES
    assert samples.read(path) == samples.read(source)


def test_only_the_record_was_not_closed(tmp_path):
    source = recorded(tmp_path / "source")
    before = samples.read(source)
    load_record(source).with_changes(status="recording").save(source)
    (result,) = repair(source.parent)
    assert load_record(source).status == "complete"
    assert result.messages == len(before)
    assert samples.read(source) == before


def test_closed_bags_are_left_alone(tmp_path):
    source = recorded(tmp_path / "source")
    before = bytes_of(source)
    assert repair(source.parent) == []
    assert bytes_of(source) == before


def test_a_bag_that_is_being_written_is_left_alone(tmp_path):
    session = RecordingSession(tmp_path, samples.TOPICS)
    path = session.start(samples.toyo(), 0, at_once=True)
    session.write(samples.BUS, samples.bus_bytes(0), 0)
    assert repair(tmp_path) == []
    session.write(samples.BUS, samples.bus_bytes(1), 1)
    session.stop("complete")
    assert [read_bus_image(d).last for t, _, d in samples.read(path) if t == samples.BUS] == [0, 1]


def test_a_file_of_another_program_is_left_alone(tmp_path):
    path = tmp_path / "foreign"
    path.mkdir()
    with (path / bag_file_name("foreign")).open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2", library="other")
        writer.finish()
    before = bytes_of(path)
    (result,) = repair(tmp_path)
    assert "not repaired" in result.note
    assert "'other'" in result.note
    assert bytes_of(path) == before


@pytest.mark.parametrize("finished", [True, False])
def test_damage_in_the_middle_is_told_and_left(tmp_path, finished):
    source = recorded(tmp_path / "source")
    file = source / bag_file_name(source.name)
    chunks = scan(file).index.chunks
    data = bytearray(file.read_bytes())
    data[chunks[1].chunk_start_offset + 200] ^= 255
    file.write_bytes(data if finished else data[: chunks[-1].chunk_start_offset])
    (source / "metadata.yaml").unlink()
    before = bytes_of(source)
    (result,) = repair(source.parent)
    assert f"damaged at byte {chunks[1].chunk_start_offset}" in result.note
    assert bytes_of(source) == before


def test_zeros_at_the_end_after_a_power_cut(tmp_path):
    source = recorded(tmp_path / "source")
    chunk = scan(source / bag_file_name(source.name)).index.chunks[-2]
    (tmp_path / "cut").mkdir()
    middle = chunk.chunk_start_offset + chunk.chunk_length // 2
    path = cut(source, tmp_path / "cut", middle)
    file = path / bag_file_name(path.name)
    file.write_bytes(file.read_bytes() + bytes(20_000))
    (result,) = repair(tmp_path / "cut")
    assert "closed as interrupted" in result.note
    stamps = [stamp for _, stamp, _ in samples.read(path)]
    assert stamps == sorted(stamps)
    assert max(stamps) < chunk.message_end_time


def test_an_unreadable_record_does_not_cost_the_messages(tmp_path):
    source = recorded(tmp_path / "source")
    (tmp_path / "cut").mkdir()
    first = scan(source / bag_file_name(source.name)).index.chunks[0]
    path = cut(source, tmp_path / "cut", first.chunk_start_offset)
    (path / "run.yaml").write_text("{")
    (result,) = repair(tmp_path / "cut")
    assert "run record cannot be read" in result.note
    assert samples.read(path) == []
