# SPDX-License-Identifier: Apache-2.0
"""Rival methods that find a formula for the residual, from the same residual and coordinates.

A free spline (additive, penalised, the penalty by generalised cross-validation), sparse regression
(sequentially thresholded least squares over a list of terms, the threshold by BIC), and genetic
programming (pyoperon). Each claims a force over the coordinates of a run. None of them knows the
hooks of the model, so all are judged by the force that they claim.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.proposal.curves import hat_functions
from flatplank_data.errors import FlatplankError
from flatplank_validation.blind.detectable import cache

KNOTS, PENALTIES = 14, np.geomspace(1e-3, 1e5, 9)
THRESHOLDS, ROUNDS = np.geomspace(0.02, 0.6, 8), 10
WAVES, TURNS = 20, 4
"""terms of the list: largest number of waves over a position, and per turn"""
ROWS = 2500
"""largest number of samples for the fit of a rival"""
EVALUATIONS, LENGTH = 100_000, 25
"""genetic programming: number of formulas, and their largest length"""
SYMBOLS = "add,sub,mul,aq,sin,cos,exp,abs,constant,variable"
SIDES = ("", "driving", "braking")
PACKAGES = cache().parent / "rivals"
"""folder with the packages of requirements/rivals.txt, which are not part of the environment"""


@dataclass(frozen=True)
class Inputs:
    """Coordinates of some runs, each flattened to (samples,)."""

    values: Mapping[str, np.ndarray]
    kinds: Mapping[str, str]
    """place, angle, level or signal"""
    sides: Mapping[str, np.ndarray]
    """condition -> modulating factor"""


@dataclass(frozen=True)
class Claim:
    """Claim of a rival: a force over the coordinates."""

    force: Callable[[Inputs], np.ndarray]
    coordinates: tuple[str, ...]
    """named coordinates"""
    shape: str = ""
    """form of the grammar; empty when it names none"""


@dataclass(frozen=True)
class _Scale:
    middle: float
    half: float

    @classmethod
    def of(cls, u: np.ndarray) -> _Scale:
        low, high = float(u.min()), float(u.max())
        return cls(0.5 * (low + high), max(0.5 * (high - low), 1e-12))

    def __call__(self, u: np.ndarray) -> np.ndarray:
        return (u - self.middle) / self.half


Columns = list[tuple[str, str, np.ndarray]]
"""(coordinate, form, values of shape (k, samples))"""


def spline(seen: Inputs, rest: np.ndarray) -> Claim:
    """Additive curves over every coordinate, for all slips and for each sign of slip."""
    knots = {n: np.linspace(u.min(), u.max(), KNOTS) for n, u in seen.values.items()}

    def columns(x: Inputs) -> Columns:
        out = []
        for name, u in x.values.items():
            hats = hat_functions(u, knots[name])
            out += [(name, side, hats * x.sides[side]) for side in SIDES]
        return out

    made = columns(seen)
    a = np.concatenate([c for _, _, c in made])
    bend = np.diff(np.eye(KNOTS), 2, axis=0)
    penalty = np.kron(np.eye(len(made)), bend.T @ bend) + 1e-6 * np.eye(len(a))
    gram, score = a @ a.T, a @ rest
    best, least = np.zeros(len(a)), np.inf
    for strength in PENALTIES:
        inverse = np.linalg.inv(gram + strength * penalty)
        sizes = inverse @ score
        free = rest.size - float(np.sum(inverse * gram))
        value = float(np.sum((rest - sizes @ a) ** 2)) / max(free, 1.0) ** 2
        if value < least:
            best, least = sizes, value
    parts: dict[str, np.ndarray] = {}
    for i, (name, _, c) in enumerate(made):
        own = best[i * KNOTS : (i + 1) * KNOTS] @ c
        parts[name] = parts.get(name, 0.0) + own
    largest = max(parts, key=lambda n: float(np.std(parts[n])))

    def force(x: Inputs) -> np.ndarray:
        return best @ np.concatenate([c for _, _, c in columns(x)])

    return Claim(force, (largest,))


def sparse(seen: Inputs, rest: np.ndarray) -> Claim:
    """Sequentially thresholded least squares over powers, absolute values and waves of every
    coordinate."""
    scales = {n: _Scale.of(u) for n, u in seen.values.items()}

    def columns(x: Inputs) -> Columns:
        out: Columns = []
        for name, u in x.values.items():
            for shape, values in _terms(scales[name](u), u, x.kinds[name]):
                out += [(name, shape, (values * x.sides[side])[None]) for side in SIDES]
        return out

    made = columns(seen)
    a = np.concatenate([c for _, _, c in made])
    middle = a.mean(axis=1, keepdims=True)
    spread = np.maximum(a.std(axis=1, keepdims=True), 1e-12)
    z, y = (a - middle) / spread, rest - rest.mean()
    alive = (a.std(axis=1) > 1e-9).nonzero()[0]
    best, least = np.zeros(len(a)), np.inf
    for share in THRESHOLDS:
        sizes = _thresholded(z, y, alive, share)
        count = int(np.count_nonzero(sizes))
        value = y.size * np.log(np.mean((y - sizes @ z) ** 2)) + count * np.log(y.size)
        if value < least:
            best, least = sizes, float(value)
    first = int(np.argmax(np.abs(best)))

    def force(x: Inputs) -> np.ndarray:
        b = np.concatenate([c for _, _, c in columns(x)])
        return best @ ((b - middle) / spread)

    return Claim(force, (made[first][0],), made[first][1])


def _terms(z: np.ndarray, u: np.ndarray, kind: str) -> list[tuple[str, np.ndarray]]:
    """Terms of one coordinate; z is u scaled to -1 .. 1 over the fitted range."""
    pair = (np.cos, np.sin)
    if kind == "angle":
        return [(f"harmonic {n}", f(n * u)) for n in range(1, TURNS + 1) for f in pair]
    out = [("ramp", z), ("power", z**2), ("power", z**3), ("size", np.abs(z))]
    if kind == "place":
        out += [("wave", f(np.pi * n * z)) for n in range(1, WAVES + 1) for f in pair]
    return out


def _thresholded(z: np.ndarray, y: np.ndarray, alive: np.ndarray, share: float) -> np.ndarray:
    """Coefficients, repeatedly dropping those below a share of the largest one."""
    sizes = np.zeros(len(z))
    keep = alive
    for _ in range(ROUNDS):
        own = z[keep]
        found = np.linalg.solve(own @ own.T + 1e-6 * y.size * np.eye(len(keep)), own @ y)
        stay = np.abs(found) >= share * np.abs(found).max()
        sizes[:] = 0.0
        sizes[keep] = found
        if stay.all():
            break
        keep = keep[stay]
    return sizes


def genetic(seen: Inputs, rest: np.ndarray) -> Claim:
    """Formulas of the coordinates and conditions, by genetic programming with pyoperon."""
    if str(PACKAGES) not in sys.path:  # after the packages of the environment
        sys.path.append(str(PACKAGES))
    try:
        from pyoperon.sklearn import SymbolicRegressor
    except ImportError as error:
        raise FlatplankError(
            "genetic programming needs the package pyoperon", "bench-propose --rivals",
            "install requirements/rivals.txt as docs/guide/propose.md has it",
        ) from error  # fmt: skip
    names = [*seen.values, *SIDES[1:]]
    scales = {n: _Scale.of(u) for n, u in seen.values.items() if seen.kinds[n] != "angle"}

    def table(x: Inputs) -> np.ndarray:
        rows = [scales[n](u) if n in scales else u for n, u in x.values.items()]
        return np.stack([*rows, *(x.sides[s] for s in SIDES[1:])], axis=1)

    model = SymbolicRegressor(
        allowed_symbols=SYMBOLS, max_evaluations=EVALUATIONS, max_length=LENGTH, random_state=1,
        population_size=500, n_threads=1,
    )  # fmt: skip
    model.fit(table(seen), rest)
    text = model.get_model_string(model.model_, 4)
    used = dict.fromkeys(names[int(i) - 1] for i in re.findall(r"X(\d+)", text))

    def force(x: Inputs) -> np.ndarray:
        return np.nan_to_num(np.asarray(model.predict(table(x)), dtype=float))

    return Claim(force, tuple(n for n in used if n in seen.values))


RIVALS: dict[str, Callable[[Inputs, np.ndarray], Claim]] = {
    "free spline": spline,
    "sparse regression": sparse,
    "genetic programming": genetic,
}
