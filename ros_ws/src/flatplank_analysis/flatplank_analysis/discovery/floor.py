# SPDX-License-Identifier: Apache-2.0
"""The noise floor of every condition from its repeats, and the part of the residual above it.

The only definition of a floor: search, report, pages and panel use it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import f as f_distribution

from flatplank_analysis.discovery.runs import RunSet
from flatplank_data.wording import six_digits

BELOW = (
    "a fit can lie below a floor: the floor is the scatter of single runs, estimated from few "
    "repeats, and the parameters of the fit follow part of this scatter"
)
"""why an error below the floor is no contradiction"""


def beyond(error: Any, floor: Any) -> Any:
    """Part of an error above a floor, in quadrature."""
    return np.sqrt(np.maximum(np.square(error) - np.square(floor), 0.0))


@dataclass(frozen=True)
class Floor:
    """Levels of one channel, in its unit."""

    floor: float
    """scatter between repeats of all conditions, without what effects that differ between repeats
    explain: for totals only"""
    raw: float
    """scatter between repeats of all conditions"""
    unexplained: float
    """systematic part of the residual above the floor"""
    per_condition: np.ndarray
    """(conditions,) the systematic part by condition"""
    by_condition: np.ndarray
    """(conditions,) floor of each condition; that of all where a condition is not repeated"""
    rmse_condition: np.ndarray
    """(conditions,) root mean square of the residual"""
    freedom: float
    """degrees of freedom of the contrasts behind the floor"""
    p_value: float
    """p-value of the hypothesis that the mean residual does not exceed the floor"""
    varying_p: float = 1.0
    """p-value of the hypothesis that repeats differ by chance, see `Cleaned`"""

    @property
    def multiples(self) -> np.ndarray:
        """Error of each condition, relative to its own floor (conditions,)."""
        return self.rmse_condition / np.maximum(self.by_condition, 1e-30)

    @property
    def beyond(self) -> np.ndarray:
        """Part of the error of each condition above its own floor, in quadrature (conditions,)."""
        return beyond(self.rmse_condition, self.by_condition)

    def rows(self, runs: RunSet) -> list[dict[str, Any]]:
        """Per condition, for programs: error, its part beyond the floor, the part that the mean of
        the repeats has beyond it, and floor, in the unit of the
        channel; the error in floors; and whether the floor is by the condition's own repeats."""
        return [
            {
                "condition": name,
                "runs": len(rows),
                "rmse": six_digits(self.rmse_condition[i]),
                "beyond": six_digits(self.beyond[i]),
                "unexplained": six_digits(self.per_condition[i]),
                "floor": six_digits(self.by_condition[i]),
                "floors": six_digits(self.multiples[i]),
                "own_floor": len(rows) > 1,
            }
            for i, (name, rows) in enumerate(zip(runs.condition_names, runs.groups, strict=True))
        ]

    @property
    def varying(self) -> float:
        """Part of the scatter that known differences between repeats explain."""
        return float(beyond(self.raw, self.floor))


@dataclass(frozen=True)
class Cleaned:
    """Within-condition contrasts of a channel without effects that differ between repeats."""

    contrasts: np.ndarray
    """(runs, samples)"""
    p_value: float = 1.0
    """p-value of the first effect that was taken out, times the number of effects that were tried;
    1 when none was"""
    left: float = 1.0
    """share of the freedom of the contrasts that the effects that were taken out leave"""


