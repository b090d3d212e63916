# SPDX-License-Identifier: Apache-2.0
"""Runs with a known response, for the tests of the fits."""

from __future__ import annotations

import numpy as np

from flatplank_analysis.identify.runs import StepRun

X = np.arange(-0.0995, 2.5, 0.001)


def numbers(seed: int, *size: int) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal(size)


def run(kappa: float = 0.02, start: int = 1, fx=None, name: str = "r", **more) -> StepRun:
    """A slip step with an exponential Fx; 900 N per hundredth of slip, 0.4 m."""
    x = more.pop("distance", X)
    fx = 9e4 * kappa * -np.expm1(-np.maximum(x, 0.0) / 0.4) if fx is None else fx
    zero = np.zeros_like(x)
    slip = kappa * np.maximum(x, 0.0)
    columns = {"fy": zero, "mz": zero, "fz": zero + 3700.0, "slip": slip}
    columns |= {k: more.pop(k) for k in columns if k in more}
    return StepRun(name, "one", kappa, kappa, x, fx, start=start, **columns, **more)
