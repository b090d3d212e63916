# SPDX-License-Identifier: Apache-2.0
"""Where the numbers of a page come from: runs, tires, days, benches, programs."""

from __future__ import annotations

from collections.abc import Iterable
from importlib.metadata import version

from flatplank_data.run_record import RunRecord


def provenance(records: Iterable[RunRecord], counted: str = "") -> str:
    """Sentences for the foot of a page; what no record states is left out.

    counted: what was evaluated, where there are no records of runs.
    """
    every = list(records)
    said = [counted or (f"{len(every)} runs" if len(every) != 1 else "1 run")]
    if tires := _distinct(r.tire for r in every):
        said.append(f"of {tires}")
    if benches := _distinct(_bench(r) for r in every):
        said.append(f"on {benches}{_seeds(every)}")
    if days := sorted({day for r in every if (day := r.day)}):
        said.append(f"measured {days[0]}" + (f" to {days[-1]}" if len(days) > 1 else ""))
    if versions := _distinct(r.software_version for r in every):
        said.append(f"with flatplank_control {versions}")
    return f"{' '.join(said)}. Evaluated with flatplank_analysis {version('flatplank_analysis')}."


def _bench(record: RunRecord) -> str:
    """The bench of a run as a noun; empty when its record names none."""
    if not record.plant or "bench" in record.extra:
        return f"the bench {record.bench}" if record.bench else ""
    preset = str(record.plant.get("preset") or "")
    return "the simulated bench" + (f" with the preset {preset}" if preset else "")


def _seeds(records: Iterable[RunRecord]) -> str:
    """Seeds of the simulated bench in brackets: every run has its own."""
    seeds = sorted({int(s) for r in records if (s := (r.plant or {}).get("seed")) is not None})
    if not seeds:
        return ""
    return f" (seed {seeds[0]})" if len(seeds) == 1 else f" (seeds {seeds[0]} to {seeds[-1]})"


def _distinct(values: Iterable[str], most: int = 3) -> str:
    """The distinct values, in order; the number of the others behind `most`."""
    found = [v for v in dict.fromkeys(values) if v]
    more = f" and {len(found) - most} more" if len(found) > most else ""
    return ", ".join(found[:most]) + more
