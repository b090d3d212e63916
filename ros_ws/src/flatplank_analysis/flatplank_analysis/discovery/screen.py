# SPDX-License-Identifier: Apache-2.0
"""Screening of candidates: size, gain, visibility and likeness with the base projected out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.dispersion import (
    TypicalDispersion,
    among_repeats,
    scores_of,
    typical_dispersion,
)
from flatplank_analysis.discovery.gram import Gram, solve
from flatplank_analysis.discovery.state import Candidate, State

VISIBLE = 0.005
"""least visible share of an effect that may be named: the share of its column that the base cannot
imitate. The size that an error of the law's form imitates grows with one over its square root, see
`Judge`"""


@dataclass(frozen=True)
class ScreenResult:
    """One candidate after screening."""

    candidate: Candidate
    sizes: np.ndarray
    """best sizes in screening steps, within the physical range"""
    gain: float
    """drop of the whitened chi2 at these sizes"""
    visible: float
    """share of the column that the base cannot imitate"""
    information: np.ndarray
    """(k, k) projected products"""
    contribution: np.ndarray
    """(m,) combination of the columns of all candidates, for likeness"""

    @property
    def identifier(self) -> str:
        return self.candidate.effect.identifier


@dataclass(frozen=True)
class Screen:
    """All candidates, best first, and the sums behind their ranking."""

    ranked: list[ScreenResult]
    gram: Gram
    own: int
    """number of columns that belong to the model itself"""
    projected: np.ndarray
    """products of all candidate columns with the model's own projected out"""
    typical: TypicalDispersion
    """typical dispersion of the candidates"""


def screen(state: State) -> Screen:
    """Rank all candidates of a state."""
    blocks = [c.columns for c in state.candidates]
    fit = state.whitened.fit
    own = len(fit.loose())
    gram = state.sums(fit, fit.loose(), *blocks)
    products, scores, _ = gram.total()
    base, inverse = solve(products[:own, :own], scores[:own])
    cross = products[own:, :own]
    projected = products[own:, own:] - cross @ inverse @ cross.T
    rest = scores[own:] - cross @ base
    ranked = []
    at = 0
    for candidate in state.candidates:
        k = len(candidate.columns)
        rows = slice(at, at + k)
        ranked.append(
            _judge(candidate, projected[rows, rows], rest[rows], products[own:, own:][rows, rows],
                   np.arange(at, at + k), len(rest))
        )  # fmt: skip
        at += k
    ranked.sort(key=lambda s: -s.gain)
    return Screen(ranked, gram, own, projected, _typical(state, gram, own, ranked))


def _typical(state: State, gram: Gram, own: int, ranked: list[ScreenResult]) -> TypicalDispersion:
    """Typical dispersion over all visible candidates at their best setting."""
    pairs, seen = [], set()
    for item in ranked:
        if item.identifier in seen or item.visible < VISIBLE:
            continue
        seen.add(item.identifier)
        pairs.append(
            among_repeats(state.runs.comparable, *scores_of(_along(gram, own, item), own))
        )
    return typical_dispersion([k for k, _ in pairs], [f for _, f in pairs])


def _along(gram: Gram, own: int, item: ScreenResult) -> Gram:
    """Sums of the model's own columns and of one candidate."""
    rows = own + np.flatnonzero(item.contribution)
    mix = item.contribution[rows - own]
    base = np.arange(own)
    c = gram.products
    cross = c[:, base][:, :, rows] @ mix
    corner = np.einsum("i,rij,j->r", mix, c[:, rows][:, :, rows], mix)
    products = np.concatenate(
        [
            np.concatenate([c[:, :own, :own], cross[:, :, None]], axis=2),
            np.concatenate([cross, corner[:, None]], axis=1)[:, None],
        ],
        axis=1,
    )
    scores = np.concatenate([gram.scores[:, :own], (gram.scores[:, rows] @ mix)[:, None]], axis=1)
    return Gram(products, scores, gram.energy)


def _judge(candidate: Candidate, info, score, raw, rows, total) -> ScreenResult:
    trace = float(np.trace(raw))
    visible = float(np.trace(info)) / trace if trace > 1e-12 else 0.0
    sizes = np.zeros(len(score))
    gain = 0.0
    if visible > 1e-6 and trace > 1e-9:
        sizes = _bounded(candidate, info, score)
        gain = float(2.0 * sizes @ score - sizes @ info @ sizes)
    mix = np.zeros(total)
    weight = sizes if np.any(sizes) else np.ones(len(score))
    mix[rows] = weight
    return ScreenResult(candidate, sizes, max(gain, 0.0), visible, info, mix)


def _bounded(candidate: Candidate, info: np.ndarray, score: np.ndarray) -> np.ndarray:
    """Best sizes; those outside their range are held at its end, and the others solved again."""
    sizes, _ = solve(info, score)
    parameters = candidate.effect.linear()
    low = np.array([(p.lower - p.null) / p.screen for p in parameters])
    high = np.array([(p.upper - p.null) / p.screen for p in parameters])
    low, high = np.minimum(low, high), np.maximum(low, high)
    held = np.zeros(len(sizes), dtype=bool)
    for _ in range(len(sizes)):
        out = ~held & ((sizes < low) | (sizes > high))
        if not out.any():
            break
        held |= out
        sizes = np.clip(sizes, low, high)
        free = ~held
        if free.any():
            right = score[free] - info[np.ix_(free, held)] @ sizes[held]
            sizes[free] = solve(info[np.ix_(free, free)], right)[0]
    return np.clip(sizes, low, high)


def best_per_effect(result: Screen) -> list[ScreenResult]:
    """The best setting of every effect, best first."""
    seen: dict[str, ScreenResult] = {}
    for item in result.ranked:
        seen.setdefault(item.identifier, item)
    return list(seen.values())


def settings_of(result: Screen, identifier: str) -> list[ScreenResult]:
    """All settings of one effect, best first."""
    return [s for s in result.ranked if s.identifier == identifier]


def negligible(item: ScreenResult) -> bool:
    """True when the screened size, with what the base may have taken of it, is below half of the
    smallest size of consequence."""
    effect = item.candidate.effect
    values = {p.name: p.null for p in effect.parameters()} | item.candidate.setting
    for p, size in zip(effect.linear(), item.sizes, strict=True):
        values[p.name] = p.null + p.screen * size
    size = abs(effect.size(values)) + effect.in_base
    return size < 0.5 * effect.main_parameter().matters
