# SPDX-License-Identifier: Apache-2.0
"""`campaign.yaml` beside the data: the runs that count, the same from the twin and the graph."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import yaml

from flatplank_analysis.data.campaign import CAMPAIGN_FILE, FORMAT
from flatplank_control.recording.metadata import replace_text
from flatplank_control.runner.campaign.conductor import Conductor
from flatplank_control.runner.measurement import Measurement

_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_DUMPER = getattr(yaml, "CSafeDumper", yaml.SafeDumper)


def list_kept(conductor: Conductor, folder: Path) -> None:
    """List what the journal kept; a crash between the two is made up at the next start."""
    if kept := conductor.kept():
        write_campaign(folder, [(m, folder / file) for m, file in kept])


def write_campaign(folder: Path, runs: Sequence[tuple[Measurement, Path]]) -> None:
    """Add runs to the folder's campaign.yaml."""
    path = folder / CAMPAIGN_FILE
    old = yaml.load(path.read_text(encoding="utf-8"), Loader=_LOADER) if path.exists() else {}
    names = {p.name for _, p in runs}
    kept = [run for run in old.get("runs", []) if run["file"] not in names]
    new = [_entry(m, p) for m, p in runs]
    content = {"format": FORMAT, "tire": runs[0][0].tire, "runs": [*kept, *new]}
    replace_text(path, yaml.dump(content, Dumper=_DUMPER, sort_keys=False))


def _entry(m: Measurement, path: Path) -> dict:
    record = {k: v for k, v in m.record().items() if v not in (None, "", {}) and k != "name"}
    return {"file": path.name, **record}
