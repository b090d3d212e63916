# SPDX-License-Identifier: Apache-2.0
"""Logs of a measurement on the twin: the same bag as the recorder's, or a measurement table."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from flatplank_control.recording.blocks import TwinWriter
from flatplank_control.recording.cdr_layout import CdrLayout
from flatplank_control.recording.session import RecordingSession
from flatplank_control.recording.topics import RECORDED
from flatplank_data.exporters import EXPORTERS
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_sim.twin.columns import TOPICS, TopicColumns, table_columns
from flatplank_sim.twin.twin import Cycle

FLUSH_EVERY = 500
"""cycles between flushes"""
PRE_TRIGGER = 2.0
"""time before the trigger that is kept, as in the recorder node [s]"""
_TYPES = {spec.name: spec.type for spec in RECORDED}


class RunLog(Protocol):
    """Interface of a log of one run."""

    def start(self, record: RunRecord, stamp_ns: int, at_once: bool = False) -> None: ...

    def add(self, cycle: Cycle) -> None: ...

    def stop(self, status: str, notes: str) -> Path: ...


class BagLog:
    """Log to a rosbag2 bag per run, as written by the recorder node."""

    def __init__(self, folder: Path) -> None:
        self._session = RecordingSession(folder, RECORDED, pre_trigger=PRE_TRIGGER)
        self._cycles: list[Cycle] = []
        self._writer: TwinWriter | None = None
        self._layouts: dict[Any, CdrLayout] = {}

    def start(self, record: RunRecord, stamp_ns: int, at_once: bool = False) -> None:
        self._session.start(record, stamp_ns, at_once=at_once)

    def add(self, cycle: Cycle) -> None:
        self._cycles.append(cycle)
        if len(self._cycles) >= FLUSH_EVERY:
            self._flush()

    def stop(self, status: str, notes: str) -> Path:
        self._flush()
        self._writer = None
        self._session.stop(status, reason=notes)
        assert self._session.path is not None
        return self._session.path

    def _flush(self) -> None:
        cycles, self._cycles = self._cycles, []
        if not cycles:
            return
        if self._writer is None:
            self._writer = TwinWriter(self._session, layouts(len(cycles[0].batch)))
        period = _period(cycles)
        for topic, how in TOPICS.items():
            samples = [(c, sample) for c in cycles if (sample := how.pick(c)) is not None]
            for layout, some in self._by_texts(topic, how, samples):
                columns: dict[str, Any] = dict(how.columns([sample for _, sample in some]))
                if topic == "/bus/inputs":
                    columns["period_ns"] = period
                stamps = np.array([c.encoders.stamp_ns for c, _ in some])
                self._writer.add(topic, stamps, columns, layout)
        self._writer.flush()

    def _by_texts(
        self, topic: str, how: TopicColumns, samples: list[tuple[Cycle, Any]]
    ) -> Iterator[tuple[CdrLayout | None, list[tuple[Cycle, Any]]]]:
        """Group messages by their texts, with one layout each; None: the layout of the topic."""
        if how.texts is None:
            if samples:
                yield None, samples
            return
        groups: dict[tuple[tuple[str, str], ...], list[tuple[Cycle, Any]]] = {}
        for pair in samples:
            groups.setdefault(tuple(how.texts(pair[1]).items()), []).append(pair)
        for texts, some in groups.items():
            key = (topic, texts)
            if key not in self._layouts:
                fixed = {**how.fixed(len(some[0][0].batch)), **dict(texts)}
                self._layouts[key] = CdrLayout(_TYPES[topic], fixed)
            yield self._layouts[key], some


class TableLog:
    """Log to a measurement table per run; `suffix` selects the format.

    `whole`: with the samples before the motion trigger, where the plank position is another one.
    """

    def __init__(self, folder: Path, suffix: str = ".parquet", whole: bool = False) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._folder, self._suffix, self._whole = folder, suffix, whole
        self._cycles: list[Cycle] = []
        self._blocks: list[dict[str, np.ndarray]] = []
        self._record: RunRecord | None = None

    def start(self, record: RunRecord, stamp_ns: int, at_once: bool = False) -> None:
        self._record, self._cycles, self._blocks = record, [], []

    def add(self, cycle: Cycle) -> None:
        # tuples of a whole run would keep the garbage collector busy for a third of the time
        self._cycles.append(cycle)
        if len(self._cycles) >= FLUSH_EVERY:
            self._flush()

    def stop(self, status: str, notes: str) -> Path:
        assert self._record is not None
        record = self._record.with_changes(status=status, stop_reason=notes)
        path = self._folder / f"{record.name}{self._suffix}"
        self._flush()
        names = self._blocks[0]
        columns = {name: np.concatenate([block[name] for block in self._blocks]) for name in names}
        self._blocks = []
        columns = columns if self._whole else _since_trigger(columns)
        EXPORTERS[self._suffix](MeasurementTable(columns, record), path)
        return path

    def _flush(self) -> None:
        self._blocks.append(table_columns(self._cycles))
        self._cycles = []


def layouts(batch: int) -> dict[str, CdrLayout]:
    """Layouts of the recorded topics for batches of n cycles."""
    return {topic: CdrLayout(_TYPES[topic], how.fixed(batch)) for topic, how in TOPICS.items()}


def _period(cycles: list[Cycle]) -> int:
    batch = cycles[0].batch
    if len(batch) > 1:
        return batch[1].stamp_ns - batch[0].stamp_ns
    return cycles[-1].encoders.stamp_ns // cycles[-1].encoders.cycle


def _since_trigger(columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Samples from the motion trigger on, as in the reader of bags."""
    rising = np.flatnonzero(np.diff(columns["motion_trigger"]) > 0.5)
    first = int(rising[0]) + 1 if rising.size else 0
    return {name: values[first:] for name, values in columns.items()}
