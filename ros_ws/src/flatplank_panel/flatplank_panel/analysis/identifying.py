# SPDX-License-Identifier: Apache-2.0
"""The parasitic signal of a mounting, from a recorded run of the unloaded wheel."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from flatplank_control.calibration.parasitic import identify_turn, turn_of_bag
from flatplank_data.run_record import FILE_NAME

Progress = Callable[[str, float], None]
KIND = "\nmeasurement: unloaded_turn\n"


def turns(_progress: Progress, root: str) -> list[str]:
    """Bags below `root` whose record says that the wheel was turned without load."""
    base = Path(root)
    return [
        str(record.parent.relative_to(base))
        for record in sorted(base.rglob(FILE_NAME))
        if KIND in record.read_text(encoding="utf-8")
    ]


def identify(
    _progress: Progress, root: str, bag: str, mounting: str, date: str, target: str
) -> dict[str, Any]:
    """Write the fit of a mounting to `target`; `left`: once-per-turn force before, after [N]."""
    if bag not in turns(_progress, root):
        raise ValueError(f"{bag}: not a run of three unloaded turns; choose one of the list")
    turn = turn_of_bag(Path(root) / bag)
    return {"left": identify_turn(turn, mounting, date, Path(target))}
