# SPDX-License-Identifier: Apache-2.0
"""Bags that were closed, and whose line in the journal was never written."""

from __future__ import annotations

from pathlib import Path

from flatplank_control.runner.campaign.conductor import Job
from flatplank_control.runner.campaign.journal import Journal
from flatplank_data.run_record import FILE_NAME, load_record


def unwritten(folder: Path, job: Job, journal: Journal) -> Path | None:
    """The complete bag of this very run, when the journal does not know it."""
    written = {name for done in journal.done.values() for name in done.files}
    for path in sorted(folder.glob(f"{job.measurement.name}*")):
        if path.name in written or not (path / FILE_NAME).exists():
            continue
        record = load_record(path)
        if record.status == "complete" and record.run_index == job.measurement.run_index:
            return path
    return None
