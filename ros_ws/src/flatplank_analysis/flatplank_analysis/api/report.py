# SPDX-License-Identifier: Apache-2.0
"""The report of a table of runs."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from flatplank_analysis.api.runs import campaign_of, warn

if TYPE_CHECKING:
    import pandas as pd


def write_report(
    runs: pd.DataFrame,
    folder: str | os.PathLike[str],
    tire: str | os.PathLike[str] | None = None,
) -> Path:
    """Write the page of `flatplank report` with its figures and tables; returns the page.

    tire: a tire record; None: `tire.yaml` of the campaign, or made from the data.
    """
    from flatplank_analysis.report_files.build import build

    campaign = campaign_of(runs)
    page = build(campaign, folder, tire=tire)
    warn(campaign.problems)
    return page
