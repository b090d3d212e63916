# SPDX-License-Identifier: Apache-2.0
"""Rival methods of a typical user, on the same campaigns with the same base model and candidates.

`lmfit + BIC`: forward selection. The candidate whose column explains most of the error is fitted
with lmfit and kept while BIC falls, for the effective number of samples of the correlated
residual. `10 % rule`: the same loop, but a term is kept when it reduces the RMSE of Fx by a tenth.
Both name the other candidates with nearly the same column, and compare the residual with the
scatter of the repeats for their verdict.
"""

from __future__ import annotations

import fnmatch
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np

from flatplank_analysis.contact_patch.data import from_tables
from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.discovery.fit import Fit, Fitter, Task, Term
from flatplank_analysis.discovery.gram import solve
from flatplank_analysis.discovery.state import (
    Candidate,
    channel_weights,
    make_candidates,
    start_base,
    term_of,
)
from flatplank_analysis.effects.registry import library
from flatplank_analysis.identify.results import NORMAL_90
from flatplank_sim.sealed.score import GROUP, LARGEST_CLASS, LAW
from flatplank_validation.blind import journal
from flatplank_validation.blind.cases import Case, make
from flatplank_validation.blind.lists import full

MOST = 6
"""largest number of terms"""
LEVELS = {"fx": 10.0, "fy": 8.0, "fz": 9.0}
"""noise levels of the channels that a user would assume as weights [N]"""
CUT, ALIKE, AT_FLOOR = 0.10, 0.95, 1.2
"""limits: reduction of RMSE, correlation of columns, RMSE over scatter of the repeats [-]"""
CLASSES = ("none/*", "single/*/c3/*", "outside/*/x4/*", "pair/*")
"""classes whose campaigns are judged in turn, since the rivals are slow"""


@dataclass(frozen=True)
class Kept:
    """A model of a rival with its terms."""

    fit: Fit
    spread: dict[int, float]
    """term -> standard error of its size"""


Refit = Callable[[Fitter, Fit, Term], Kept]
Keep = Callable[[TireModel, Fit, Fit], bool]


def our_refit(fitter: Fitter, fit: Fit, term: Term) -> Kept:
    """Fit all parameters jointly with our Gauss-Newton."""
    new = fitter.fit(fit.base, [*fit.terms, term])
    return Kept(new, _spread(fitter, new))


def lmfit_refit(fitter: Fitter, fit: Fit, term: Term) -> Kept:
    """Fit all parameters jointly with lmfit (Levenberg-Marquardt), with its standard errors."""
    import lmfit

    terms = [*fit.terms, term]
    task = Task(fitter, fit.base, terms)
    z = np.clip(task.pack(fit.base, terms), task.lower + 1e-9, task.upper - 1e-9)
    runs = fitter.model.runs
    given = lmfit.Parameters()
    for i, value in enumerate(z):
        given.add(f"p{i}", value=float(value), min=float(task.lower[i]), max=float(task.upper[i]))

    def residual(p) -> np.ndarray:
        now = np.array([p[f"p{i}"].value for i in range(len(z))])
        predicted = fitter.model.predict([task.parameter_set(now)])[0]
        return ((runs.measured - predicted) * fitter.weight).ravel()

    done = lmfit.minimize(
        residual, given, method="leastsq", epsfcn=1e-7, ftol=1e-5, max_nfev=12 * (len(z) + 1)
    )
    found = np.array([done.params[f"p{i}"].value for i in range(len(z))])
    one = task.parameter_set(found)
    terms = [replace(t, values=v) for t, (_, v) in zip(terms, one.effects, strict=True)]
    predicted = fitter.model.predict([one])[0]
    new = replace(fit, base=one.base, terms=tuple(terms), predicted=predicted)
    new = fitter.derivative(new)
    free = tuple((e.term, e.parameter.name) for e in task.entries)
    new = replace(new, free=free)
    spread = {}
    for i, e in enumerate(task.entries):
        main = terms[e.term].effect.main_parameter() if e.term >= 0 else None
        error = done.params[f"p{i}"].stderr
        if main is not None and e.parameter.name == main.name and error is not None:
            spread[e.term] = float(error) * e.scale
    return Kept(new, spread)


