# SPDX-License-Identifier: Apache-2.0
"""Campaigns that nobody has measured."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import yaml


def campaign(
    folder: Path,
    scatter: float = 0.0,
    pull: float = 120.0,
    repeats: int = 3,
    rate: float = 50.0,
) -> Path:
    """A small made-up campaign: relaxation of first order, three slips, repeats whose forces
    differ by the share `scatter`, and a pull [N] at one place that no library has; `rate` of the
    samples [Hz]."""
    folder.mkdir(parents=True)
    rng, runs = np.random.default_rng(3), []
    t = np.arange(0.0, 4.1 / 0.03092, 1.0 / rate)
    x = 0.03092 * t
    for kappa in (-0.05, 0.02, 0.05):
        for start in range(1, repeats + 1):
            fx = 40_000 * kappa * (1 - np.exp(-np.clip(x - 1.5, 0, None) / 0.4)) * (x > 1.5)
            rolled = x + kappa * np.clip(x - 1.5, 0, None)
            # a pull at one place of the plank, in no library
            fx += pull * np.clip(1 - abs(x - 2.4) / 0.3, 0, None)
            name = f"TOY_REL_LNG_{100 * kappa:g}perc_T_p25_Fz3700_{start}.parquet"
            columns = {
                "time": t, "plank_position": x, "plank_velocity": np.full_like(t, 0.03092),
                "wheel_angle": rolled / 0.31,
                "wheel_velocity": np.gradient(rolled, t) / 0.31,
                "fx": (1 + scatter * (start - 2)) * fx + rng.normal(0, 15, len(t)),
                "fz": np.full_like(t, 3700.0),
            }  # fmt: skip
            pq.write_table(pa.table(columns), folder / name)
            runs.append(
                {"file": name, "tire": "TOY", "kappa": kappa, "fz": 3700.0, "pressure": 2.5,
                 "start": start, "run_index": len(runs), "step_position": 1.5,
                 "effective_rolling_radius": 0.31, "notes": "<b>made up</b>"}
            )  # fmt: skip
    head = {"format": "flatplank-measurement-table/1", "tire": "TOY", "runs": runs}
    (folder / "campaign.yaml").write_text(yaml.safe_dump(head))
    return folder
