# SPDX-License-Identifier: Apache-2.0
"""The limit of the data: what a test could do that knows which effect to look for.

A likelihood-ratio test of the hidden effect, with the covariance of the generator's own noise and
scatter, at the family-wise level of the kit. It has the freedom of the base that the diagnosis
fits, not that of the generator's own tire. Nothing of the search is imported: only the base model
and its interface.

Three limits are told, each with more that is unknown:
- own: the tire is that of the generator (`detectable`);
- base: the tire is unknown within the base of the diagnosis;
- law: the base errs besides, by the stated errors of its law and of its transients.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.linalg import cho_solve
from scipy.optimize import least_squares
from scipy.stats import norm

from flatplank_analysis.contact_patch.data import from_tables
from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.discovery.model import ParameterSet
from flatplank_validation.blind.cases import measured_table
from flatplank_validation.blind.detectable import (
    CHANNELS,
    CLOSE,
    NEEDED,
    PLACES,
    ROUNDS,
    NoiseFree,
    cache,
    factors_of,
    kit_version,
    noise_free,
)
from flatplank_validation.blind.kept import kept
from flatplank_validation.blind.menu import MENU

LIMITS = ("base", "law")
STEPS = 40
"""most steps of the fit of the base"""
FLAT = 1e-9
"""numerical: prior of what is free"""
Interval = tuple[float, float]


@lru_cache(maxsize=8)
def unknowns(world: str, design: str, limit: str) -> tuple[np.ndarray, np.ndarray]:
    """Columns (n, runs, channels, positions) of what a test does not know, and the inverse
    variance (n,) of each."""
    clean = noise_free(world, design)
    columns, precision = _base(clean)
    if limit == "law":
        more = _law_errors(clean, TireModel(_data(clean)))
        columns = np.concatenate([columns, more])
        precision = np.concatenate([precision, np.ones(len(more))])
    return columns, precision


def _data(clean: NoiseFree):
    pairs = zip(clean.columns, clean.runs, strict=True)
    return from_tables([measured_table(c, run, clean.world.radius) for c, run in pairs])


def _base(clean: NoiseFree) -> tuple[np.ndarray, np.ndarray]:
    """Columns of the base of the diagnosis around its fit of the noise-free campaign, one scale of
    each parameter, and the inverse variances of their priors."""
    model = TireModel(_data(clean))
    free = [i for i, p in enumerate(model.parameters) if p.screen]
    own = [model.parameters[i] for i in free]
    scale = np.array([p.screen for p in own])
    null = np.array([p.null for p in model.parameters])

    def sets(points: np.ndarray) -> list[ParameterSet]:
        out = []
        for z in points:
            base = null.copy()
            base[free] = z * scale
            out.append(ParameterSet(base))
        return out

    def residual(z: np.ndarray) -> np.ndarray:
        return (model.predict(sets(z[None]))[0] - model.runs.measured).ravel()

    def changes(z: np.ndarray) -> np.ndarray:
        step = 1e-3 * np.where(z + 1e-3 > high, -1.0, 1.0)
        out = model.predict(sets(np.concatenate([z[None], z + np.diag(step)])))
        return (out[1:] - out[0]) / step[:, None, None, None]

    low, high = np.array([[p.lower, p.upper] for p in own]).T / scale
    start = np.clip(null[free] / scale, low + 1e-6, high - 1e-6)
    fit = least_squares(
        residual, start, lambda z: changes(z).reshape(len(z), -1).T, (low, high), max_nfev=STEPS
    )
    prior = np.array([p.screen / p.prior for p in own]) ** 2
    return _on_places(model, changes(fit.x)), prior + FLAT


def _on_places(model: TireModel, values: np.ndarray) -> np.ndarray:
    """Values (n, channels, runs, samples) of the model as blocks of the kit, its runs in order."""
    out = np.zeros((len(values), values.shape[2], len(CHANNELS), len(PLACES)))
    for row, index in enumerate(model.runs.order.astype(int)):
        for c, name in enumerate(model.runs.channels):
            for n, one in enumerate(values):
                out[n, index, CHANNELS.index(name)] = np.interp(
                    PLACES, model.data.position[row], one[c, row]
                )
    return out


def _law_errors(clean: NoiseFree, model: TireModel) -> np.ndarray:
    """Columns of the errors of the law, one per setting and force, and of the transients, one per
    setting, each with its standard deviation as the base states it."""
    forces = clean.plain.copy()
    forces[:, 2] = 0.0
    late = -model.form.shift * np.gradient(forces, PLACES, axis=2)
    settings = [(r.setting.kappa, r.setting.fz, r.setting.alpha_deg, r.setting.gamma_deg)
                for r in clean.runs]  # fmt: skip
    out = []
    for setting in sorted(set(settings)):
        rows = np.array([s == setting for s in settings], dtype=float)[:, None, None]
        out += [model.form.law * forces * rows * (np.arange(3) == c)[:, None] for c in range(2)]
        out.append(late * rows)
    return np.array(out)


def noncentrality(
    change: np.ndarray, columns: np.ndarray, precision: np.ndarray, factors: list[list]
) -> float:
    """Squared length of a change in units of the noise, without what is unknown besides.

    change (runs, channels, positions); columns (n, ...) of unknowns with inverse variances
    precision (n,); factors: of the covariance, per run and channel.
    """
    rows = np.concatenate([columns, change[None]])
    products = np.zeros((len(rows), len(rows)))
    for r, own in enumerate(factors):
        for c, factor in enumerate(own):
            part = rows[:, r, c]
            products += part @ cho_solve(factor, part.T)
    inner = products[:-1, :-1] + np.diag(precision)
    scale = np.sqrt(np.diag(inner))
    taken = np.linalg.lstsq(inner / np.outer(scale, scale), products[:-1, -1] / scale, rcond=1e-12)
    return max(float(products[-1, -1] - (products[:-1, -1] / scale) @ taken[0]), 0.0)


def strength(case: Mapping[str, Any], name: str, size: float, limit: str) -> float:
    """Noncentrality of an effect of a size in a campaign of the kit."""
    clean = noise_free(case["world"], case["design"])
    factors = factors_of(case["world"], case["design"], case["noise"], case["scatter"])
    columns, precision = unknowns(case["world"], case["design"], limit)
    return noncentrality(clean.change(name, size), columns, precision, factors)


def least_size(case: Mapping[str, Any], name: str, limit: str) -> float:
    """Size of an effect that the test finds with 80 % power; infinite where it finds none."""
    key = "/".join(str(case[k]) for k in ("world", "design", "noise", "scatter"))
    path = cache() / f"oracle-{kit_version()}.txt"
    return kept(path, f"{key}/{name}/{limit}", lambda: _least_size(case, name, limit))


def _least_size(case: Mapping[str, Any], name: str, limit: str) -> float:
    item = MENU[name]
    size = item.typical
    for _ in range(ROUNDS):
        found = strength(case, name, size, limit)
        if found <= 0.0 or size > 20.0 * item.most:
            return math.inf
        step = math.sqrt(NEEDED / found)
        if abs(step - 1.0) < CLOSE:
            break
        size *= min(max(step, 0.2), 5.0)
    return size


def narrowest(case: Mapping[str, Any], name: str, size: float, limit: str) -> float:
    """Width of the narrowest 90 % interval of a size that is unbiased (Cramér and Rao)."""
    found = strength(case, name, size, limit)
    return 2.0 * float(norm.isf(0.05)) * size / math.sqrt(found) if found else math.inf