def contrast_blocks(runs: RunSet, blocks: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Contrasts (k, runs, samples) of the blocks that differ between repeats.

    A block counts when at least half of its size lies in the contrasts.
    """
    out = []
    for block in blocks:
        size = np.sqrt(np.mean(block**2))
        contrasts = runs.contrast(block)
        if size > 0.0 and np.sqrt(np.mean(contrasts**2)) > 0.5 * size:
            out.append(contrasts)
    return out


def effective_freedom(runs: RunSet, contrast: np.ndarray) -> float:
    """Degrees of freedom of the contrasts: red noise has few per run, and where the scatter of a
    tire grows with its force, few conditions have most of it.

    The product of two participation ratios: of the time covariance, corrected for the number of
    runs, and of the conditions, corrected for their chance variation.
    """
    spare = max(sum(len(g) - 1 for g in runs.groups), 1)
    thin = contrast[:, :: max(1, runs.samples // 300)]
    covariance = thin.T @ thin
    ratio = float(np.trace(covariance) ** 2 / max(float(np.sum(covariance**2)), 1e-30))
    per_run = 1.0 / max(1.0 / max(ratio, 1.0) - 1.0 / spare, 1.0 / 200.0)
    energy = np.sum(contrast**2, axis=1)
    repeated = [g for g in runs.groups if len(g) > 1]
    level = np.array([float(np.sum(energy[g])) / (len(g) - 1) for g in repeated])
    if not np.any(level > 0.0):
        return spare * per_run
    by_chance = 1.0 + 2.0 * len(repeated) / (spare * per_run)
    uneven = float(np.mean(level**2) / np.mean(level) ** 2) / by_chance
    return spare * per_run / max(uneven, 1.0)


def clean_contrasts(
    runs: RunSet, residual: np.ndarray, pool: Sequence[np.ndarray], level: float = 0.005
) -> Cleaned:
    """Take effects that differ between repeats out of the contrasts of a channel.

    pool: blocks of their columns (k, runs, samples), by `contrast_blocks`. Blocks are regressed
    out one at a time, the best first, as long as an F test with the effective freedom of the
    contrasts requires it: with red noise a regression on all of them would remove the noise
    itself.
    """
    contrast = runs.contrast(residual)
    pool = list(pool)
    freedom = effective_freedom(runs, contrast)
    chosen: list[np.ndarray] = []
    energy = float(np.sum(contrast**2))
    whole = max(freedom, 1.0)
    left, first = contrast, 1.0
    count = max(len(pool), 1)
    while pool and energy > 0.0:
        tries = [_regress(contrast, [*chosen, block]) for block in pool]
        energies = [float(np.sum(t**2)) for t in tries]
        best = int(np.argmin(energies))
        k = len(pool[best])
        used = sum(len(c) for c in chosen) + k
        spare = max(freedom - used, 2.0)
        value = (energy - energies[best]) / k / max(energies[best] / spare, 1e-30)
        p_value = float(f_distribution.sf(value, k, spare)) * count
        if p_value > level:
            break
        first = first if chosen else p_value
        left, energy = tries[best], energies[best]
        chosen.append(pool.pop(best))
        freedom = max(effective_freedom(runs, left), 2.0 * used)
    taken = float(sum(len(c) for c in chosen))
    return Cleaned(left, first, max(1.0 - taken / whole, 0.5))


def _regress(contrast: np.ndarray, blocks: Sequence[np.ndarray]) -> np.ndarray:
    flat = np.concatenate(list(blocks)).reshape(-1, contrast.size)
    flat = flat / np.sqrt(np.mean(flat**2, axis=1) + 1e-30)[:, None]
    gram = flat @ flat.T
    fit = np.linalg.solve(
        gram + 1e-9 * np.trace(gram) * np.eye(len(gram)), flat @ contrast.reshape(-1)
    )
    return contrast - (fit @ flat).reshape(contrast.shape)


def scatter_of_repeats(
    cleaned: Cleaned, groups: Sequence[np.ndarray], keep: np.ndarray | None = None
) -> tuple[float, np.ndarray]:
    """Mean square of a single run about the mean of its condition: of all conditions, and of each
    one (conditions,); NaN for a condition that is not repeated, 0 for all when none is.

    groups: rows of every condition; keep: mask of the samples that count, by default all.
    """
    contrasts = cleaned.contrasts if keep is None else cleaned.contrasts[:, keep]
    energy = np.sum(contrasts**2, axis=1) / contrasts.shape[1] / cleaned.left
    spare = np.array([len(g) - 1 for g in groups], dtype=float)
    own = np.array([float(np.sum(energy[g])) for g in groups])
    each = np.divide(own, spare, out=np.full(len(groups), np.nan), where=spare > 0.0)
    return float(np.sum(energy) / max(float(spare.sum()), 1.0)), each


def floor_of(
    runs: RunSet,
    residual: np.ndarray,
    cleaned: Cleaned,
    channel: int = 0,
    per_run: float = np.inf,
    least: np.ndarray | float = 0.0,
) -> Floor:
    """Floor and unexplained part of one channel; residual (runs, samples).

    per_run: degrees of freedom per run by the noise model; the smaller of this and the freedom of
    the contrasts is used, because few contrasts estimate slow noise poorly. least: lower bound
    (conditions,) of the floor, where nothing is repeated.
    """
    counts = np.array([len(g) for g in runs.groups])
    spare = max(float(np.sum(counts - 1)), 1.0)
    pure, own = scatter_of_repeats(cleaned, runs.groups)
    bound = np.square(np.broadcast_to(least, counts.shape))
    pure = max(pure, float(np.average(bound, weights=counts)))
    alone = np.where(bound > 0.0, bound, pure)
    own = np.where(np.isnan(own), alone, np.maximum(own, bound))
    raw = scatter_of_repeats(Cleaned(runs.contrast(residual)), runs.groups)[0]
    steps = runs.input_noise[channel] ** 2 if runs.input_noise else 0.0
    square = np.mean(runs.mean(residual) ** 2, axis=1)
    systematic = np.average(square - pure / counts - steps, weights=counts)
    rms = np.sqrt([np.mean(residual[g] ** 2) for g in runs.groups])
    freedom = min(effective_freedom(runs, cleaned.contrasts), spare * per_run)
    ratio = float(np.mean(np.maximum(square - steps, 0.0) * counts)) / max(pure, 1e-30)
    return Floor(
        floor=float(np.sqrt(pure)),
        raw=float(np.sqrt(raw)),
        unexplained=float(np.sqrt(max(float(systematic), 0.0))),
        per_condition=np.sqrt(np.maximum(square - own / counts - steps, 0.0)),
        by_condition=np.sqrt(own),
        rmse_condition=rms,
        freedom=freedom,
        p_value=float(f_distribution.sf(ratio, freedom * len(counts) / spare, freedom)),
        varying_p=cleaned.p_value,
    )
