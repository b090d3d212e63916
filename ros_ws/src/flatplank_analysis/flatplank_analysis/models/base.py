# SPDX-License-Identifier: Apache-2.0
"""The interface of every transient tire model: lanes of parameters, runs of inputs, distance.

A model is driven by increments of position and angle, not by velocities: rest, reverse and any
slip waveform need no special case. Arrays are (lanes, runs, samples): a lane is one set of
parameters, so that a Jacobian, or a whole search step, is one call.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from flatplank_analysis.discovery.parameters import Parameter


@dataclass(frozen=True)
class RunInputs:
    """What drives the models. Arrays (runs, samples); increments are from the sample before.

    `travel` |dx| of the wheel over the road, in the wheel plane [m]; `slip_x` r_e d(angle) - dx
    [m], that is kappa times travel; `slip_y` tan(alpha) times travel [m]; `fz` [N]; `alpha`,
    `gamma` [rad]; `pressure` [Pa]; `dt` [s]; `start_fx`, `start_fy` (runs,) [N] the force before
    sample 0.
    """

    travel: np.ndarray
    slip_x: np.ndarray
    slip_y: np.ndarray
    fz: np.ndarray
    alpha: np.ndarray
    gamma: np.ndarray
    pressure: np.ndarray
    dt: np.ndarray
    start_fx: np.ndarray
    start_fy: np.ndarray

    @property
    def shape(self) -> tuple[int, int]:
        """(runs, samples)."""
        return self.travel.shape


@runtime_checkable
class TransientModel(Protocol):
    """A tire model that maps parameters and inputs to one force."""

    @property
    def name(self) -> str:
        """As in tables and files."""
        ...

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """What a lane of numbers means."""
        ...

    def simulate(self, params: np.ndarray, inputs: RunInputs) -> np.ndarray:
        """Force [N] (lanes, runs, samples) for params (lanes, p) or (lanes, p, runs)."""
        ...


def column(params: np.ndarray, index: int) -> np.ndarray:
    """Parameter `index` as (lanes, 1), or (lanes, runs) when it differs between runs."""
    values = np.asarray(params, float)[:, index]
    return values[:, None] if values.ndim == 1 else values


def defaults(model: TransientModel) -> np.ndarray:
    """Default parameters as one lane (1, p)."""
    return np.array([[p.null for p in model.parameters]])


def run_inputs(
    position: np.ndarray,
    wheel_angle: np.ndarray,
    radius: float,
    fz: np.ndarray | float,
    *,
    alpha: np.ndarray | float = 0.0,
    gamma: np.ndarray | float = 0.0,
    pressure: float = 250e3,
    time: np.ndarray | None = None,
    start_fx: float = 0.0,
    start_fy: float = 0.0,
) -> RunInputs:
    """Inputs of one run from plank position [m], wheel angle [rad], effective radius [m]."""
    x = np.asarray(position, float)
    alpha = np.broadcast_to(np.asarray(alpha, float), x.shape)
    moved = np.diff(x, prepend=x[0])
    dx = moved * np.cos(alpha)
    rolled = radius * np.diff(np.asarray(wheel_angle, float), prepend=wheel_angle[0])
    clock = np.zeros_like(x) if time is None else np.diff(np.asarray(time, float), prepend=time[0])

    def row(value: np.ndarray | float) -> np.ndarray:
        return np.broadcast_to(np.asarray(value, float), x.shape)[None, :]

    return RunInputs(
        travel=row(np.abs(dx)),
        slip_x=row(rolled - dx),
        slip_y=row(np.tan(alpha) * np.abs(dx)),
        fz=row(fz),
        alpha=row(alpha),
        gamma=row(gamma),
        pressure=row(pressure),
        dt=row(clock),
        start_fx=np.array([start_fx]),
        start_fy=np.array([start_fy]),
    )


def slip_inputs(
    distance: np.ndarray,
    kappa: np.ndarray | float,
    fz: np.ndarray | float,
    *,
    alpha: np.ndarray | float = 0.0,
    gamma: np.ndarray | float = 0.0,
    pressure: float = 250e3,
    speed: float = 0.03,
    start_fx: float = 0.0,
    start_fy: float = 0.0,
) -> RunInputs:
    """Inputs of one run from distance [m] and slip; kappa, alpha hold from the sample before."""
    x = np.asarray(distance, float)
    dx = np.diff(x, prepend=x[0])

    def row(value: np.ndarray | float) -> np.ndarray:
        return np.broadcast_to(np.asarray(value, float), x.shape)[None, :]

    return RunInputs(
        travel=row(np.abs(dx)),
        slip_x=row(np.asarray(kappa, float) * np.abs(dx)),
        slip_y=row(np.tan(np.asarray(alpha, float)) * np.abs(dx)),
        fz=row(fz),
        alpha=row(alpha),
        gamma=row(gamma),
        pressure=row(pressure),
        dt=row(np.abs(dx) / speed),
        start_fx=np.array([start_fx]),
        start_fy=np.array([start_fy]),
    )


def stack_runs(runs: Sequence[RunInputs]) -> RunInputs:
    """Several runs as one; shorter ones are padded with rest (nothing moves, nothing changes)."""
    length = max(r.shape[1] for r in runs)

    def join(name: str, rest: bool) -> np.ndarray:
        rows = []
        for run in runs:
            values = getattr(run, name)
            missing = length - values.shape[1]
            fill = np.zeros((values.shape[0], missing))
            rows.append(np.hstack([values, fill if rest else fill + values[:, -1:]]))
        return np.vstack(rows)

    moving = {name: join(name, True) for name in ("travel", "slip_x", "slip_y", "dt")}
    holding = {name: join(name, False) for name in ("fz", "alpha", "gamma", "pressure")}
    return RunInputs(
        **moving,
        **holding,
        start_fx=np.concatenate([r.start_fx for r in runs]),
        start_fy=np.concatenate([r.start_fy for r in runs]),
    )
