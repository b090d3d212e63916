# SPDX-License-Identifier: Apache-2.0
"""The recorder's states, its counting, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest
import rec_samples as samples
import yaml

from flatplank_control.recording.bag_writer import BagWriter
from flatplank_control.recording.blocks import TwinWriter
from flatplank_control.recording.bus_cycles import BusImage, CycleCount, read_bus_image
from flatplank_control.recording.session import RecordingSession, State
from flatplank_control.recording.topics import RUN_TOPIC
from flatplank_control.recording.typestore import typestore
from flatplank_data.errors import RecordingError
from flatplank_data.run_record import load_record, record_from_yaml


@pytest.fixture
def session(tmp_path):
    with RecordingSession(tmp_path, samples.TOPICS, pre_trigger=0.1) as session:
        yield session


def feed(session: RecordingSession, cycles, trigger_from: int | None = None) -> None:
    for cycle in cycles:
        trigger = trigger_from is not None and cycle >= trigger_from
        stamp_ns = cycle * samples.PERIOD_NS
        session.write(samples.BUS, samples.bus_bytes(cycle, trigger), stamp_ns)
        session.write(samples.WRENCH, samples.wrench_bytes(cycle), stamp_ns)


def stored_cycles(path) -> list[int]:
    return [read_bus_image(d).last for t, _, d in samples.read(path) if t == samples.BUS]


def told(path) -> list[str]:
    """Status of each message on /run."""
    store = typestore()
    return [
        store.deserialize_cdr(data, RUN_TOPIC.type).status
        for topic, _, data in samples.read(path)
        if topic == RUN_TOPIC.name
    ]


def test_recording_begins_at_the_trigger_with_what_came_before(session):
    path = session.start(samples.toyo(), 0)
    assert session.state is State.ARMED
    feed(session, range(500), trigger_from=400)
    assert session.state is State.RECORDING
    assert load_record(path).status == "recording"
    record = session.stop("complete", ended="2024-01-01T00:00:00+00:00")
    assert session.state is State.IDLE
    assert stored_cycles(path) == list(range(375, 500))
    assert (record.cycle_first, record.cycle_last) == (375, 499)
    assert (record.cycles_received, record.cycles_lost) == (125, 0)
    assert record.status == "complete"
    assert load_record(path) == record == session.record
    assert told(path) == ["armed", "complete"]


@pytest.mark.parametrize("late", [-2, -1, 0, 1, 2])
def test_what_is_kept_is_the_same_in_whatever_order_topics_arrive(session, late):
    """A topic reaches the recorder `late` cycles after the bus, or before it."""
    path = session.start(samples.toyo(), 0)
    for cycle in range(100, 500):
        wrench, bus = ((t, cycle - n) for t, n in ((samples.WRENCH, late), (samples.BUS, 0)))
        for topic, at in (wrench, bus) if late < 0 else (bus, wrench):
            data = samples.wrench_bytes(at) if topic == samples.WRENCH else None
            data = samples.bus_bytes(at, at >= 400) if data is None else data
            session.write(topic, data, at * samples.PERIOD_NS)
    session.stop("complete")
    stamps = {t: [s for name, s, _ in samples.read(path) if name == t] for t in
              (samples.BUS, samples.WRENCH)}  # fmt: skip
    first = 375 * samples.PERIOD_NS
    assert stamps[samples.BUS][0] == stamps[samples.WRENCH][0] == first


def test_a_trigger_that_is_already_on_does_not_start(session):
    path = session.start(samples.toyo(), 0)
    feed(session, range(10), trigger_from=0)
    assert session.state is State.ARMED
    feed(session, range(10, 20))
    feed(session, range(20, 30), trigger_from=20)
    assert session.state is State.RECORDING
    session.stop("complete")
    assert stored_cycles(path)[-1] == 29


def test_start_at_once(session):
    path = session.start(samples.toyo(), 0, at_once=True)
    feed(session, range(5))
    session.stop()
    assert stored_cycles(path) == list(range(5))
    assert load_record(path).status == "stopped"


def test_lost_cycles_are_counted(session):
    path = session.start(samples.toyo(), 0, at_once=True)
    feed(session, [0, 1, 2, 5, 6, 10])
    record = session.stop("complete")
    assert (record.cycles_received, record.cycles_lost) == (6, 5)
    last = [d for t, _, d in samples.read(path) if t == RUN_TOPIC.name][-1]
    message = typestore().deserialize_cdr(last, RUN_TOPIC.type)
    assert record_from_yaml(message.record) == record


@pytest.mark.parametrize("batch", [1, 4, 7])
def test_batches_of_cycles(batch):
    count = CycleCount()
    for last in (batch - 1, 2 * batch - 1, 4 * batch - 1):
        image = read_bus_image(samples.bus_bytes(last, batch=batch))
        stamp_ns = last * samples.PERIOD_NS
        assert image == BusImage(last - batch + 1, last, False, stamp_ns, samples.PERIOD_NS)
        assert read_bus_image(samples.bus_bytes(last, True, batch)).trigger
        count.add(image)
    assert (count.first, count.received, count.lost) == (0, 3 * batch, batch)


def test_a_bus_that_restarts_is_noted(session):
    session.start(samples.toyo(notes="new tire"), 0, at_once=True)
    feed(session, [100, 101, 0, 1, 2])
    record = session.stop("complete")
    assert (record.cycles_received, record.cycles_lost) == (5, 0)
    assert record.notes == "new tire; the bus restarted 1 times"


@pytest.mark.parametrize("batch", [1, 4])
def test_a_pause_of_the_bus_is_counted_by_the_stamps(batch):
    """A bus that was started anew numbers its cycles from 0, and its clock has gone on."""
    pause = 20 * batch * samples.PERIOD_NS
    cycles = batch * np.arange(1, 6) - 1
    messages = [samples.bus_messages(cycles, batch=batch, since_ns=t) for t in (0, pause)]
    one, many = CycleCount(), CycleCount()
    for message in (m for part in messages for m in samples.one_by_one(part)):
        one.add(read_bus_image(message))
    whole = np.concatenate(messages)
    last = whole["cycle"].astype(np.int64)
    stamps = np.concatenate([t + cycles * samples.PERIOD_NS for t in (0, pause)])
    many.add_many(last - batch + 1, last, stamps, samples.PERIOD_NS)
    assert one == many
    assert (one.received, one.lost, one.restarts) == (10 * batch, 15 * batch, 1)


def test_a_bag_begins_with_what_is_latched(tmp_path):
    """Said before the start, or while the recorder waits for the trigger."""
    topics = samples.TOPICS
    with RecordingSession(tmp_path, topics, pre_trigger=0.1) as session:
        session.write(samples.MODE, samples.mode_bytes("position"), 0)
        first = session.start(samples.toyo(), 0, at_once=True)
        session.stop("complete")
        second = session.start(samples.toyo(), 0)
        session.write(samples.MODE, samples.mode_bytes("slip"), 0)
        feed(session, range(500), trigger_from=400)
        session.stop("complete")
    for path, mode in ((first, "position"), (second, "slip")):
        assert [d for t, _, d in samples.read(path) if t == samples.MODE] == [
            samples.mode_bytes(mode)
        ]


def test_what_is_not_a_bus_image_is_refused():
    with pytest.raises(RecordingError, match="not flatplank_msgs/BusInputs"):
        read_bus_image(b"\0\1\0\0" + b"\0" * 20)


def test_further_runs_of_a_name(session):
    paths = []
    for _ in range(3):
        paths.append(session.start(samples.toyo(), 0, at_once=True))
        session.stop("complete")
    stem = "TOY_REL_LNG_5perc_T_p25_Fz5550_2"
    assert [path.name for path in paths] == [stem, f"{stem}_r02", f"{stem}_r03"]
    assert load_record(paths[2]).name == f"{stem}_r03"


def test_discard(session, tmp_path):
    path = session.start(samples.toyo(), 0, at_once=True)
    feed(session, range(5))
    assert session.discard() == path
    assert list(tmp_path.iterdir()) == []
    assert session.state is State.IDLE
    assert session.record.status == "discarded"


def test_whatever_happens_it_is_closed(tmp_path):
    with pytest.raises(ZeroDivisionError), RecordingSession(tmp_path, samples.TOPICS) as session:
        path = session.start(samples.toyo(), 0, at_once=True)
        feed(session, range(5))
        raise ZeroDivisionError
    assert load_record(path).status == "interrupted"
    assert stored_cycles(path) == list(range(5))


def test_refusals_change_nothing(session, tmp_path):
    with pytest.raises(RecordingError, match="nothing is being recorded"):
        session.stop()
    with pytest.raises(RecordingError, match="nothing is being recorded"):
        session.discard()
    with pytest.raises(RecordingError, match="no such folder"):
        session.start(samples.toyo(), 0, folder=tmp_path / "none")
    path = session.start(samples.toyo(), 0)
    with pytest.raises(RecordingError, match="is armed; stop or discard it first"):
        session.start(samples.toyo(kappa=0.01), 0)
    with pytest.raises(RecordingError, match="status 'done' is unknown"):
        session.stop("done")
    assert session.state is State.ARMED
    assert session.path == path
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_a_full_disk_is_refused_before_it_starts(tmp_path):
    session = RecordingSession(tmp_path, samples.TOPICS, free_disk=lambda _: 199_000_000)
    with pytest.raises(RecordingError, match=r"disk is full.*199 MB free, 200 MB needed"):
        session.start(samples.toyo(), 0)
    assert list(tmp_path.iterdir()) == []


class BrokenBag(BagWriter):
    """Its disk fills up after ten messages."""

    def flush(self) -> None:
        if self._file.index.messages + len(self._file._parts) // 2 > 10:
            self._guarded(self._full)
        super().flush()

    def _full(self) -> None:
        raise OSError(28, "No space left on device")


def test_a_disk_that_fills_up_closes_the_run_as_failed(tmp_path):
    session = RecordingSession(
        tmp_path, samples.TOPICS, open_bag=lambda *a: BrokenBag(*a, flush_period=0.0)
    )
    path = session.start(samples.toyo(), 0, at_once=True)
    with pytest.raises(RecordingError, match="No space left"):
        feed(session, range(20))
    assert session.state is State.IDLE
    record = load_record(path)
    assert record.status == "failed"
    assert "No space left" in record.stop_reason
    assert len(stored_cycles(path)) >= 4
    custom = yaml.safe_load((path / "metadata.yaml").read_text())
    assert custom["rosbag2_bagfile_information"]["custom_data"]["status"] == "failed"
    session.write(samples.BUS, samples.bus_bytes(0), 0)
    session.start(samples.toyo(), 0)
    session.close()


def by_polling(session: RecordingSession) -> None:
    for cycle in range(20):
        feed(session, [cycle])
        session.poll()


def by_blocks(session: RecordingSession) -> None:
    """As the twin does."""
    writer = TwinWriter(session, {samples.BUS: samples.bus_layout()})
    fixed = {"count": 1, "period_ns": samples.PERIOD_NS}
    for part in np.array_split(np.arange(40), 4):
        writer.add(samples.BUS, part * samples.PERIOD_NS, {**fixed, "cycle": part})
        writer.flush()


def at_its_end(session: RecordingSession) -> None:
    feed(session, range(20))
    session.stop("complete", fill=lambda record, _path: record)


@pytest.mark.parametrize("act", [by_polling, by_blocks, at_its_end])
def test_a_full_disk_closes_the_run_whoever_notices_it(tmp_path, act):
    """Messages stay in the memory until they are flushed by somebody."""
    session = RecordingSession(tmp_path, samples.TOPICS, open_bag=lambda *a: BrokenBag(
        *a, flush_period=1e9 if act is at_its_end else 0.0))  # fmt: skip
    path = session.start(samples.toyo(), 0, at_once=True)
    with pytest.raises(RecordingError, match="No space left"):
        act(session)
    assert session.state is State.IDLE
    record = load_record(path)
    assert (record.status, "No space left" in record.stop_reason) == ("failed", True)


def test_poll_brings_the_last_messages_to_the_disk(tmp_path):
    session = RecordingSession(
        tmp_path, samples.TOPICS, open_bag=lambda *a: BagWriter(*a, flush_period=0.0)
    )
    path = session.start(samples.toyo(), 0, at_once=True)
    size = sum(file.stat().st_size for file in path.glob("*.mcap"))
    session.write(samples.WRENCH, samples.wrench_bytes(1.0), 1)
    session.poll()
    assert sum(file.stat().st_size for file in path.glob("*.mcap")) > size
    session.stop("complete")


def test_a_message_stamped_by_another_clock_does_not_push_out_the_rest(session):
    path = session.start(samples.toyo(), 0)
    feed(session, range(100))
    session.write(samples.WRENCH, samples.wrench_bytes(1.0), 1_700_000_000 * 10**9)
    feed(session, range(100, 200), trigger_from=110)
    session.stop("complete")
    assert stored_cycles(path) == list(range(85, 200))


def test_before_the_trigger_only_what_is_needed_is_kept(session):
    session.start(samples.toyo(), 0)
    feed(session, range(1000))
    assert len(session._ring) == 2 * 26
    feed(session, range(10))
    assert len(session._ring) == 2 * 10


def test_the_bag_is_named_by_its_whole_path(tmp_path, monkeypatch):
    """Whoever is told of it works in another folder than the recorder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "data").mkdir()
    (tmp_path / "other").mkdir()
    with RecordingSession("data", samples.TOPICS) as session:
        path = session.start(samples.toyo(), 0, at_once=True)
        session.stop("complete")
        assert path == session.path == tmp_path / "data" / "TOY_REL_LNG_5perc_T_p25_Fz5550_2"
        assert session.start(samples.toyo(), 0, folder="other").parent == tmp_path / "other"


def test_late_cycles_are_those_of_the_run():
    count = CycleCount()
    assert count.with_bus_cycles(samples.toyo()).cycles_late is None
    for told in (7, 9, 9, 2, 3):  # the pace was set anew before the 2
        count.tell_late(told)
    assert count.with_bus_cycles(samples.toyo()).cycles_late == 5
