# SPDX-License-Identifier: Apache-2.0
"""Where a tire file fails: its error per condition beside the floor, and over the slip."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.models.magic_formula import steady_forces
from flatplank_analysis.models.tir import TirFile
from flatplank_analysis.slip_sweeps.conditions import FORCE, Condition
from flatplank_analysis.slip_sweeps.curves import Curve


@dataclass(frozen=True)
class Failure:
    """One condition by one tire file."""

    error: float
    """root mean square of the mean curve [N]"""
    share: float
    """of the largest force of the condition [-]"""
    modelled: np.ndarray
    """the file's force in the bins of the curve [N]"""
    worst_slip: float
    """where it is off most [rad, -]"""
    worst: float
    """measured minus modelled there [N]"""


def failures(
    columns: Mapping[str, np.ndarray],
    conditions: Sequence[Condition],
    curves: Sequence[Curve],
    tir: TirFile,
) -> list[Failure]:
    """One for each condition; the file is asked at every sample, then averaged as the force."""
    found = []
    for condition, curve in zip(conditions, curves, strict=True):
        rows = condition.samples
        get = {
            name: columns[name][rows] if name in columns else 0.0
            for name in ("kappa", "alpha", "gamma")
        }
        pressure = columns["pressure"][rows] if "pressure" in columns else None
        speed = np.abs(columns["speed"][rows]) if "speed" in columns else 1.0
        forces = steady_forces(
            tir.coefficients, columns["fz"][rows], **get, pressure=pressure,
            vx=np.maximum(speed, 0.01),
        )  # fmt: skip
        modelled = forces[{"fx": 0, "fy": 1}[FORCE[condition.swept]]]
        found.append(_failure(columns, condition, curve, modelled))
    return found


def _failure(columns, condition: Condition, curve: Curve, modelled: np.ndarray) -> Failure:
    slip = columns[condition.swept][condition.samples]
    middle = 0.5 * (curve.slip[1:] + curve.slip[:-1])
    bins = np.digitize(slip, middle)
    count = np.bincount(bins, minlength=len(curve.slip))
    mean = np.bincount(bins, modelled, minlength=len(curve.slip)) / np.maximum(count, 1)
    off = np.where(np.isfinite(curve.force), curve.force - mean, np.nan)
    at = int(np.nanargmax(np.abs(off)))
    error = float(np.sqrt(np.nanmean(off**2)))
    return Failure(
        error,
        error / float(np.nanmax(np.abs(curve.force))),
        np.where(np.isfinite(curve.force), mean, np.nan),
        float(curve.slip[at]),
        float(off[at]),
    )
