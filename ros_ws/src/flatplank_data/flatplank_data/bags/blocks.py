# SPDX-License-Identifier: Apache-2.0
"""Messages of a bag as blocks: one channel, one payload size, many messages at a time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Channel:
    """A topic of the bag with its type."""

    topic: str
    type: str
    definition: str
    language: str = "ros2msg"
    """language of the definition, as MCAP names it; empty: not stated"""
    coding: str = "cdr"
    """serialisation of the messages"""


@dataclass(frozen=True)
class Block:
    """Messages of one channel with payloads of one size."""

    channel: Channel
    log_time: np.ndarray
    """(messages,) [ns]"""
    payloads: np.ndarray
    """(messages, bytes) uint8"""


def blocks_of(channel: Channel, times: np.ndarray, payloads: Sequence[bytes]) -> Iterator[Block]:
    """Messages of one channel as blocks of one payload size each."""
    sizes = np.array([len(data) for data in payloads])
    for size in np.unique(sizes):
        same = np.flatnonzero(sizes == size)
        matrix = np.frombuffer(b"".join(payloads[i] for i in same), dtype=np.uint8)
        yield Block(channel, times[same], matrix.reshape(len(same), int(size)))
