# SPDX-License-Identifier: Apache-2.0
"""Conditions and runs of a campaign with a hidden effect."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

LOAD, PRESSURE, STEP = 3700.0, 2.5, 1.5
"""vertical force [N], inflation pressure [bar], plank position of the slip step [m]"""
Columns = dict[str, np.ndarray]
"""name -> one value per sample"""


@dataclass(frozen=True)
class Setting:
    """One condition."""

    kappa: float
    fz: float = LOAD
    pressure: float = PRESSURE
    alpha_deg: float = 0.0
    gamma_deg: float = 0.0


@dataclass(frozen=True)
class Run:
    """One run of a campaign."""

    setting: Setting
    start: int
    index: int
