# SPDX-License-Identifier: Apache-2.0
"""Test of a proposal on runs that were not used in the search: size and error.

Tire, machine, noise and scatter are taken from the first campaign, with their uncertainty. The
new runs are fitted with the size of the effect, and with common changes of gain, slip offset and
zero of Fx; those of sweeps without them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery import invariants
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.fit import scale_of
from flatplank_analysis.discovery.gram import Metric, solve
from flatplank_analysis.discovery.model import ParameterSet
from flatplank_analysis.discovery.modelfile import ModelFile
from flatplank_analysis.discovery.noise import make_whitener
from flatplank_analysis.discovery.scatter import scatter_of
from flatplank_analysis.discovery.state import State, scatter_columns
from flatplank_analysis.discovery.steps import Step
from flatplank_analysis.identify.results import NORMAL_90
from flatplank_analysis.inference.errors import FORMS
from flatplank_data.disjoint import shared_runs
from flatplank_data.errors import FlatplankError

CONFIRMED, FAILED = "confirmed", "not confirmed"
LEAST_RUNS = 3
STEP = 1e-3
"""step of numerical derivatives, in scales of the parameter"""


@dataclass(frozen=True)
class CheckedRuns:
    """Size and error in one set of new runs."""

    folder: str
    runs: int
    size: float
    half: float
    """half of the 90 % interval of the size"""
    error_before: float
    error: float
    """error of Fx without the effect (`error_before`) and with it [N]"""
    limit: float
    """largest error that counts as at the floor of the first campaign [N]"""
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
    """Result of the test on all sets of new runs."""

    name: str
    unit: str
    interval: tuple[float, float]
    """90 % interval of the size in the search"""
    checked: tuple[CheckedRuns, ...]

    @property
    def verdict(self) -> str:
        """`confirmed` when every set agrees."""
        return FAILED if any(c.reasons for c in self.checked) else CONFIRMED

    def to_dict(self) -> dict[str, Any]:
        """The JSON of `flatplank confirm --json`."""
        return {
            "verdict": self.verdict, "effect": self.name, "unit": self.unit,
            "interval": list(self.interval), "sets": [c.to_dict() for c in self.checked],
        }  # fmt: skip


def interval_of(
    effect: type[Effect], added: Mapping[str, Any] | None = None
) -> tuple[float, float]:
    """The interval of the size, from the file of a proposal; of an effect of the library from the
    numbers with which it was added."""
    found = getattr(effect, "interval", None)
    if found is None and not effect.file and added:
        found = tuple(added.get("interval", ()))
    if not isinstance(found, tuple) or len(found) != 2:
        raise FlatplankError(
            "has no interval to compare with", f"effect {effect.identifier}",
            "write 'interval = (low, high)' with the 90 % interval that `flatplank add` prints",
        )  # fmt: skip
    return float(found[0]), float(found[1])


def fit_with_effect(
    session: Session, model: ModelFile | None, name: str
) -> tuple[Step, tuple[float, float]]:
    """Fit of the first campaign with the effect in its model, and the interval of its size."""
    effect = session.effects[name]
    if model is not None and any(e.name == name for e in model.effects):
        added = [line for line in model.history if line.get("effect") == name]
        return session.fit(model), interval_of(effect, added[-1] if added else None)
    _, step, numbers = session.add(model or ModelFile(), name)
    return step, interval_of(effect, numbers)


def new_sessions(
    session: Session, folders: Sequence[str], mapping: Any = None
) -> list[tuple[str, Session]]:
    """Sessions of the folders with new runs; FlatplankError when a run took part in the search,
    under whatever name and in whatever format."""
    opened = [(folder, session.beside(folder, mapping)) for folder in folders]
    for folder, new in opened:
        if shared := shared_runs(new.campaign.runs, session.campaign.runs):
            file, same = shared[0]
            more = f" and {len(shared) - 1} more" if len(shared) > 1 else ""
            what = f"are the runs of the search: {file} is {same}{more}"
            raise FlatplankError(what, folder, "measure new runs: their own folder")
    return opened


def confirm(
    session: Session, fitted: tuple[Step, tuple[float, float]], name: str,
    sets: Sequence[tuple[str, Session]],
) -> Confirmation:  # fmt: skip
    """Test an effect of a fitted model, see `fit_with_effect`, on sets of new runs, see
    `new_sessions`."""
    effect = session.effects[name]
    step, interval = fitted
    checked = tuple(
        _checked(session.model, step, effect, interval, folder, new.model) for folder, new in sets
    )
    return Confirmation(name, effect.main_parameter().unit, interval, checked)


def _checked(
    old: TireModel, step: Step, effect: type[Effect], interval: tuple[float, float], folder: str,
    new: TireModel,
) -> CheckedRuns:  # fmt: skip
    if new.runs.contradicted:
        raise FlatplankError("; ".join(new.runs.contradicted), folder)
    count = new.runs.runs
    if count < LEAST_RUNS:
        raise FlatplankError(f"{count} runs are too few", folder, f"measure at least {LEAST_RUNS}")
    new.take_references(old)
    fit = step.state.fit
    at = max(i for i, t in enumerate(fit.terms) if t.effect.identifier == effect.identifier)
    size, half, before, error = _sized(old, new, step.state, at)
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
    return CheckedRuns(folder, count, size, half, before, error, limit, tuple(reasons))


def _sized(
    old: TireModel, new: TireModel, state: State, at: int
) -> tuple[float, float, float, float]:
    """Size, half of its interval, and the error of Fx without and with the effect."""
    fit = state.fit
    term = fit.terms[at]
    others = tuple((t.effect, t.values) for i, t in enumerate(fit.terms) if i != at)
    off = invariants.at_null(term).values
    parameters = {p.name: p for p in old.parameters}
    names, known = _known(state)
    zero = [{"fx_zero": 1.0}] if "fx_zero" in parameters else []
    loose = (*zero, *old.scatter_directions(fit.base))
    moves = [*loose, *({n: scale_of(parameters[n])} for n in names)]
    at_name = {name: i for i, name in enumerate(parameters)}
    sets = [ParameterSet(fit.base, (*others, (term.effect, v))) for v in (off, term.values)]
    for move in moves:
        base = fit.base.copy()
        for name, change in move.items():
            base[at_name[name]] += STEP * change
        sets.append(ParameterSet(base, (*others, (term.effect, off))))
    predicted = new.predict(sets)
    columns = predicted[1:] - predicted[0]
    columns[1:] /= STEP
    rest = new.runs.measured - predicted[0]
    count = 1 + len(loose)
    metric = _metric(state, new, columns[2:count])
    products, scores, energy = metric.gram(rest, columns).total()
    raw = float(products[0, 0])
    products[count:, count:] += known
    share, inverse = solve(products, scores)
    spare = new.runs.runs * len(metric.whitener.picks) * len(new.runs.channels)
    kappa = max((energy - float(share @ scores)) / spare, 1.0)
    half = np.inf
    if raw > 0.0 and inverse[0, 0] > 0.0:
        # error of the law's form, as in the search
        visible = min(1.0 / (float(inverse[0, 0]) * raw), 1.0)
        form = FORMS[0] ** 2 / max(visible, 1e-9)
        half = NORMAL_90 * float(np.sqrt(kappa * inverse[0, 0] + form))
    errors = _errors(rest[0], columns[:count, 0], share[0])
    return float(share[0]) * term.size, abs(half * term.size), *errors


def _known(state: State) -> tuple[list[str], np.ndarray]:
    """Names of the base parameters and their information (scaled) from the first campaign, with
    the effects projected out."""
    fit = state.whitened.fit
    loose = fit.loose()
    own = [i for i, row in enumerate(loose) if fit.free[row][0] < 0]
    rest = [i for i in range(len(loose)) if i not in own]
    gram = state.gram(fit.residual(state.runs.measured), fit.jacobian[loose])
    products, scores, _ = gram.total()
    cross = products[np.ix_(own, rest)]
    _, inverse = solve(products[np.ix_(rest, rest)], scores[rest])
    known = products[np.ix_(own, own)] - cross @ inverse @ cross.T
    return [fit.free[loose[i]][1] for i in own], known


def _metric(state: State, new: TireModel, directions: np.ndarray) -> Metric:
    """Metric with noise and scatter of the first campaign, for runs of another one."""
    runs, whitener = state.runs, state.metric.whitener
    own = scatter_columns(state.model, state.whitened.fit)
    scatter = scatter_of(runs, whitener, runs.contrast(state.residual), own)
    even = np.ones(new.runs.runs)
    keep = [runs.channels.index(c) for c in new.runs.channels]
    noises = [replace(whitener.noises[c], scale=even) for c in keep]
    return Metric(make_whitener(new.runs, noises), directions, scatter)


def _errors(rest: np.ndarray, columns: np.ndarray, share: float) -> tuple[float, float]:
    """Error of Fx without and with the effect; gain and slip offset of each run are removed, as in
    the floor.
    """
    sums = np.zeros(2)
    for r in range(len(rest)):
        loose = columns[1:, r].T
        for i, size in enumerate((0.0, share)):
            left = rest[r] - size * columns[0, r]
            left = left - loose @ np.linalg.lstsq(loose, left, rcond=None)[0]
            sums[i] += float(left @ left)
    before, after = np.sqrt(sums / rest.size)
    return float(before), float(after)
