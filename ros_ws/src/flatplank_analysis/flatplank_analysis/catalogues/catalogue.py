# SPDX-License-Identifier: Apache-2.0
"""The catalogue as an object: select runs, open their campaigns, chart the reference tire."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pandas as pd

from flatplank_analysis.catalogues import build
from flatplank_analysis.catalogues.conditions import keeps
from flatplank_analysis.report.analysis import Progress
from flatplank_data.campaign import Campaign
from flatplank_data.run_record import UNITS


@dataclasses.dataclass(frozen=True)
class Catalogue:
    """Runs below a folder; `rows`: a pandas table with a run per row, units in its `attrs`."""

    root: Path
    rows: pd.DataFrame

    def where(self, **conditions: Any) -> Catalogue:
        """The runs that fulfil all conditions: `tire="TOY", pressure=2.5, since="2026-05-01"`.

        Names are those of `conditions.CONDITIONS`. Numbers are levels (bar, N, %, deg), or texts
        with another unit or a range, as "36psi", "3000..4000".

        Raises:
            FlatplankError: an unknown name, or a value that cannot be read.
        """
        rows = self.rows
        for name, wanted in conditions.items():
            rows = rows[keeps(name, wanted)(rows)]
        return dataclasses.replace(self, rows=rows)

    @property
    def unusable(self) -> Catalogue:
        """The files that cannot be used; column `error` says why."""
        return dataclasses.replace(self, rows=self.rows[self.rows["error"].notna()])

    def campaigns(self) -> Iterator[Campaign]:
        """The campaigns of the rows, each with the runs of the rows alone."""
        usable = self.rows[self.rows["kind"].notna()]
        for folder, rows in usable.groupby("folder"):
            whole, files = Campaign.load(self.root / str(folder)), set(rows["file"])
            yield dataclasses.replace(whole, runs=[r for r in whole.runs if r.info.file in files])

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        folders = self.rows["folder"].nunique()
        return f"{self.root}: {len(self)} runs in {folders} folders"


def catalogue(
    root: str | os.PathLike[str],
    update: bool = True,
    jobs: int | None = 1,
    progress: Progress | None = None,
) -> Catalogue:
    """The runs of all campaigns below `root`, with their quality and the verdicts of diagnoses.

    update: look for what changed since the catalogue was kept; False: as it was kept. Raises
    FlatplankError when `root` is no folder.
    """
    kept = None if update else build.stored(root)
    return of(root, kept or build.updated(root, jobs=jobs, progress=progress))


def of(root: str | os.PathLike[str], found: build.Update) -> Catalogue:
    """The object of a catalogue that was read."""
    rows = found.table.to_pandas()
    rows.attrs["units"] = {name: UNITS[name] for name in rows if name in UNITS}
    return Catalogue(Path(root), rows)
