# SPDX-License-Identifier: Apache-2.0
"""Where the numbers of a page come from: runs, tires, days, benches, programs."""

from __future__ import annotations

from collections.abc import Iterable
from importlib.metadata import version

from flatplank_data.run_record import RunRecord


def provenance(records: Iterable[RunRecord]) -> str:
    """Sentences for the foot of a page; what no record states is left out."""
    every = list(records)
    days = sorted({day for r in every if (day := (r.started or r.date)[:10])})
    said = [f"{len(every)} runs" if len(every) != 1 else "1 run"]
    if tires := _distinct(r.tire for r in every):
        said.append(f"of {tires}")
    if days:
        said.append(f"measured {days[0]}" + (f" to {days[-1]}" if len(days) > 1 else ""))
    if benches := _distinct(r.software_version for r in every):
        said.append(f"with flatplank_control {benches}")
    seeds = {str((r.plant or {}).get("seed", "")) for r in every} - {""}
    if any(r.plant for r in every):
        said.append("on a simulated bench" + (f", seed {min(seeds)}" if len(seeds) == 1 else ""))
    return f"{' '.join(said)}. Evaluated with flatplank_analysis {version('flatplank_analysis')}."


def _distinct(values: Iterable[str], most: int = 3) -> str:
    """The distinct values, in order; the number of the others behind `most`."""
    found = [v for v in dict.fromkeys(values) if v]
    more = f" and {len(found) - most} more" if len(found) > most else ""
    return ", ".join(found[:most]) + more
