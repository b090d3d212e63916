# SPDX-License-Identifier: Apache-2.0
"""The job of the control charts of the page Catalogue."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from flatplank_analysis.catalogues.catalogue import Catalogue
from flatplank_analysis.catalogues.chart import charted
from flatplank_analysis.catalogues.conditions import conditions_in
from flatplank_analysis.figures.other import control_charts
from flatplank_analysis.report_files.build import write
from flatplank_data.progress import Progress
from flatplank_panel.analysis.catalogue_jobs import held_catalogue


def reference_chart(progress: Progress, root: str, where: str, target: str) -> dict[str, Any]:
    """Write the page of the control charts to the folder `target`; the page, and the figures as
    SVG with title and caption."""
    conditions = conditions_in(where)
    runs = Catalogue(Path(root), held_catalogue(progress, root).update.table).where(**conditions)
    progress("reading the runs", 0.0)
    result = charted(
        runs,
        progress=lambda done, total, name: progress(
            f"session {done} of {total}: {name}", done / total
        ),
    )
    page = write(result, target)
    figures = [
        {"title": f.title, "caption": f.caption,
         "svg": (Path(target) / "figures" / f"{f.name}.svg").read_text(encoding="utf-8")}
        for f in control_charts(result)
    ]  # fmt: skip
    return {"page": str(page), "figures": figures}
