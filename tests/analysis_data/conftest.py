# SPDX-License-Identifier: Apache-2.0
"""Campaigns of runs with a known answer."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from steptable import step_table

from flatplank_data.exporters import export_campaign


@pytest.fixture
def make_step():
    return step_table


@pytest.fixture
def write_campaign(tmp_path):
    """Write tables as a campaign; returns the folder."""

    def write(tables, suffix: str = ".parquet", name: str = "campaign") -> Path:
        return export_campaign(tables, tmp_path / name, suffix)

    return write


@pytest.fixture
def edit_campaign():
    """Change the entry of one run in campaign.yaml."""

    def edit(folder: Path, index: int, **changes) -> None:
        path = folder / "campaign.yaml"
        content = yaml.safe_load(path.read_text())
        content["runs"][index].update(changes)
        path.write_text(yaml.safe_dump(content))

    return edit
