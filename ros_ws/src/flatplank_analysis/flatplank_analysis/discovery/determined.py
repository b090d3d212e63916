# SPDX-License-Identifier: Apache-2.0
"""How precisely each parameter is known, and which runs determine it.

A fit computes z = A^-1 (sum of the scores s_r + S c) over the runs r. A is the sum of the Jacobian
products P_r, plus S; the diagonal matrix S and c are the weights and centres of the priors. Let a
be the row of A^-1 of one parameter. Its interval comes from the scatter of a's_r among repeats,
so that it needs no noise model. a'P_r a is the contribution of run r with all other parameters
free, a'S a that of the prior.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import norm as normal
from scipy.stats import t as student

from flatplank_analysis.discovery.dispersion import among_repeats
from flatplank_analysis.discovery.fit import priors
from flatplank_analysis.discovery.gram import Gram, solve
from flatplank_analysis.discovery.state import State
from flatplank_data.wording import quantity

PRIOR = "what is known beforehand"
TOLD, LEAST = 3, 0.1
"""largest number of conditions that are named, and the least share of each"""
HALF = 0.5
"""least diagonal element of A^-1 A (1: determined) at which a parameter has a finite interval"""


@dataclass(frozen=True)
class FittedNumber:
    """A fitted parameter of a model."""

    owner: str
    """identifier of the effect; empty for the tire"""
    name: str
    unit: str
    value: float
    interval: tuple[float, float]
    """90 % interval; infinite where the runs do not determine the parameter"""
    shares: tuple[tuple[str, float], ...]
    """conditions or prior that determine it, with their shares, the largest first"""
    at_bound: bool = False

    def words(self) -> str:
        """What determines the parameter, in words."""
        if not np.isfinite(self.interval[0]):
            return "not determined by these runs"
        listed = [
            f"{who} {quantity(share, '1', 2)}" for who, share in self.shares if share >= LEAST
        ]
        return "; ".join(listed[:TOLD]) or "many conditions, a little each"


def numbers_of(state: State) -> list[FittedNumber]:
    """All fitted parameters of a state's model, the tire's first."""
    fit, runs = state.fit, state.runs
    entries = state.fitter.task(fit).entries
    weight = state.fitter.weight
    gram = Gram.of(_rows(fit.jacobian * weight), _rows((state.residual * weight)[None])[:, 0])
    strength = state.fitter.centres_and_weights(entries)[1]
    whole = gram.total()[0] + np.diag(strength)
    inverse = solve(whole, gram.total()[1])[1]
    known = np.where(strength > 0.0, priors(entries)[1], 0.0)
    prior_part = (inverse * strength) ** 2 @ known**2
    base = {p.name: float(v) for p, v in zip(state.model.parameters, fit.base, strict=True)}
    out = []
    for i, entry in enumerate(entries):
        row, p = inverse[i], entry.parameter
        parts = np.einsum("j,rjk,k->r", row, gram.products, row)
        reach = np.inf
        if float(row @ whole[:, i]) > HALF:
            reach = entry.scale * _reach(runs.groups, gram.scores @ row, parts, prior_part[i])
        term = fit.terms[entry.term] if entry.term >= 0 else None
        value = term.named()[p.name] if term else base[p.name]
        out.append(
            FittedNumber(
                term.effect.identifier if term else "", p.name, p.unit, value,
                (value - reach, value + reach),
                _shares(state, parts, float(row**2 @ strength)),
                entry.at_end(value),
            )
        )  # fmt: skip
    return out


def _rows(values: np.ndarray) -> np.ndarray:
    """(n, channels, runs, samples) as (runs, n, channels and samples)."""
    return np.moveaxis(values, 2, 0).reshape(values.shape[2], len(values), -1)


def _reach(groups, contributed: np.ndarray, parts: np.ndarray, prior: float) -> float:
    """Half of the 90 % interval of a parameter, in its scale, from the scatter among repeats."""
    dispersion, freedom = among_repeats(groups, contributed, parts)
    scatter = float(student.ppf(0.95, freedom)) ** 2 * dispersion * float(parts.sum())
    return float(np.sqrt(scatter + float(normal.ppf(0.95)) ** 2 * prior))


def _shares(state: State, parts: np.ndarray, prior: float) -> tuple[tuple[str, float], ...]:
    """Shares of the conditions and of the prior, the largest first."""
    runs = state.runs
    heads = [name.split(",", 1)[0] for name in runs.condition_names]
    names = heads if len(set(heads)) == len(heads) else runs.condition_names
    all_parts = {n: float(parts[g].sum()) for n, g in zip(names, runs.groups, strict=True)}
    all_parts |= {PRIOR: prior} if prior > 0.0 else {}
    total = max(sum(all_parts.values()), 1e-30)
    return tuple(sorted(((n, v / total) for n, v in all_parts.items()), key=lambda s: -s[1]))
