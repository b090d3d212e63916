# SPDX-License-Identifier: Apache-2.0
"""Synthetic slip-step runs from the fitted models themselves, for speed and recovery studies.

For benchmarks only, since the truth is the fitted model itself. The simulated plant and real bags
validate the models, not these runs.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from flatplank_analysis.identify.runs import StepRun
from flatplank_analysis.identify.steady_curve import curve_law, slope_weights
from flatplank_analysis.models.base import TOYO, slip_inputs, stack_runs
from flatplank_analysis.models.nonlinear import NonlinearX, TableLaw

SLIPS = (-0.10, -0.05, -0.02, -0.01, 0.0, 0.01, 0.02, 0.05, 0.10)
SPACING = 0.002
REACH = 2.6
"""Travel after the step [m]."""
AR = (0.97,)
"""Autocorrelation of the noise between samples 2 mm apart."""


@dataclass(frozen=True)
class Truth:
    """True parameters of one condition."""

    c_cx: float = 2.4e5
    slip_stiffness: float = 9.5e4
    friction: float = 1.0
    fz: float = 3700.0
    pressure: float = 250e3
    noise: float = 12.0
    """Standard deviation of the noise [N]."""
    gain_scatter: float = 0.01
    """Run-to-run standard deviation of the force's gain [-]."""
    slip_scatter: float = 2e-4
    """Run-to-run standard deviation of the slip offset [-]."""
    carcass_scatter: float = 0.01
    """Run-to-run standard deviation of the carcass stiffness [-]."""

    def steady(self, kappa: np.ndarray) -> np.ndarray:
        """F_ss [N] over slip."""
        peak = self.friction * self.fz
        return peak * np.sin(1.4 * np.arctan(self.slip_stiffness / (1.4 * peak) * kappa))

    def stiffness(self) -> float:
        """C_Fk [N] of that table: the slope in the limit of zero slip."""
        slips = np.array(SLIPS)
        return float(slope_weights(slips, force := self.steady(slips)) @ force)

    def law(self) -> TableLaw:
        """Table of the steady force that a campaign with these slips gives without noise."""
        slips = np.array(SLIPS)
        return curve_law(slips, self.steady(slips))


def coloured_noise(
    rng: np.random.Generator, shape: tuple[int, ...], std: float, ar: tuple[float, ...] = AR
) -> np.ndarray:
    """Autoregressive noise of a given standard deviation along the last axis."""
    lead = 400
    white = rng.standard_normal((*shape[:-1], shape[-1] + lead))
    noise = lfilter([1.0], [1.0, *(-np.asarray(ar))], white, axis=-1)[..., lead:]
    impulse = lfilter([1.0], [1.0, *(-np.asarray(ar))], np.append(1.0, np.zeros(20000)))
    return std / np.linalg.norm(impulse) * noise


def simulate_runs(
    truth: Truth, rng: np.random.Generator, starts: int = 3, slips: tuple[float, ...] = SLIPS
) -> list[StepRun]:
    """Slip steps of one condition with noise and run-to-run scatter."""
    after = np.arange(0.5 * SPACING, REACH, SPACING)
    before = np.arange(-0.1 + 0.5 * SPACING, 0.0, SPACING)
    levels = np.repeat(slips, starts)
    count = len(levels)
    gain = 1.0 + truth.gain_scatter * rng.standard_normal(count)
    offset = truth.slip_scatter * rng.standard_normal(count)
    carcass = truth.c_cx * (1.0 + truth.carcass_scatter * rng.standard_normal(count))
    inputs = stack_runs(
        [
            slip_inputs(np.append(0.0, after), k + o, truth.fz, pressure=truth.pressure)
            for k, o in zip(levels, offset, strict=True)
        ]
    )
    law = truth.law()
    model = NonlinearX(lambda _: law, TOYO, truth.friction)
    force = model.simulate(carcass[None, None, :], inputs)[0][:, 1:]
    full = np.hstack([np.zeros((count, len(before))), force]) * gain[:, None]
    full = full + coloured_noise(rng, full.shape, truth.noise)
    x = np.concatenate([before, after])
    return [
        _run(truth, x, level, row, i % starts)
        for i, (level, row) in enumerate(zip(levels, full, strict=True))
    ]


def simulate_linear(
    truth: Mapping[float, tuple[float, float]],
    rng: np.random.Generator,
    starts: int = 3,
    noise: float = 12.0,
    scatter: float = 0.01,
) -> list[StepRun]:
    """Runs of the linear model: slip -> (sigma [m], C [N]), both with scatter from run to run."""
    x = np.arange(-0.1 + 0.5 * SPACING, REACH, SPACING)
    runs = []
    for level, (sigma, stiffness) in truth.items():
        for start in range(starts):
            own = sigma * (1.0 + scatter * rng.standard_normal())
            end = stiffness * level * (1.0 + scatter * rng.standard_normal())
            begin = 20.0 * rng.standard_normal()
            force = begin + (end - begin) * -np.expm1(-np.maximum(x, 0.0) / own)
            force = force + coloured_noise(rng, x.shape, noise)
            runs.append(_run(Truth(), x, level, force, start))
    return runs


def _run(truth: Truth, x: np.ndarray, level: float, force: np.ndarray, start: int) -> StepRun:
    zero = np.zeros_like(x)
    return StepRun(
        name=f"{100 * level:+.0f}perc_{truth.fz:.0f}N_{start + 1}",
        operating_point=(truth.fz, truth.pressure),
        level=float(level),
        kappa=float(level),
        distance=x,
        fx=force,
        fy=zero,
        mz=zero,
        fz=np.full_like(x, truth.fz),
        slip=level * np.maximum(x, 0.0),
        pressure=truth.pressure,
        start=start + 1,
    )
