# SPDX-License-Identifier: Apache-2.0
"""A tire file knows the sweeps that it was fitted to: what its equations have, it has taken in."""

from __future__ import annotations

import zlib
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from flatplank_tire.tir import Entry, TirFile

SECTION, KEY = "FLATPLANK_SWEEPS", "FITTED_TO"
"""where the check sums of the sweeps are; other programs ignore the section"""


def marked(tir: TirFile, paths: Iterable[str]) -> TirFile:
    """The tire file with the check sums of the files that it was fitted to."""
    entry = Entry(f"'{' '.join(map(_sum, paths))}'")
    return replace(tir, sections={**tir.sections, SECTION: {KEY: entry}})


def is_fitted_to(tir: TirFile, paths: Iterable[str]) -> bool:
    """Whether a tire file was fitted to one of these files."""
    entry = tir.sections.get(SECTION, {}).get(KEY)
    return entry is not None and any(_sum(path) in entry.value for path in paths)


def _sum(path: str) -> str:
    return f"{zlib.crc32(Path(path).read_bytes()):08x}"
