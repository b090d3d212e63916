# SPDX-License-Identifier: Apache-2.0
"""Damages files as disks, cables and copies do; seeded."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np


def flipped(data: bytearray, rng: np.random.Generator) -> None:
    for at in rng.integers(len(data), size=int(rng.integers(1, 4))):
        data[at] ^= 1 << int(rng.integers(8))


def cut(data: bytearray, rng: np.random.Generator) -> None:
    del data[int(rng.integers(len(data))) :]


def replaced(data: bytearray, rng: np.random.Generator) -> None:
    at, size = int(rng.integers(len(data))), int(rng.integers(1, 600))
    data[at : at + size] = rng.bytes(len(data[at : at + size]))


def zeroed(data: bytearray, rng: np.random.Generator) -> None:
    at, size = int(rng.integers(len(data))), int(rng.integers(1, 5000))
    data[at : at + size] = bytes(len(data[at : at + size]))


def removed(data: bytearray, rng: np.random.Generator) -> None:
    at = int(rng.integers(len(data)))
    del data[at : at + int(rng.integers(1, 3000))]


def repeated(data: bytearray, rng: np.random.Generator) -> None:
    at = int(rng.integers(len(data)))
    data[at:at] = data[at : at + int(rng.integers(1, 3000))]


def numbered(data: bytearray, rng: np.random.Generator) -> None:
    """A wrong number, as lengths and counts are stored."""
    at, width = int(rng.integers(max(len(data) - 8, 1))), int(rng.choice([1, 2, 4, 8]))
    value = int(rng.choice([0, 1, 255, 2**15, 2**31, 2**32 - 1, 2**62, 2**64 - 1]))
    data[at : at + width] = (value % 256**width).to_bytes(width, "little")


def at_the_end(data: bytearray, rng: np.random.Generator) -> None:
    """Summaries, footers and directories lie there."""
    at = len(data) - 1 - int(rng.integers(min(len(data), 1500)))
    data[at] ^= 1 << int(rng.integers(8))


KINDS = (flipped, cut, replaced, zeroed, removed, repeated, numbered, at_the_end)


def damaged(data: bytes, count: int, seed: int) -> Iterator[tuple[str, bytes]]:
    """`count` damaged copies of a file, each with its kind and seed."""
    for number in range(count):
        rng = np.random.default_rng([seed, number])
        kind = KINDS[number % len(KINDS)]
        copy = bytearray(data)
        kind(copy, rng)
        yield f"{kind.__name__}, seed {[seed, number]}", bytes(copy)
