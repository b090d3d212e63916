# SPDX-License-Identifier: Apache-2.0
"""Numbers of curves that repeat each other: their scatter, and what lies between two campaigns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

STEPS = 300
"""places at which curves are compared"""


def scatter(curves: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """rms difference of every curve from the mean of its condition, in the unit of the curves."""
    out = []
    for label, members in _by_condition(curves).items():
        if len(members) < 2:
            continue
        _, values = _together(members)
        rest = values - values.mean(axis=0)
        spread = float(np.sqrt(np.sum(rest**2) / ((len(members) - 1) * rest.shape[1])))
        out.append({"condition": label, "runs": len(members), "scatter": spread})
    return out


def differences(
    curves: Sequence[dict[str, Any]], others: Sequence[dict[str, Any]]
) -> list[dict[str, Any]]:
    """Of each condition of both: mean of `others` minus mean of `curves` where all of them are
    measured, as points and as an rms value, in the unit of the curves."""
    mine, theirs = _by_condition(curves), _by_condition(others)
    out = []
    for label in (label for label in mine if label in theirs):
        grid, values = _together([*mine[label], *theirs[label]])
        first = len(mine[label])
        rest = values[first:].mean(axis=0) - values[:first].mean(axis=0)
        rms = float(np.sqrt(np.mean(rest**2)))
        out.append({"condition": label, "points": np.stack([grid, rest], axis=1), "rms": rms})
    return out


def _by_condition(curves: Sequence[dict[str, Any]]) -> dict[str, list[np.ndarray]]:
    groups: dict[str, list[np.ndarray]] = {}
    for curve in curves:
        groups.setdefault(curve["condition"], []).append(curve["points"])
    return groups


def _together(members: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Abscissa that all members share, and their values at it; shapes (n,) and (members, n)."""
    low = max(float(m[0, 0]) for m in members)
    high = min(float(m[-1, 0]) for m in members)
    grid = np.linspace(low, high, STEPS)
    return grid, np.stack([np.interp(grid, m[:, 0], m[:, 1]) for m in members])
