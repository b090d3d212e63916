# SPDX-License-Identifier: Apache-2.0
"""Reads bags compressed by rosbag2: whole files (`.mcap.zstd`, `.db3.zstd`) or single messages.

rosbag2 ships zstd only. The magic number (RFC 8878) identifies it, so a file without metadata can
be read, too.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import zstandard

from flatplank_data.bags.storage import Block, blocks_of
from flatplank_data.errors import FlatplankError

SUFFIX = ".zstd"
MAGIC = np.array([0x28, 0xB5, 0x2F, 0xFD], dtype=np.uint8)
PIECE = 1 << 20
"""block size for reading [bytes]"""


class CompressedFile:
    """A storage file in one or more zstd frames; unpacked to a temporary file while it is read."""

    def __init__(self, path: Path, storage: Mapping[str, Callable[[Path], Any]]) -> None:
        """`storage`: suffix of the unpacked file -> its reader."""
        self.path = path
        self.cut_short = False
        inside = path.name.removesuffix(SUFFIX)
        suffix = Path(inside).suffix
        if suffix not in storage:
            known = ", ".join(f"{s}{SUFFIX}" for s in storage)
            raise FlatplankError(f"'{suffix or inside}' is no storage", path.name, f"use {known}")
        self._inside, self._open = inside, storage[suffix]

    def blocks(self, wanted: set[str]) -> Iterator[Block]:
        """Messages of the wanted topics."""
        with tempfile.TemporaryDirectory(prefix="flatplank-") as folder:
            plain = Path(folder) / self._inside
            self.cut_short = not _unpack(self.path, plain)
            file = self._open(plain)
            yield from file.blocks(wanted)
            self.cut_short |= file.cut_short


def _unpack(path: Path, plain: Path) -> bool:
    """Unpack the file; false when its end is missing."""
    frame = zstandard.ZstdDecompressor().decompressobj()
    try:
        with open(path, "rb") as source, open(plain, "wb") as target:
            while piece := source.read(PIECE):
                while piece:
                    target.write(frame.decompress(piece))
                    piece = frame.unused_data if frame.eof else b""
                    if piece:
                        frame = zstandard.ZstdDecompressor().decompressobj()
    except zstandard.ZstdError as error:
        raise FlatplankError(
            f"no zstd file ({error})", path.name, "copy the bag again from where it was recorded"
        ) from error
    return frame.eof


def plain_blocks(blocks: Iterable[Block]) -> Iterator[Block]:
    """The messages of the blocks, unpacked where they were compressed one by one."""
    for block in blocks:
        if (
            block.payloads.shape[1] > MAGIC.size
            and (block.payloads[0, : MAGIC.size] == MAGIC).all()
        ):
            yield from _unpacked(block)
        else:
            yield block


def _unpacked(block: Block) -> Iterator[Block]:
    unpack = zstandard.ZstdDecompressor().decompress
    try:
        found = [unpack(payload.tobytes()) for payload in block.payloads]
    except zstandard.ZstdError as error:
        raise FlatplankError(
            f"a message cannot be unpacked ({error})", block.channel.topic, "the bag is damaged"
        ) from error
    yield from blocks_of(block.channel, block.log_time, found)
