# SPDX-License-Identifier: Apache-2.0
"""The size of an effect that can be found with 80 % power at a family-wise level of 5 %.

Computed by the generator from its own noise and its own tire, never by what diagnoses: the change
of all forces by the effect, what a fit of the tire can imitate taken out, weighed with the
covariance of the noise and of the tire's scatter from run to run.
"""

from __future__ import annotations

import hashlib
import math
import os
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.stats import norm

import flatplank_hw.plant
from flatplank_control.blind.menu import MENU
from flatplank_control.blind.plan import NOISES, RELATIVE, STEP, covariance, runs_of
from flatplank_control.blind.second import Columns
from flatplank_control.blind.worlds import WORLDS, Scatter, World

COLUMNS = 100
"""effects that are looked at: the level is divided by it"""
NEEDED = float((norm.isf(0.05 / COLUMNS / 2.0) + norm.isf(0.2)) ** 2)
PLACES = np.arange(0.02, 4.1, 0.04)
CHANNELS = ("fx", "fy", "fz")
ROUNDS = 4
NO_PART = ("page.py", "points.py", "journal.py", "rivals.py", "markdown.py")
"""files of the kit that the campaigns do not depend on"""
CLEAR = 1.5
"""a size must be so far above the one of no consequence that noise does not carry it below"""


VISIBLE = 0.03
"""share of the change that must be left beside a fit of the tire"""


def _blocks(runs: list[Columns]) -> np.ndarray:
    """Forces at places of the plank (runs, channels, places); the load without its run mean."""
    out = []
    for c in runs:
        rows = [np.interp(PLACES, c["plank_position"], c[name]) for name in CHANNELS]
        rows[2] = rows[2] - rows[2].mean()
        out.append(rows)
    return np.array(out)


class _Lot:
    """A world and a design without noise, with what a tire's fit and scatter can imitate."""

    def __init__(self, world: World, design: str, noise: str, scatter: float) -> None:
        self.world, self.runs = world, runs_of(design, np.random.default_rng(5))
        self.plain = self.blocks(world, {})
        columns = [
            self.blocks(world.changed(change), {}) - self.plain for change in world.nuisances()
        ]
        columns += self._shifts() + self._laws()
        self.base = np.array(columns)
        gain = Scatter.none(len(self.runs))
        more = Scatter(gain.gain + 0.01, gain.delay, gain.bumps)
        loose = (_blocks(world.run(self.runs, {}, _random(), more)) - self.plain) * scatter / 0.01
        spacing = float(PLACES[1] - PLACES[0]) / 0.0309
        noises = covariance(NOISES[noise], PLACES / 0.0309, spacing)
        self.factors = [
            [
                cho_factor(RELATIVE[name] ** 2 * noises + np.outer(g, g))
                for name, g in zip(CHANNELS, rows, strict=True)
            ]
            for rows in loose
        ]

    def blocks(self, world: World, sizes) -> np.ndarray:
        return _blocks(world.run(self.runs, sizes, _random(), Scatter.none(len(self.runs))))

    def _shifts(self) -> list[np.ndarray]:
        """A constant pull in each force."""
        out = []
        for channel in range(2):
            one = np.zeros_like(self.plain)
            one[:, channel] = 1.0
            out.append(one)
        return out

    def _laws(self) -> list[np.ndarray]:
        """Another force at one size of slip, the same in both directions: a force law may be of
        any symmetric form."""
        out = []
        after = PLACES > STEP
        sizes = np.array([abs(run.setting.kappa) for run in self.runs])
        for level in sorted(set(sizes[sizes > 0.0])):
            one = np.zeros_like(self.plain)
            one[sizes == level, 0] = 0.01 * self.plain[sizes == level, 0] * after
            out.append(one)
        return out

    def strength(self, change: np.ndarray) -> float:
        """Noncentrality of a change once the tire's fit has taken its part."""
        columns = np.concatenate([self.base, change[None]])
        m = len(columns)
        products = np.zeros((m, m))
        for r, factors in enumerate(self.factors):
            for c, factor in enumerate(factors):
                s = columns[:, r, c]
                products += s @ cho_solve(factor, s.T)
        scale = np.sqrt(np.maximum(np.diag(products), 1e-30))
        work = products / np.outer(scale, scale)
        inner = work[:-1, :-1] + 1e-9 * np.eye(m - 1)
        left = work[-1, -1] - work[-1, :-1] @ np.linalg.solve(inner, work[:-1, -1])
        # what a fit of the tire imitates but for a small rest is invisible
        return float(left) * scale[-1] ** 2 if left > VISIBLE else 0.0


def _random() -> np.random.Generator:
    """Places and phases of the reference campaign."""
    return np.random.default_rng(11)


@lru_cache(maxsize=64)
def _lot(world: str, design: str, noise: str, scatter: float) -> _Lot:
    return _Lot(WORLDS[world](None), design, noise, scatter)


@lru_cache(maxsize=1024)
def detectable(
    world: str, name: str, noise: str = "usual", scatter: float = 0.01, design: str = ""
) -> float:
    """Detectable size of an effect; infinite when these runs cannot show it.

    Kept in a file beside the journals: it takes seconds each.
    """
    design = design or MENU[name].design
    key = f"{world}/{name}/{noise}/{scatter:g}/{design}"
    path = cache() / f"detectable-{kit_version()}.txt"
    if path.is_file():
        for line in path.read_text(encoding="utf-8").splitlines():
            if line.startswith(key + " ") and line.endswith(";"):
                return float(line.split()[1])
    found = _computed(world, name, noise, scatter, design)
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", encoding="utf-8") as stream:
        stream.write(f"{key} {found!r} ;\n")
    return found


def cache() -> Path:
    """Folder of the journals and of what takes long to compute."""
    return Path(os.environ.get("FLATPLANK_ROOT", ".")) / ".cache" / "blind"


@lru_cache(maxsize=1)
def kit_version() -> str:
    """Fingerprint of what makes the campaigns and their sizes."""
    digest = hashlib.sha256()
    for folder in (Path(__file__).parent, Path(flatplank_hw.plant.__file__).parent):
        for source in sorted(folder.rglob("*.py")):
            if source.name not in NO_PART:
                digest.update(source.read_bytes())
    return digest.hexdigest()[:12]


def _computed(world: str, name: str, noise: str, scatter: float, design: str) -> float:
    item = MENU[name]
    lot = _lot(world, design, noise, scatter)
    size = item.typical
    if item.least == item.most:
        change = lot.blocks(lot.world, {name: size}) - lot.plain
        return size if lot.strength(change) > NEEDED else math.inf
    for _ in range(ROUNDS):
        change = lot.blocks(lot.world, {name: size}) - lot.plain
        found = lot.strength(change)
        if found <= 0.0:
            return math.inf
        # plays and gaps do not grow in proportion: approach in steps
        size *= float(np.clip(math.sqrt(NEEDED / found), 0.2, 5.0))
        if size > 20.0 * item.most:
            return math.inf
    return max(size, CLEAR * item.least)
