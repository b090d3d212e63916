# SPDX-License-Identifier: Apache-2.0
"""`campaign.yaml` and `tire.yaml` beside the data, the same from the twin and the graph."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from flatplank_analysis.models.tire_record import FILE as RECORD
from flatplank_analysis.models.tire_record import TireRecord
from flatplank_control.runner.campaign.conductor import Conductor
from flatplank_data.campaign import CAMPAIGN_FILE, FORMAT
from flatplank_data.files import write_atomic
from flatplank_data.yaml_text import load_yaml

_DUMPER = getattr(yaml, "CSafeDumper", yaml.SafeDumper)


def list_kept(conductor: Conductor, folder: Path) -> None:
    """List what the journal kept; a crash between the two is made up at the next start."""
    kept = conductor.kept()
    counting = {done.counts for done in kept}
    others = {file for done in conductor.journal.done.values() for file in done.files} - counting
    if kept or (folder / CAMPAIGN_FILE).exists():
        write_tire(folder, conductor.plan.tire.record)
        runs = [(done.record, done.counts) for done in kept if done.record]
        write_campaign(folder, conductor.plan.tire.name, runs, others)


def write_tire(folder: Path, record: TireRecord) -> None:
    """The record of the mounted tire beside the runs; one that is there stays."""
    path = folder / RECORD
    if not path.exists():
        write_atomic(path, record.to_yaml())


def write_campaign(
    folder: Path,
    tire: str,
    runs: Sequence[tuple[Mapping[str, Any], str]],
    others: Collection[str] = (),
) -> None:
    """Put records and files of runs into the folder's campaign.yaml, and take `others` out."""
    path = folder / CAMPAIGN_FILE
    old = load_yaml(path.read_bytes(), path) if path.exists() else {}
    names = {file for _, file in runs}.union(others)
    kept = [run for run in old.get("runs", []) if run["file"] not in names]
    new = [_entry(record, file) for record, file in runs]
    content = {"format": FORMAT, "tire": tire, "runs": [*kept, *new]}
    write_atomic(path, yaml.dump(content, Dumper=_DUMPER, sort_keys=False))


def _entry(record: Mapping[str, Any], file: str) -> dict:
    said = {k: v for k, v in record.items() if v not in (None, "", {}) and k != "name"}
    return {"file": file, **said}
