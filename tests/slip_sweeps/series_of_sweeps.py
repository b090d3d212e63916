# SPDX-License-Identifier: Apache-2.0
"""Files with generated series of sweeps, and the tire file that has nothing hidden."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path

from flatplank_validation.sweep_sets.brush import BASE, Brush, Plan, sweeps, text_of


def series_in(folder: Path, brushes: Mapping[str, tuple[Brush, int]]) -> Path:
    """The folder, with `tire.tir` and a `NAME.csv` per name: that of a brush and a seed."""
    shutil.copy(BASE, folder / "tire.tir")
    for name, (brush, seed) in brushes.items():
        text = text_of(sweeps(brush, Plan(), seed))
        (folder / f"{name}.csv").write_text(text, encoding="utf-8")
    return folder
