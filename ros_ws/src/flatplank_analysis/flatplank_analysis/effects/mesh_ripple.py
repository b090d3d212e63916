# SPDX-License-Identifier: Apache-2.0
"""Speed ripple of rack and pinion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.contact_patch.grid import FILTER, SPEED
from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.base import Motion, TireEffect
from flatplank_analysis.effects.waves import periods

SHORTEST = 80.0
"""[1/m] waves per travel: a tooth of the bench has 64, the nodes of a run resolve 83"""


@dataclass(frozen=True)
class MeshRipple(TireEffect):
    """The plank runs ahead and back with the period of a tooth or a pinion turn; the encoder
    on the pinion does not see it.
    """

    identifier = "mesh_ripple"
    title = "Speed ripple of rack and pinion"
    kind = "machine"
    coordinate = "plank position"
    source = "thesis 3.1; the plank encoder sits on the pinion"
    what = (
        "Tooth errors and an eccentric pinion move the plank ahead and back while the pinion "
        "turns evenly. It is the same in every run, at zero slip too."
    )
    check = (
        "Second encoder on the plank, or the force of a run at zero slip: 200 N per mm. The "
        "period is a tooth or a turn of the pinion."
    )
    removes = "New pinion or rack; or the position of the plank from its own encoder."

    cos: float = param(0.0, unit="m", bounds=(-2e-3, 2e-3), screen=5e-5, matters=2e-5)
    sin: float = param(0.0, unit="m", bounds=(-2e-3, 2e-3), screen=5e-5, matters=2e-5)
    period: float = param(0.1, unit="m", bounds=(1.0 / SHORTEST, 1.2), note="in plank travel")

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        return [{"period": p} for p in periods(runs, residual, 1.0 / SHORTEST, 1.2)]

    @classmethod
    def scanned(cls, runs: RunSet) -> int:
        return 530

    @classmethod
    def size(cls, values: dict[str, float]) -> float:
        return float(np.hypot(values["cos"], values["sin"]))

    def motion(self, motion: Motion) -> None:
        phase = 2.0 * np.pi * motion.data.position / self.period
        # the measured motion went through the filter, so this one must too
        damp = np.exp(-0.5 * (2.0 * np.pi * FILTER * SPEED / self.period) ** 2)
        wave = self.cos * (np.cos(phase) - 1.0) + self.sin * np.sin(phase)
        wave = damp * wave
        motion.travel += np.diff(wave, axis=-1, prepend=wave[..., :1])
