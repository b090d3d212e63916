# SPDX-License-Identifier: Apache-2.0
"""What all effects that are forces over the wheel angle have in common."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import TireEffect


@dataclass(frozen=True)
class TurningForce(TireEffect):
    """Forces in x and z that wave over the wheel angle; the size is the amplitude in x."""

    coordinate = "wheel angle"
    main = "fx_cos"

    fx_cos: float = param(0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0, matters=5.0)
    fx_sin: float = param(0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0, matters=5.0)
    fz_cos: float = param(0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0)
    fz_sin: float = param(0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0)

    @classmethod
    def size(cls, values: dict[str, float]) -> float:
        return float(np.hypot(values["fx_cos"], values["fx_sin"]))