def _error(model: TireModel, fit: Fit) -> float:
    """Sum of squares, weighted with LEVELS."""
    level = np.array([LEVELS[c] for c in model.runs.channels])[:, None, None]
    return float(np.sum((fit.residual(model.runs.measured) / level) ** 2))


def samples_of(residual: np.ndarray) -> float:
    """Effective number of samples in residuals (channels, runs, samples), by their
    autocorrelation."""
    e = residual - residual.mean(axis=-1, keepdims=True)
    alike = float(np.sum(e[..., 1:] * e[..., :-1]) / np.sum(e * e))
    alike = min(max(alike, 0.0), 0.999)
    return residual.size * (1.0 - alike) / (1.0 + alike)


def bic_falls(model: TireModel, old: Fit, new: Fit) -> bool:
    """True when BIC falls, with unknown noise level and the correlation of the residual."""
    n = samples_of(new.residual(model.runs.measured))
    grown = len(new.free) - len(old.free)
    return n * math.log(_error(model, new) / _error(model, old)) + grown * math.log(n) < 0.0


def error_falls(model: TireModel, old: Fit, new: Fit) -> bool:
    """True when the RMSE of Fx falls by a tenth."""
    before = model.runs.rmse(old.residual(model.runs.measured)[0])
    return model.runs.rmse(new.residual(model.runs.measured)[0]) < (1.0 - CUT) * before


RIVALS: dict[str, tuple[Refit, Keep]] = {
    "lmfit + BIC": (lmfit_refit, bic_falls),
    "10 % rule": (our_refit, error_falls),
}


def forward(model: TireModel, refit: Refit, keep: Keep) -> dict[str, Any]:
    """Diagnosis of a rival, with its effects in the order of selection."""
    weight = channel_weights(model, [LEVELS[c] for c in model.runs.channels])
    fitter = Fitter(model, weight)
    fit = fitter.fit(start_base(model))
    spread: dict[int, float] = {}
    classes: list[list[str]] = []
    effects = list(library().values())
    while len(fit.terms) < MOST:
        term, alike = _best(model, fitter, fit, effects)
        if term is None:
            break
        kept = refit(fitter, fit, term)
        if not keep(model, fit, kept.fit):
            break
        fit, spread = kept.fit, kept.spread
        classes.append(alike)
    named = [_entry(i, t, spread.get(i, 0.0), classes[i]) for i, t in enumerate(fit.terms)]
    return {
        "effects": named, "unexplained": {}, "floor_rmse": None, "held_out_after": None,
        "verdict": verdict(named, *_left(model, fit)),
    }  # fmt: skip


def _left(model: TireModel, fit: Fit) -> tuple[float, float]:
    """RMSE of Fx and scatter of its repeats [N]."""
    e = fit.residual(model.runs.measured)[0]
    condition = model.runs.condition
    apart, count = 0.0, 0
    for c in np.unique(condition):
        own = e[condition == c]
        apart += float(np.sum((own - own.mean(axis=0)) ** 2))
        count += (len(own) - 1) * own.shape[1]
    return model.runs.rmse(e), math.sqrt(apart / max(count, 1))


def verdict(named: Sequence[Mapping[str, Any]], left: float, floor: float) -> str:
    """Verdict in the terms of `flatplank diagnose`, as far as a rival can give one."""
    faults = [n for n in named if n["name"] != LAW]
    if left > AT_FLOOR * floor:
        return "partly" if faults else "none of these"
    if not faults:
        return "tire law only" if named else "at floor"
    return GROUP if any(n["class"] for n in faults) else "found"


def _entry(index: int, term: Term, error: float, alike: list[str]) -> dict[str, Any]:
    half = NORMAL_90 * error
    return {
        "name": term.effect.identifier,
        "size": term.size,
        "class": alike,
        "interval": [term.size - half, term.size + half],
        "unit": term.effect.main_parameter().unit,
    }


