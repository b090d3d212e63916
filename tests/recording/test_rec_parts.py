# SPDX-License-Identifier: Apache-2.0
"""Parts of the recorder, number by number: cycles, clock, blocks, topics, what is filled in."""

from __future__ import annotations

import numpy as np
import pytest
import rec_samples as samples
import yaml

from flatplank_control.recording.blocks import TopicBlock, merge_blocks, unroll
from flatplank_control.recording.bus_cycles import BenchClock, BusImage, CycleCount
from flatplank_control.recording.mcap_scan import messages_of
from flatplank_control.recording.recovery import RepairedBag, repair
from flatplank_control.recording.topics import LATCHED, Qos, qos_text, recorded_topics

MS = 1_000_000
S = 1000 * MS
PERIOD = 4 * MS


def image(first: int, last: int, stamp_ns: int, period_ns: int = PERIOD) -> BusImage:
    return BusImage(first, last, False, stamp_ns, period_ns)


COUNTED = [
    # messages as (first, last, stamp in periods): received, lost, restarts
    ([(1, 1, 1), (2, 2, 2), (3, 3, 3)], (3, 0, 0)),
    ([(1, 4, 4), (5, 8, 8)], (8, 0, 0)),
    ([(1, 1, 1), (4, 4, 4)], (2, 2, 0)),
    ([(1, 4, 4), (9, 12, 12)], (8, 4, 0)),
    ([(7, 7, 7), (7, 7, 7)], (2, 0, 1)),  # the same number again
    ([(100, 100, 100), (1, 1, 150), (2, 2, 151)], (3, 49, 1)),  # restarted after a pause
    ([(1, 1, 1), (2, 2, 12)], (2, 10, 0)),  # only the stamps show the pause
    ([(1, 1, 1), (12, 12, 2)], (2, 10, 0)),  # only the numbers do
    ([(5, 5, 5), (1, 1, 5)], (2, 0, 1)),
    ([(9, 9, 9)], (1, 0, 0)),
]


@pytest.mark.parametrize("at_once", [False, True], ids=["one by one", "at once"])
@pytest.mark.parametrize(("messages", "counts"), COUNTED)
def test_cycles_are_counted_by_numbers_and_stamps(messages, counts, at_once):
    count = CycleCount()
    first, last, stamps = np.array(messages).T
    if at_once:
        count.add_many(first, last, stamps * PERIOD, PERIOD)
        count.add_many(first[:0], last[:0], stamps[:0], PERIOD)
    else:
        for a, b, at in messages:
            count.add(image(a, b, at * PERIOD))
    assert (count.received, count.lost, count.restarts) == counts
    assert (count.first, count.last, count.stamp_ns) == (
        messages[0][0], messages[-1][1], messages[-1][2] * PERIOD,
    )  # fmt: skip


@pytest.mark.parametrize("at_once", [False, True], ids=["one by one", "at once"])
def test_without_a_period_only_the_numbers_count(at_once):
    count = CycleCount()
    if at_once:
        count.add_many(np.array([1, 5]), np.array([1, 5]), np.array([0, 99 * PERIOD]), 0)
    else:
        count.add(image(1, 1, 0, 0))
        count.add(image(5, 5, 99 * PERIOD, 0))
    assert (count.received, count.lost) == (2, 3)


def test_messages_after_others_are_counted_from_the_last_one():
    count = CycleCount()
    count.add(image(1, 1, PERIOD))
    count.add_many(np.array([3, 4]), np.array([3, 4]), np.array([3, 4]) * PERIOD, PERIOD)
    count.add(image(7, 7, 7 * PERIOD))
    assert (count.first, count.last, count.received, count.lost) == (1, 7, 4, 3)


def test_the_counts_are_in_the_record():
    count = CycleCount()
    for at in (5, 6, 1):
        count.add(image(at, at, at * PERIOD))
    record = count.with_bus_cycles(samples.toyo(notes="mine"))
    assert (record.cycle_first, record.cycle_last) == (5, 1)
    assert (record.cycles_received, record.cycles_lost, record.cycles_late) == (3, 0, None)
    assert record.notes == "mine; the bus restarted 1 times"
    assert count.with_bus_cycles(record).notes == record.notes
    assert count.with_bus_cycles(samples.toyo()).notes == "the bus restarted 1 times"
    assert CycleCount().with_bus_cycles(samples.toyo(notes="mine")).notes == "mine"


def bench_time(*cycles: tuple[int, int], at: int = 0) -> int:
    """Bench time at a time of the computer [ms], after cycles as (stamp, reception) [ms]."""
    clock = BenchClock()
    for stamp, now in cycles:
        clock.add(stamp * MS, now * MS)
    return clock.time(at * MS) // MS


