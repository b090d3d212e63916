# SPDX-License-Identifier: Apache-2.0
"""Input of a Magic Formula fit: steady measurements, one row per point."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flatplank_data.errors import FlatplankError

from ..carcass import CarcassFit
from ..repeats import asymptotes, with_equal_starts
from ..runs import StepRun, by_operating_point

AXES = ("fz", "kappa", "alpha", "gamma", "pressure")


@dataclass(frozen=True)
class SteadyPoints:
    """Operating points (n,) and measured outputs (NaN: not measured). SI, ISO W.

    `fz` [N], `kappa` [-], `alpha`, `gamma` [rad], `pressure` [Pa]; `run` identifies rows of the
    same run; `measured` maps an output (fx, fy [N], mz [Nm], re, a, b, rho [m], cx, cy [N/m]) to
    (n,).
    """

    fz: np.ndarray
    kappa: np.ndarray
    alpha: np.ndarray
    gamma: np.ndarray
    pressure: np.ndarray
    run: np.ndarray
    measured: Mapping[str, np.ndarray]

    def __len__(self) -> int:
        return len(self.fz)

    def rows(self, mask: np.ndarray) -> SteadyPoints:
        """Some of the points, by a mask or by indices."""
        axes = {name: getattr(self, name)[mask] for name in (*AXES, "run")}
        return SteadyPoints(**axes, measured={k: v[mask] for k, v in self.measured.items()})

    def ranges(self) -> dict[str, tuple[float, float]]:
        """Axis -> lowest and highest value, where they differ."""
        ends = {name: (getattr(self, name).min(), getattr(self, name).max()) for name in AXES}
        return {name: (float(a), float(b)) for name, (a, b) in ends.items() if a < b}

    def with_output(self, output: str) -> SteadyPoints:
        """The points at which this output was measured."""
        values = self.measured.get(output)
        return self.rows(np.zeros(len(self), bool) if values is None else np.isfinite(values))


def steady_points(
    measured: Mapping[str, np.ndarray],
    *,
    fz: np.ndarray,
    pressure: np.ndarray | float,
    kappa: np.ndarray | float = 0.0,
    alpha: np.ndarray | float = 0.0,
    gamma: np.ndarray | float = 0.0,
    run: np.ndarray | None = None,
) -> SteadyPoints:
    """Points from arrays or single numbers; by default every row is a run of its own."""
    fz = np.atleast_1d(np.asarray(fz, float))
    run = np.arange(len(fz)) if run is None else np.asarray(run)
    axes = {"fz": fz, "kappa": kappa, "alpha": alpha, "gamma": gamma, "pressure": pressure}
    full = {k: np.broadcast_to(np.asarray(v, float), fz.shape).copy() for k, v in axes.items()}
    return SteadyPoints(
        **full, run=run, measured={k: np.asarray(v, float) for k, v in measured.items()}
    )


def points_from_runs(runs: Sequence[StepRun]) -> SteadyPoints:
    """Steady Fx (asymptote fitted with the sigma of its repeats), Fy and Mz of slip-step runs."""
    if not runs:
        raise FlatplankError("no run to take steady forces from", "", "give slip-step runs")
    runs = [
        run for members in by_operating_point(runs).values() for run in with_equal_starts(members)
    ]
    fx = np.empty(len(runs))
    place = {id(run): i for i, run in enumerate(runs)}
    for members in by_operating_point(runs).values():
        fx[[place[id(run)] for run in members]] = asymptotes(members)
    fy, mz = (np.array([_tail(run, name) for run in runs]) for name in ("fy", "mz"))
    return steady_points(
        {"fx": fx, "fy": fy, "mz": mz},
        fz=np.array([r.mean_load for r in runs]),
        kappa=np.array([r.kappa for r in runs]),
        alpha=np.array([r.alpha for r in runs]),
        gamma=np.array([r.gamma for r in runs]),
        pressure=np.array([r.pressure for r in runs]),
    )


UPRIGHT = np.radians(0.3)
"""Largest side slip angle and camber of a run that counts as straight and upright [rad]."""
AT_REST = "cx_at_rest"
"""Output: C_x of the standing tire, used where that of the rolling one is not known."""


def stiffness_points(fits: Sequence[CarcassFit]) -> list[SteadyPoints]:
    """Overall longitudinal stiffness C_x = C_Fk / sigma_x (7.7) of carcass fits that determine it.

    Only for straight and upright running: at a side slip angle C_Fk and sigma_x both shrink, and
    their ratio is no stiffness of the tire in x.
    """
    return [
        steady_points({"cx": np.array([f.rolling_stiffness])}, **f.at._asdict())
        for f in fits
        if np.isfinite(f.rolling_stiffness)
        and abs(f.at.alpha) < UPRIGHT
        and abs(f.at.gamma) < UPRIGHT
    ]


def merge_with_cx_source(
    parts: Sequence[SteadyPoints], fits: Sequence[CarcassFit]
) -> tuple[SteadyPoints, str]:
    """All points, and the source of their C_x: rolling tire, else standing tire, else ""."""
    rolling = stiffness_points(fits)
    points = merge([*parts, *rolling])
    if rolling:
        count = f"{len(rolling)} operating point" + "s" * (len(rolling) > 1)
        return points, f"C_Fκ/σx (7.7) of the nonlinear fits of {count} without side slip"
    measured = dict(points.measured)
    standing = measured.pop(AT_REST, None)
    if standing is None:
        return points, ""
    at_rest = int(np.count_nonzero(np.isfinite(standing)))
    source = f"{at_rest} runs at rest: no nonlinear fit tells the rolling one"
    return replace(points, measured=measured | {"cx": standing}), source


def merge(parts: Sequence[SteadyPoints]) -> SteadyPoints:
    """Points of several campaigns or kinds of measurement, with their runs kept distinct."""
    outputs = list(dict.fromkeys(k for part in parts for k in part.measured))
    axes = {name: np.concatenate([getattr(p, name) for p in parts]) for name in AXES}
    blank = [np.full(len(p), np.nan) for p in parts]
    measured = {
        k: np.concatenate([p.measured.get(k, b) for p, b in zip(parts, blank, strict=True)])
        for k in outputs
    }
    numbers, first = [], 0
    for part in parts:
        names, index = np.unique(part.run, return_inverse=True)
        numbers.append(index + first)
        first += len(names)
    found = SteadyPoints(**axes, run=np.concatenate(numbers), measured=measured)
    # the order of the points must not decide between two equally good minima
    keys = [*(np.nan_to_num(v, nan=-1.0) for v in measured.values()), *axes.values()]
    return found.rows(np.lexsort(keys))


def _tail(run: StepRun, output: str) -> float:
    """Mean of Fy or Mz over the last half metre; NaN where all values are 0 (not measured)."""
    values = getattr(run, output)
    tail = run.distance > run.distance[-1] - 0.5
    return float(np.mean(values[tail])) if np.any(values[tail] != 0.0) else float("nan")
