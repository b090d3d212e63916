# SPDX-License-Identifier: Apache-2.0
"""The catalogue as an object: select runs, open their campaigns, chart the reference tire."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pyarrow as pa
import pyarrow.compute as pc

from flatplank_analysis.catalogues.conditions import keeps
from flatplank_analysis.catalogues.kept import stored
from flatplank_data.run_record import UNITS

if TYPE_CHECKING:
    import pandas as pd

    from flatplank_analysis.report.analysis import Progress
    from flatplank_data.campaign import Campaign


@dataclasses.dataclass(frozen=True)
class Catalogue:
    """Runs below a folder; `table`: a run per row, in Arrow; its fields have their units."""

    root: Path
    table: pa.Table

    @cached_property
    def rows(self) -> pd.DataFrame:
        """The runs as a pandas table, units in its `attrs`."""
        rows = self.table.to_pandas(use_threads=False)
        rows.attrs["units"] = {name: UNITS[name] for name in rows if name in UNITS}
        return rows

    def where(self, **conditions: Any) -> Catalogue:
        """The runs that fulfil all conditions: `tire="TOY", pressure=2.5, since="2026-05-01"`.

        Names are those of `conditions.CONDITIONS`. Numbers are levels (bar, N, %, deg), or texts
        with another unit or a range, as "36psi", "3000..4000".

        Raises:
            FlatplankError: an unknown name, or a value that cannot be read.
        """
        table = self.table
        for name, wanted in conditions.items():
            table = table.filter(keeps(name, wanted)(table))
        return Catalogue(self.root, table)

    @property
    def usable(self) -> Catalogue:
        """The runs that can be used."""
        return Catalogue(self.root, self.table.filter(pc.is_valid(self.table["kind"])))

    @property
    def unusable(self) -> Catalogue:
        """The files that cannot be used; column `error` says why."""
        return Catalogue(self.root, self.table.filter(pc.is_valid(self.table["error"])))

    def campaigns(self) -> Iterator[Campaign]:
        """The campaigns of the rows, each with the runs of the rows alone."""
        from flatplank_data.campaign import Campaign

        usable = self.usable.table
        files: dict[str, set[str]] = {}
        for folder, file in zip(*(usable[k].to_pylist() for k in ("folder", "file")), strict=True):
            files.setdefault(folder, set()).add(file)
        for folder in sorted(files):
            whole = Campaign.load(self.root / folder)
            own = [r for r in whole.runs if r.info.file in files[folder]]
            yield dataclasses.replace(whole, runs=own)

    def __len__(self) -> int:
        return self.table.num_rows

    def __repr__(self) -> str:
        folders = pc.count_distinct(self.table["folder"])
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
    found = None if update else stored(root)
    if found is None:
        from flatplank_analysis.catalogues.build import updated

        found = updated(root, jobs=jobs, progress=progress)
    return Catalogue(Path(root), found.table)