def _best(
    model: TireModel, fitter: Fitter, fit: Fit, effects: Sequence[type]
) -> tuple[Term | None, list[str]]:
    """The candidate whose columns explain most of the squared error with a free base, and the
    effects with nearly the same columns."""
    residual = fit.residual(model.runs.measured)
    weight = fitter.weight
    base = (fit.jacobian * weight).reshape(len(fit.jacobian), -1)
    inverse = solve(base @ base.T, base @ (residual * weight).ravel())[1]
    best: tuple[float, Candidate, np.ndarray] | None = None
    columns: list[tuple[str, np.ndarray]] = []
    direction = np.zeros(residual.size)
    e = (residual * weight).ravel()
    for candidate in make_candidates(model, fit, effects, residual):
        s = (candidate.columns * weight).reshape(len(candidate.columns), -1)
        s = s - (s @ base.T) @ inverse @ base
        sizes, _ = solve(s @ s.T, s @ e)
        gain = float(2.0 * sizes @ (s @ e) - sizes @ (s @ s.T) @ sizes)
        term = term_of(candidate, sizes)
        columns.append((term.effect.identifier, s))
        if gain > (best[0] if best else 0.0) and term.size != 0.0:
            best = (gain, candidate, sizes)
            direction = sizes @ s
    if best is None:
        return None, []
    winner = term_of(best[1], best[2])
    return winner, alike_with(direction, columns, winner.effect.identifier)


def alike_with(
    direction: np.ndarray, columns: Sequence[tuple[str, np.ndarray]], name: str
) -> list[str]:
    """Other effects whose columns correlate with a direction, the nearest first."""
    near: dict[str, float] = {}
    for other, s in columns:
        sizes, _ = solve(s @ s.T, s @ direction)
        part = float(direction @ (sizes @ s)) / float(direction @ direction)
        if other not in (name, LAW) and part > ALIKE**2:
            near[other] = max(part, near.get(other, 0.0))
    return sorted(near, key=lambda n: -near[n])[: LARGEST_CLASS - 1]


def _spread(fitter: Fitter, fit: Fit) -> dict[int, float]:
    """Textbook standard errors of the sizes."""
    flat = (fit.jacobian * fitter.weight).reshape(len(fit.jacobian), -1)
    e = (fit.residual(fitter.model.runs.measured) * fitter.weight).ravel()
    _, covariance = solve(flat @ flat.T, flat @ e)
    scale = float(e @ e) / (len(e) - len(flat))
    out = {}
    for i, (term, name) in enumerate(fit.free):
        if term >= 0 and fit.terms[term].effect.main_parameter().name == name:
            p = fit.terms[term].effect.main_parameter()
            out[term] = math.sqrt(max(covariance[i, i] * scale, 0.0)) * abs(p.screen or 1.0)
    return out


def judge(case: Case, seed: int) -> dict[str, Any] | None:
    """Diagnose one campaign with our search and both rivals."""
    made = make(case, seed)
    if made is None:
        return None
    tables, answer = made
    entry: dict[str, Any] = {
        "key": case.key, "seed": seed, "code": journal.code_version(),
        "kit": journal.kit_version(),
        "case": asdict(case), "answer": answer, "ways": {"ours": journal.diagnose(tables)},
    }  # fmt: skip
    model = TireModel(from_tables(tables))
    for name, (refit, keep) in RIVALS.items():
        entry["ways"][name] = forward(model, refit, keep)
    return entry


def subset(seed: int) -> list[Case]:
    """Campaigns for the comparison, the classes in turn."""
    cases = full(seed)
    rows = zip_longest(*([c for c in cases if fnmatch.fnmatch(c.key, p)] for p in CLASSES))
    return [case for row in rows for case in row if case is not None]


def side_by_side(
    seed: int,
    path: Path,
    only_read: bool = False,
    limit: int | None = None,
    any_code: bool = False,
    progress: journal.Progress = lambda _done, _all, _key: None,
) -> list[dict[str, Any]]:
    """Judge the campaigns that the journal lacks; returns all entries."""
    known = journal.of_this_code(journal.read(path), seed, any_code)
    cases = subset(seed)[:limit]
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", encoding="utf-8") as stream:
        for done, case in enumerate(cases, start=1):
            if only_read or case.key in known:
                continue
            entry = judge(case, seed)
            if entry is not None:
                stream.write(json.dumps(entry) + "\n")
                stream.flush()
                known[case.key] = entry
            progress(done, len(cases), case.key)
    return list(known.values())
