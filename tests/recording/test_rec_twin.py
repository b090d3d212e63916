# SPDX-License-Identifier: Apache-2.0
"""Whole runs written by columns."""

from __future__ import annotations

import time

import numpy as np
import pytest
import rec_samples as samples

from flatplank_control.recording.bag_writer import BagWriter
from flatplank_control.recording.blocks import TwinWriter
from flatplank_control.recording.cdr_layout import CdrLayout
from flatplank_control.recording.session import RecordingSession
from flatplank_control.recording.topics import TopicSpec
from flatplank_data.errors import RecordingError

FIXED = {"count": 1, "period_ns": samples.PERIOD_NS}
LAYOUTS = {samples.BUS: samples.bus_layout(), samples.WRENCH: samples.wrench_layout()}


def add_cycles(writer: TwinWriter, cycles: np.ndarray, trigger_from: int = 0) -> None:
    stamps = cycles * samples.PERIOD_NS
    digital = np.uint8(1) * (cycles[:, None] >= trigger_from)
    writer.add(samples.BUS, stamps, {**FIXED, "cycle": cycles, "digital": digital})
    writer.add(samples.WRENCH, stamps[::2], {"wrench.force.x": cycles[::2] * 1.0})


def test_blocks_are_what_single_messages_are(tmp_path):
    """Two topics of different rates, in time order, byte for byte."""
    blocks = BagWriter(tmp_path, "blocks", samples.TOPICS)
    writer = TwinWriter(blocks, LAYOUTS)
    for first in range(0, 300, 100):
        add_cycles(writer, np.arange(first, first + 100), trigger_from=150)
        writer.flush()
    blocks.close("complete")
    single = BagWriter(tmp_path, "single", samples.TOPICS)
    for cycle in range(300):
        stamp = cycle * samples.PERIOD_NS
        bus = samples.bus_bytes(cycle, trigger=cycle >= 150)
        single.write(samples.BUS, bus, stamp)
        if cycle % 2 == 0:
            wrench = samples.wrench_layout().new(1)
            wrench["header.stamp.sec"], wrench["header.stamp.nanosec"] = divmod(stamp, 10**9)
            wrench["wrench.force.x"] = cycle
            single.write(samples.WRENCH, wrench.tobytes(), stamp)
    single.close("complete")
    assert samples.read(blocks.path) == samples.read(single.path)


def test_messages_of_unlike_rates_are_merged_in_time_order(tmp_path):
    rng = np.random.default_rng(1)
    topics = [TopicSpec(f"/t{number}", "std_msgs/msg/UInt64") for number in range(4)]
    layout = CdrLayout("std_msgs/msg/UInt64")
    bag = BagWriter(tmp_path, "merge", topics)
    writer = TwinWriter(bag, {topic.name: layout for topic in topics})
    sent = []
    for topic in topics:
        stamps = np.sort(rng.integers(0, 1000, rng.integers(0, 400)))
        writer.add(topic.name, stamps, {"data": stamps})
        sent += [(int(stamp), topic.name) for stamp in stamps]
    writer.flush()
    bag.close("complete")
    came = [(stamp, topic) for topic, stamp, _ in samples.read(bag.path)]
    assert came == sorted(sent)


@pytest.mark.parametrize("batch", [1, 4])
def test_session_counts_and_waits_for_the_trigger(tmp_path, batch):
    last = np.arange(batch - 1, 2000, batch)
    last = last[(last < 1200) | (last >= 1200 + 2 * batch)]
    with RecordingSession(tmp_path, samples.TOPICS, pre_trigger=1.0) as session:
        path = session.start(samples.toyo(), 0)
        writer = TwinWriter(session, {samples.BUS: samples.bus_layout(batch)})
        for part in np.array_split(last, 7):
            digital = np.uint8(1) * (part[:, None] >= 1000) * np.ones((1, batch), np.uint8)
            columns = {
                "cycle": part,
                "count": batch,
                "period_ns": samples.PERIOD_NS,
                "digital": digital,
            }
            writer.add(samples.BUS, part * samples.PERIOD_NS, columns)
            writer.flush()
        record = session.stop("complete")
    stored = [
        stamp // samples.PERIOD_NS for topic, stamp, _ in samples.read(path) if topic != "/run"
    ]
    assert stored == [n for n in last.tolist() if n >= last[np.argmax(last >= 1000)] - 250]
    assert record.cycles_received == len(stored) * batch
    assert record.cycles_lost == 2 * batch
    assert (record.cycle_first, record.cycle_last) == (stored[0] - batch + 1, stored[-1])


def test_unknown_topic_and_column_are_refused(tmp_path):
    bag = BagWriter(tmp_path, "x", samples.TOPICS)
    writer = TwinWriter(bag, LAYOUTS)
    with pytest.raises(RecordingError, match="/other"):
        writer.add("/other", np.arange(3), {})
    with pytest.raises(RecordingError, match="no column 'fx'"):
        writer.add(samples.WRENCH, np.arange(3), {"fx": 1.0})
    writer.flush()
    bag.close("complete")
    assert samples.read(bag.path) == []


@pytest.mark.long
def test_twenty_times_real_time_with_bags(tmp_path):
    """11 topics at 250 Hz make 55,000 messages/s at 20 times; measured is ten times this bound."""
    topics = {f"/t{number}": samples.wrench_layout() for number in range(11)}
    bag = BagWriter(tmp_path, "fast", [TopicSpec(t, v.msgtype) for t, v in topics.items()])
    writer = TwinWriter(bag, topics)
    begin = time.perf_counter()
    for first in range(0, 5000, 500):
        stamps = np.arange(first, first + 500) * samples.PERIOD_NS
        for topic in topics:
            writer.add(topic, stamps, {"wrench.force.x": stamps})
        writer.flush()
    bag.close("complete")
    assert 5000 * 11 / (time.perf_counter() - begin) > 150_000
