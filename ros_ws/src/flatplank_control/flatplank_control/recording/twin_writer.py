# SPDX-License-Identifier: Apache-2.0
"""Writes a run of the twin: columns of numbers in, messages of a bag out, in time order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from flatplank_control.recording.cdr_layout import CdrLayout, set_stamps
from flatplank_control.recording.merge import TopicBlock
from flatplank_data.errors import RecordingError


class BlockSink(Protocol):
    """A BagWriter or a RecordingSession."""

    def write_blocks(self, blocks: Sequence[TopicBlock]) -> None: ...


class TwinWriter:
    """Collects chunks of a run per topic; `flush` writes what has come since the last one.

    Messages of one stamp follow the order of `layouts`. A second or so of bench time per
    flush is quick; memory is what lies between two flushes.
    """

    def __init__(self, sink: BlockSink, layouts: Mapping[str, CdrLayout]) -> None:
        self._sink = sink
        self._layouts = dict(layouts)
        self._blocks: dict[str, list[TopicBlock]] = {topic: [] for topic in layouts}

    def add(
        self,
        topic: str,
        stamps_ns: np.ndarray,
        columns: Mapping[str, Any],
        layout: CdrLayout | None = None,
    ) -> None:
        """N messages: `stamps_ns` int64 [N] [ns] go into the header, `columns` into the rest.

        Columns are named as in `CdrLayout.dtype`; [N], [N, n] or one value for all. Messages
        whose texts are other ones than the topic's have a `layout` of their own.
        """
        if topic not in self._layouts:
            raise RecordingError(f"{topic}: not a topic of this writer; give its layout")
        layout = layout or self._layouts[topic]
        stamps_ns = np.asarray(stamps_ns, np.int64)
        messages = layout.new(len(stamps_ns))
        names = layout.dtype.names or ()
        if "header.stamp.sec" in names:
            set_stamps(messages, stamps_ns)
        for name, values in columns.items():
            if name not in names:
                raise RecordingError(f"{topic}: no column {name!r} in {layout.msgtype}")
            messages[name] = values
        self._blocks[topic].append(TopicBlock(topic, stamps_ns, messages))

    def flush(self) -> None:
        """Write all that was added."""
        blocks = [block for added in self._blocks.values() for block in added]
        for added in self._blocks.values():
            added.clear()
        self._sink.write_blocks(blocks)
