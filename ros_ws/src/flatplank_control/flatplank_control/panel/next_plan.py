# SPDX-License-Identifier: Apache-2.0
"""The proposed next run as a plan that the bench can make."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from flatplank_control.runner.campaign import load_plan
from flatplank_control.runner.campaign.plan import OF_A_RUN


def write_next(proposal: Mapping[str, Any], tire: str, data: Path) -> Path:
    """A checked plan file in DATA/plans; ValueError when the bench cannot make the run."""
    settings = dict(proposal.get("settings") or {})
    run = {k: v for k, v in settings.items() if k in OF_A_RUN}
    if not run:
        raise ValueError("the proposal names no run that the bench can make")
    run["repeats"] = int(proposal.get("repeats") or 3)
    plan = {"format": "flatplank-plan/1", "name": "next_run", "tire": tire or "TOY", "runs": [run]}
    if "measurement" not in run:
        run["measurement"] = "slip"
    folder = data / "plans"
    folder.mkdir(exist_ok=True)
    path = folder / "next_run.yaml"
    text = f"# {proposal.get('what', '')}\n".replace("\r", " ")
    path.write_text(text + yaml.safe_dump(plan, sort_keys=False), encoding="utf-8")
    try:
        load_plan(path)
    except ValueError:
        path.unlink()
        raise
    return path
