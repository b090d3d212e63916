# SPDX-License-Identifier: Apache-2.0
"""The rows of one campaign folder: its run records, their quality, the verdict on the campaign."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

from flatplank_analysis.catalogues.kept import OF_THE_RECORD
from flatplank_data.campaign import Campaign
from flatplank_data.condition import is_nan
from flatplank_data.errors import FlatplankError
from flatplank_data.files import read_text
from flatplank_data.folders import verdicts
from flatplank_data.run_record import RunRecord

Row = Mapping[str, Any]
DIAGNOSIS = "diagnosis.json"
"""what `diagnose DIR --out DIR/diagnosis.json` writes"""


def rows_of(root: str, folder: str) -> list[Row]:
    """One row per run; a file that cannot be used is a row with its error."""
    path = Path(root, folder)
    try:
        campaign = Campaign.load(path)
        judged = verdicts(campaign)
    except (OSError, ValueError) as error:
        return [{"folder": folder, "file": "", "error": str(error)}]
    diagnosis = diagnosis_in(path)
    rows: list[Row] = [
        {"folder": folder, "quality": judged[info.file], **diagnosis, **_of_record(info)}
        for info in campaign.infos
    ]
    return rows + list(_unusable(campaign, folder))


def _of_record(info: RunRecord) -> Row:
    own = {key: getattr(info, key) for key in OF_THE_RECORD}
    known = {key: value for key, value in own.items() if not is_nan(value)}
    return known | {
        "file": info.file, "kind": info.kind, "date": _iso(info.date or info.started),
        "bench": info.bench,
    }  # fmt: skip


def _unusable(campaign: Campaign, folder: str) -> Iterator[Row]:
    for problem in campaign.problems:
        if problem.fatal or problem.left_out:
            yield {"folder": folder, "file": problem.file, "error": str(problem)}


def _iso(text: str) -> str:
    try:
        return datetime.fromisoformat(str(text).replace("Z", "+00:00")).isoformat()
    except ValueError:
        return ""


def diagnosis_in(folder: Path) -> Row:
    """Verdict and effects of the diagnosis beside a campaign; a damaged one is named as such."""
    path = folder / DIAGNOSIS
    if not path.is_file():
        return {}
    try:
        found = json.loads(read_text(path))
        names = [effect["name"] for effect in found.get("effects") or ()]
        return {"verdict": str(found["verdict"]), "effects": ", ".join(map(str, names))}
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        damaged = FlatplankError("no diagnosis", str(path), "make it again by flatplank diagnose")
        return {"verdict": "", "error": f"{damaged} ({error or type(error).__name__})"}
