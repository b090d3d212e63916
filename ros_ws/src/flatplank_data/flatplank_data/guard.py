# SPDX-License-Identifier: Apache-2.0
"""How much a file may unpack to: one guard per file, against files that fill memory or disk."""

from __future__ import annotations

import bz2
from dataclasses import dataclass
from typing import Any

import lz4.frame
import zstandard

from flatplank_data.errors import FlatplankError

RATIO = 1000
"""largest ratio of unpacked to stored bytes. A sample of a bag or table takes about 200 bytes,
and its time alone keeps 1 byte or more when it is packed; files made to fill a memory: 16,000"""
ALWAYS = 256 << 20
"""size that any file may unpack to, because every computer has this memory [bytes]"""
PIECE = 1 << 30
"""largest part that is unpacked at once [bytes]; rosbag2 writes chunks of 1 to 4 MB"""


class DamagedError(FlatplankError):
    """A part of a file that is not what was written."""


@dataclass
class Budget:
    """Bytes that one file may still unpack to."""

    name: str
    left: int

    @classmethod
    def of(cls, name: str, stored: int) -> Budget:
        """Budget of a file of `stored` bytes."""
        return cls(name, max(ALWAYS, RATIO * stored))

    def take(self, size: int) -> None:
        """Count unpacked bytes. Raises FlatplankError when the file unpacks to too much."""
        self.left -= size
        if self.left < 0:
            what = f"it unpacks to more than {RATIO} times its size"
            raise FlatplankError(what, self.name, "this is no recording: do not use the file")

    def zstd(self, data: bytes, size: int | None = None) -> bytes:
        """Unpack zstd data of an expected size. Raises DamagedError."""
        limit = self._limit(size)
        try:
            stream = zstandard.ZstdDecompressor().stream_reader(data, read_across_frames=True)
            out = stream.read(limit + 1)
        except (zstandard.ZstdError, MemoryError) as error:
            raise DamagedError(f"zstd: {error}") from None
        return self._checked(out, limit, size)

    def lz4(self, data: bytes, size: int | None = None) -> bytes:
        """Unpack an lz4 frame of an expected size. Raises DamagedError."""
        return self._streamed("lz4", lz4.frame.LZ4FrameDecompressor(), data, size)

    def bz2(self, data: bytes, size: int | None = None) -> bytes:
        """Unpack bz2 data of an expected size. Raises DamagedError."""
        return self._streamed("bz2", bz2.BZ2Decompressor(), data, size)

    def _streamed(self, name: str, stream: Any, data: bytes, size: int | None) -> bytes:
        """Unpack with a decompressor of one stream, no more than the budget allows."""
        limit = self._limit(size)
        try:
            out = stream.decompress(data, max_length=limit + 1)
        except (RuntimeError, OSError, EOFError, MemoryError) as error:
            raise DamagedError(f"{name}: {error}") from None
        if not stream.eof and len(out) <= limit:
            raise DamagedError(f"{name}: it has no end")
        return self._checked(out, limit, size)

    def _limit(self, size: int | None) -> int:
        return min(self.left, PIECE, PIECE if size is None else size)

    def _checked(self, out: bytes, limit: int, size: int | None) -> bytes:
        if size is not None and len(out) != size and len(out) <= self.left:
            raise DamagedError("it does not unpack to its size")
        self.take(len(out) if len(out) <= limit else self.left + 1)
        return out
