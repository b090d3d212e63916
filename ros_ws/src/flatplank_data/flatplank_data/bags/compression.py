# SPDX-License-Identifier: Apache-2.0
"""Reads bags compressed by rosbag2: whole files (`.mcap.zstd`, `.db3.zstd`) or single messages.

rosbag2 ships zstd only. The magic number (RFC 8878) identifies it, so a file without metadata can
be read, too.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import zstandard

from flatplank_data.bags.blocks import Block, blocks_of
from flatplank_data.bags.mcap import COPY, NO_END
from flatplank_data.errors import FlatplankError
from flatplank_data.guard import Budget, DamagedError

SUFFIX = ".zstd"
MAGIC = np.array([0x28, 0xB5, 0x2F, 0xFD], dtype=np.uint8)
PIECE = 1 << 20
"""block size for reading [bytes]"""


class CompressedFile:
    """A storage file in one or more zstd frames; unpacked to a temporary file while it is read."""

    def __init__(self, path: Path, storage: Mapping[str, Callable[..., Any]]) -> None:
        """`storage`: suffix of the unpacked file -> its reader."""
        self.path = path
        self.remarks: list[str] = []
        self.budget = Budget.of(path.name, path.stat().st_size)
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
            whole = _unpack(self.path, plain, self.budget)
            file = self._open(plain, self.budget)
            yield from file.blocks(wanted)
            self.remarks += file.remarks
            if not whole and NO_END not in self.remarks:
                self.remarks.append(NO_END)


def _unpack(path: Path, plain: Path, budget: Budget) -> bool:
    """Unpack the file; false when its end is missing."""
    frame = zstandard.ZstdDecompressor().decompressobj()
    try:
        with open(path, "rb") as source, open(plain, "wb") as target:
            while piece := source.read(PIECE):
                while piece:
                    out = frame.decompress(piece)
                    budget.take(len(out))
                    target.write(out)
                    piece = frame.unused_data if frame.eof else b""
                    if piece:
                        frame = zstandard.ZstdDecompressor().decompressobj()
    except (zstandard.ZstdError, OSError) as error:
        raise FlatplankError(
            f"no zstd file, damaged, or no room to unpack it ({error})", path.name, COPY
        ) from error
    return bool(frame.eof)


def plain_blocks(file: Any, wanted: set[str]) -> Iterator[Block]:
    """Messages of the wanted topics, unpacked where they were compressed one by one."""
    for block in file.blocks(wanted):
        if (
            block.payloads.shape[1] > MAGIC.size
            and (block.payloads[:, : MAGIC.size] == MAGIC).all()
        ):
            yield from _unpacked(block, file.budget)
        else:
            yield block


def _unpacked(block: Block, budget: Budget) -> Iterator[Block]:
    try:
        found = [budget.zstd(payload.tobytes()) for payload in block.payloads]
    except DamagedError as error:
        raise FlatplankError(
            f"a message cannot be unpacked ({error})", block.channel.topic, "the bag is damaged"
        ) from error
    yield from blocks_of(block.channel, block.log_time, found)
