# SPDX-License-Identifier: Apache-2.0
"""Judges a reader by damaged files: refused in one line, or what an independent reader has."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from flatplank_data.errors import FlatplankError
from flatplank_validation.trust.files.damage import damaged
from flatplank_validation.trust.registry import Options, Tally

Damage = Callable[[bytes, int, int], Iterator[tuple[str, bytes]]]
"""whole file, number and seed -> damaged copies, each with what was done"""
LONGEST = 300
"""characters of a failure"""


def judged(
    o: Options,
    night: int,
    path: Path,
    read: Callable[[Path], Any],
    compare: Callable[[Any, Path], None],
    damage: Damage = damaged,
) -> Tally:
    """Damage a file as often as asked for. `compare` raises AssertionError for what is wrong."""
    out, count, whole = Tally(), o.count(night), path.read_bytes()
    for k, (what, data) in enumerate(damage(whole, count, o.seed), start=1):
        path.write_bytes(data)
        out.add(_failure(out, what, path, read, compare))
        if k % 100 == 0 or k == count:
            o.progress(k, count)
    path.write_bytes(whole)
    return out


def _failure(out: Tally, what: str, path: Path, read, compare) -> str:
    try:
        found = read(path)
    except FlatplankError as error:
        out.refused += 1
        good = error.what and error.where
        return "" if good else _line(f"{what}: refused without what or where '{error}'")
    except Exception as error:  # whatever else it is, it is the failure that is looked for
        return _line(f"{what}: {type(error).__name__}: {error}")
    try:
        compare(found, path)
    except AssertionError as error:
        return _line(f"{what}: {error}")
    return ""


def _line(text: str) -> str:
    return " ".join(text.split())[:LONGEST]


def by_numpy(damage: Callable[[bytes, np.random.Generator], bytes]) -> Damage:
    """Damage from a function of the file and a generator."""

    def copies(data: bytes, count: int, seed: int) -> Iterator[tuple[str, bytes]]:
        for k in range(count):
            yield f"seed {[seed, k]}", damage(data, np.random.default_rng([seed, k]))

    return copies
