# SPDX-License-Identifier: Apache-2.0
"""A campaign on the twin, with something hidden in it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from flatplank_control.bench.simulator import simulator

Progress = Callable[[str, float], None]


def simulate(progress: Progress, folder: str, seed: int) -> dict[str, Any]:
    """Nine slips from three starts in a new folder; the answer lies in it, sealed."""
    progress("simulating the first run", 0.0)
    simulator().make_challenge(
        Path(folder), seed, lambda k, n, _name: progress(f"run {k} of {n} simulated", k / n)
    )
    return {"folder": folder}
