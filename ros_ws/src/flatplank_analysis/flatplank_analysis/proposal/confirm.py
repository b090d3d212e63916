# SPDX-License-Identifier: Apache-2.0
"""Runs that took no part in the search say whether a proposal holds: size and error.

Tire and machine are those of the first campaign; of the new runs only what scatters from run to
run anyway (gain, slip offset, zero of Fx) is fitted, and the size of the effect.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import t as student

from flatplank_analysis.discovery import invariants
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.fit import Fit, Term
from flatplank_analysis.discovery.model import Lane
from flatplank_analysis.discovery.modelfile import ModelFile
from flatplank_analysis.discovery.search import Step
from flatplank_analysis.errors import FlatplankError
from flatplank_analysis.tirebase.model import TireModel
from flatplank_analysis.tirebase.session import Session

CONFIRMED, FAILED = "confirmed", "not confirmed"
LEAST_RUNS = 3
LEVEL = 0.95
"""of a two-sided 90 % interval"""


@dataclass(frozen=True)
class Checked:
    """One set of new runs."""

    folder: str
    runs: int
    size: float
    half: float
    """half of the 90 % interval of the size"""
    error_before: float
    error: float
    limit: float
    """error at the floor, as the first campaign has it"""
    reasons: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """For programs."""
        return {
            "folder": self.folder, "runs": self.runs, "size": self.size,
            "interval": [self.size - self.half, self.size + self.half],
            "rmse_before": self.error_before, "rmse": self.error, "limit": self.limit,
            "reasons": list(self.reasons),
        }  # fmt: skip


@dataclass(frozen=True)
class Confirmation:
    """The answer on all sets."""

    name: str
    unit: str
    interval: tuple[float, float]
    checked: tuple[Checked, ...]

    @property
    def verdict(self) -> str:
        """Confirmed when every set agrees."""
        return FAILED if any(c.reasons for c in self.checked) else CONFIRMED

    def to_dict(self) -> dict[str, Any]:
        """The JSON of `flatplank confirm --json`."""
        return {
            "verdict": self.verdict, "effect": self.name, "unit": self.unit,
            "interval": list(self.interval), "sets": [c.to_dict() for c in self.checked],
        }  # fmt: skip


def interval_of(effect: type[Effect]) -> tuple[float, float]:
    """The interval of the size in the file of a proposal."""
    found = getattr(effect, "interval", None)
    if not isinstance(found, tuple) or len(found) != 2:
        raise FlatplankError(
            "has no interval to compare with", f"effect {effect.identifier}",
            "write 'interval = (low, high)' with the 90 % interval that `flatplank add` prints",
        )  # fmt: skip
    return float(found[0]), float(found[1])


def fitted(session: Session, model: ModelFile | None, name: str) -> Step:
    """The first campaign with the effect in its model."""
    if model is not None and any(e.name == name for e in model.effects):
        return session.fit(model)
    return session.add(model or ModelFile(), name)[1]


def confirm(
    session: Session, step: Step, name: str, sets: Sequence[tuple[str, Session]]
) -> Confirmation:
    """Judge an effect of a fitted model by sets of new runs."""
    effect = session.effects[name]
    interval = interval_of(effect)
    known = set(session.data.runs.names)
    checked = []
    for folder, new in sets:
        again = known & set(new.data.runs.names)
        if folder == session.campaign.path and again:
            raise FlatplankError(
                "are the runs of the search", folder, "measure new runs: their own folder"
            )
        checked.append(_checked(session.model, step, effect, interval, folder, new.model))
    return Confirmation(name, effect.main_parameter().unit, interval, tuple(checked))


def _checked(
    old: TireModel, step: Step, effect: type[Effect], interval: tuple[float, float], folder: str,
    new: TireModel,
) -> Checked:  # fmt: skip
    if new.runs.contradicted:
        raise FlatplankError("; ".join(new.runs.contradicted), folder)
    count = new.runs.runs
    if count < LEAST_RUNS:
        raise FlatplankError(f"{count} runs are too few", folder, f"measure at least {LEAST_RUNS}")
    new.take_references(old)
    fit = step.state.fit
    at = max(i for i, t in enumerate(fit.terms) if t.effect.identifier == effect.identifier)
    base = [p.name for p in old.parameters]
    size, half, before, error = _sized(new, base, fit, at)
    limit = invariants.limits(step.state).error
    reasons = []
    low, high = interval
    middle, width = 0.5 * (low + high), 0.5 * (high - low)
    if abs(size - middle) > float(np.hypot(width, half)):
        reasons.append("the size is another one")
    if abs(size) < half:
        reasons.append("the new runs do not show it: its interval covers zero")
    if error > limit:
        reasons.append("the error is not at the floor")
    return Checked(folder, count, size, half, before, error, limit, tuple(reasons))


def _sized(
    new: TireModel, base: Sequence[str], fit: Fit, at: int
) -> tuple[float, float, float, float]:
    """Size with half of its interval, and the error of Fx without and with the effect.

    Every run has its own size; their scatter tells how well the mean is known.
    """
    term = fit.terms[at]
    others = tuple((t.effect, t.values) for i, t in enumerate(fit.terms) if i != at)
    lanes = [
        Lane(fit.base, (*others, (term.effect, _nulls(term)))),
        Lane(fit.base, (*others, (term.effect, term.values))),
        *_loose(new, base, fit, others, term),
    ]
    predicted = new.predict(lanes)[:, 0]
    measured = new.runs.measured[0]
    columns = predicted[1:] - predicted[0]
    columns = np.concatenate([columns, np.ones((1, *measured.shape))])
    rest = measured - predicted[0]
    sizes, without, with_ = [], 0.0, 0.0
    for r in range(len(measured)):
        a, b = columns[:, r].T, rest[r]
        full = np.linalg.lstsq(a, b, rcond=None)[0]
        less = np.linalg.lstsq(a[:, 1:], b, rcond=None)[0]
        clear = a[:, 0] - a[:, 1:] @ np.linalg.lstsq(a[:, 1:], a[:, 0], rcond=None)[0]
        sizes.append((full[0], float(clear @ clear)))
        with_ += float(np.sum((b - a @ full) ** 2))
        without += float(np.sum((b - a[:, 1:] @ less) ** 2))
    share, weight = np.array(sizes).T
    shown = weight > 1e-3 * weight.max() if weight.max() > 0.0 else np.zeros(len(weight), bool)
    mean, half = _mean(share[shown], weight[shown])
    n = rest.size
    return (
        mean * term.size, abs(half * term.size), float(np.sqrt(without / n)),
        float(np.sqrt(with_ / n)),
    )  # fmt: skip


def _mean(share: np.ndarray, weight: np.ndarray) -> tuple[float, float]:
    """Weighted mean and half of its 90 % interval; infinite from one run."""
    if not len(share):
        return 0.0, float("inf")
    mean = float(np.average(share, weights=weight))
    if len(share) < 2:
        return mean, float("inf")
    spread = float(np.average((share - mean) ** 2, weights=weight))
    effective = float(weight.sum() ** 2 / np.sum(weight**2))
    freedom = max(effective - 1.0, 0.5)
    return mean, float(student.ppf(LEVEL, freedom)) * float(np.sqrt(spread / freedom))


def _loose(
    new: TireModel, names: Sequence[str], fit: Fit, others: tuple, term: Term
) -> list[Lane]:
    """What scatters from run to run: the base moved a little in each of its stiff directions."""
    at = {name: i for i, name in enumerate(names)}
    out = []
    for direction in new.stiff(fit.base):
        base = fit.base.copy()
        for name, change in direction.items():
            base[at[name]] += 1e-3 * change
        out.append(Lane(base, (*others, (term.effect, _nulls(term)))))
    return out


def _nulls(term: Term) -> np.ndarray:
    return invariants.at_null(term).values
