# SPDX-License-Identifier: Apache-2.0
"""The pinions of the plank slip in the torn weld of their shaft when the tire drives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.base import Motion, TireEffect

SHARES = (0.4, 0.55, 0.7, 0.85)
"""first values of the hold, over the largest driving force of the runs"""
LEAST = 0.25
"""least driving force of runs that can show it, over their largest force"""


@dataclass(frozen=True)
class TornWeld(TireEffect):
    """The plank jumps ahead by a gap once the driving force exceeds what the crack holds."""

    identifier = "torn_weld"
    title = "Torn weld of the pinion shaft"
    coordinate = "plank position"
    source = "thesis 3.1 and 6.3: torn during the repeats, speed spike at 1.84 m (figure 6.23)"
    what = (
        "The shaft of the pinions slips in its torn weld: when the tire drives the plank hard "
        "enough, the plank jumps ahead once and the force drops. What the encoder shows of the "
        "jump is in the data already; this is what it does not show."
    )
    check = (
        "Look at the road velocity of the driving runs: a spike where the force drops. Hold the "
        "worm gear and push the plank by hand; look at the weld."
    )
    removes = "A new shaft, driven by a key instead of a weld."

    gap: float = param(
        0.0, unit="m", bounds=(0.0, 8e-3), screen=3e-4, matters=1e-4,
        title="jump", symbol="δ", note="Way of the jump that the encoder does not show.",
    )  # fmt: skip
    hold: float = param(
        1500.0, unit="N", bounds=(100.0, 9000.0),
        title="holding force", symbol="F_h", note="Driving force that the crack holds.",
    )  # fmt: skip

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        most = float(runs.measured[0].max())
        return [{"hold": share * most} for share in SHARES]

    @classmethod
    def separable(cls, runs: RunSet, values: Mapping[str, float] | None = None) -> bool:
        force = runs.measured[0]
        return float(force.max()) > LEAST * float(np.abs(force).max())

    @classmethod
    def scanned(cls, runs: RunSet) -> int:
        return len(SHARES)

    def motion(self, motion: Motion) -> None:
        # the shaft jumps as fast as it unwinds: within one sample, as far as these runs can tell
        data = motion.data
        begin = crossings(data.runs.measured[0], data.position, self.hold)
        way = float(np.median(np.diff(data.position)))
        gone = np.clip((data.position - begin[..., None]) / way, 0.0, 1.0)
        motion.travel += self.gap * np.diff(gone, axis=-1, prepend=0.0)


def crossings(force: np.ndarray, position: np.ndarray, hold: np.ndarray) -> np.ndarray:
    """Plank position [m] (sets, runs) where the measured force (runs, samples) [N] first exceeds
    `hold` (sets, 1, 1); infinite where it never does."""
    levels = np.atleast_1d(np.asarray(hold, float)).reshape(-1)
    out = np.full((len(levels), len(force)), np.inf)
    for run, (f, x) in enumerate(zip(force, position, strict=True)):
        most = np.maximum.accumulate(f)
        rises = np.flatnonzero(np.diff(most, prepend=-np.inf) > 0.0)
        reached = levels <= most[-1]
        out[reached, run] = np.interp(levels[reached], most[rises], x[rises])
    return out
