# SPDX-License-Identifier: Apache-2.0
"""When the runs of a campaign last changed: what is read stays good until then."""

from __future__ import annotations

from pathlib import Path

from flatplank_control.runner.campaign import SUFFIX
from flatplank_data.campaign import CAMPAIGN_FILE
from flatplank_data.readers import suffixes

Stamp = tuple[tuple[str, int, int], ...]


def stamp_of(folder: str | Path) -> Stamp:
    """Name, time [ns] and size of every file of a run, inside bags too; models are not runs."""
    ends = (*suffixes(), CAMPAIGN_FILE, SUFFIX)
    base = Path(folder)
    tables = (p for p in base.iterdir() if p.name.lower().endswith(ends))
    files = [p for p in (*tables, *base.glob("*/*")) if p.is_file()]
    return tuple(sorted((str(p), p.stat().st_mtime_ns, p.stat().st_size) for p in files))