@pytest.mark.parametrize(
    ("cycles", "ahead"),
    [
        ([(5000, 1000)], 4000),
        ([(5000, 1000), (5004, 1003)], 4001), ([(5000, 1000), (5004, 1009)], 4000),
        # another bus: it is off by more than a second
        ([(5000, 1000), (8000, 2999)], 5001), ([(5000, 1000), (3998, 999)], 2999),
        ([(5000, 1000), (6999, 2000)], 4999), ([(5000, 1000), (4001, 1000)], 4000),
        # the best of this second and of the one before counts, no older one
        ([(5000, 1000), (5990, 2000)], 4000), ([(5000, 1000), (5990, 2001)], 4000),
        ([(5000, 1000), (5990, 2001), (6990, 3001)], 4000),
        ([(5000, 1000), (5990, 2001), (6985, 3002)], 3989),
        ([(5000, 1000), (5990, 2001), (6985, 3002), (6990, 3003)], 3989),
        ([(5000, 1000), (5990, 2001), (6985, 3002), (6995, 3004)], 3991),
    ],
)  # fmt: skip
def test_the_cycle_with_the_least_delay_sets_the_clock(cycles, ahead):
    assert bench_time(*cycles, at=7) == 7 + ahead


def block(topic: str, *messages: tuple[int, bytes]) -> TopicBlock:
    stamps = np.array([stamp for stamp, _ in messages], np.int64)
    size = len(messages[0][1]) if messages else 3
    data = np.frombuffer(b"".join(data for _, data in messages), np.uint8)
    return TopicBlock(topic, stamps, data.reshape(len(messages), size))


@pytest.mark.parametrize(
    "blocks",
    [
        [block("a", (5, b"abc"))],
        [block("a", (1, b"abc"), (2, b"def"), (3, b"ghi"))],
        [block("a", (1, b"abc"), (3, b"def")), block("b", (2, b"longer"), (3, b"is it!"))],
        [block("a", (1, b"abc"), (5, b"def"), (6, b"ghi")), block("b", (2, b"x"), (3, b"y"))],
        [block("a"), block("b", (4, b"z")), block("b", (2, b"yy"), (9, b"zz"))],
    ],
)
def test_blocks_are_merged_by_time_as_messages_one_by_one(blocks):
    """Messages of one stamp keep the order of the blocks."""
    channels = {"a": 7, "b": 9}
    data, start, end, index = merge_blocks(blocks, channels)
    expected = sorted(
        ((at, channels[b.topic], b.payload[n].tobytes())
         for b in blocks for n, at in enumerate(b.stamps_ns.tolist())),
        key=lambda message: message[0],
    )  # fmt: skip
    found = list(messages_of(data))
    assert [(m.log_ns, m.channel, m.data) for m in found] == expected
    assert all(m.stamp_ns == m.log_ns for m in found)
    assert (start, end) == (expected[0][0], expected[-1][0])
    names = {number: name for name, number in channels.items()}
    assert list(unroll(blocks)) == [(names[c], payload, at) for at, c, payload in expected]
    for channel, packed in index.items():
        entries = np.frombuffer(packed, "<u8").reshape(-1, 2).tolist()
        for at, offset in entries:
            (first, *_) = messages_of(data[offset:])
            assert (first.log_ns, first.channel) == (at, channel)
    assert sum(len(packed) for packed in index.values()) == 16 * len(expected)


def test_nothing_is_merged_to_nothing():
    assert merge_blocks([], {}) is None and merge_blocks([block("a")], {"a": 1}) is None
    assert list(unroll([block("a")])) == []


def test_a_message_that_is_cut_is_left_out():
    data, *_ = merge_blocks([block("a", (1, b"abc"), (2, b"def"))], {"a": 7})
    for cut, whole in ((0, 2), (1, 1), (34, 1), (35, 0)):
        assert len(list(messages_of(data[: len(data) - cut]))) == whole
    assert list(messages_of(b"\x06" + data[1:])) == []


def test_a_profile_in_the_metadata():
    qos = Qos(depth=3, deadline_ns=2 * S + 5, lifespan_ns=7)
    (profile,) = yaml.safe_load(qos_text(qos))
    assert (profile["depth"], profile["reliability"], profile["durability"]) == (
        3, "reliable", "volatile",
    )  # fmt: skip
    assert profile["deadline"] == {"sec": 2, "nsec": 5}
    assert profile["lifespan"] == {"sec": 0, "nsec": 7}
    assert profile["avoid_ros_namespace_conventions"] is False
    assert LATCHED.latched and not qos.latched
    assert not Qos(depth=2, durability="transient_local").latched and not Qos(depth=1).latched


def test_the_topics_of_further_axes():
    usual = {spec.name for spec in recorded_topics(())}
    further = [spec.name for spec in recorded_topics(("plank", "steer"))]
    assert [name for name in further if name not in usual] == [
        "/plank_drive/status", "/plank_drive/joint_states", "/plank_drive/mode",
        "/steer_drive/status", "/steer_drive/joint_states", "/steer_drive/reference",
        "/steer_drive/mode",
    ]  # fmt: skip
    assert len(further) == len(set(further)) and {"/rosout", "/operator/in_charge"} <= usual


@pytest.mark.parametrize("kind", [str, lambda path: path], ids=["text", "path"])
def test_only_folders_with_a_bag_are_repaired(tmp_path, kind):
    (tmp_path / "empty").mkdir()
    (tmp_path / "notes.txt").write_text("x")
    broken = tmp_path / "broken"
    broken.mkdir()
    (broken / "broken_0.mcap").write_bytes(b"no bag at all")
    (found,) = repair(kind(tmp_path))
    assert (found.path, found.messages) == (broken, 0)
    assert found.note.startswith("not repaired: ") and "not an MCAP file" in found.note
    assert str(RepairedBag(broken, 3, "closed")) == "broken: closed"
