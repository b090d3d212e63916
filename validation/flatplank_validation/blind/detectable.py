# SPDX-License-Identifier: Apache-2.0
"""Computes the size of an effect that can be found with 80 % power at a family-wise level of 5 %.

It uses the noise and the tire of the generator, never code of the diagnosis. The strength of an
effect is the change of all forces, without the part that a fit of the tire can imitate, weighted
with the covariance of the noise and of the tire's scatter from run to run.
"""

from __future__ import annotations

import math
import os
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.stats import norm

import flatplank_sim.plant
from flatplank_sim.sealed import conditions, menu
from flatplank_sim.sealed.conditions import STEP, Columns
from flatplank_sim.sealed.menu import Force
from flatplank_validation.blind.fingerprint import fingerprint
from flatplank_validation.blind.kept import kept
from flatplank_validation.blind.menu import MENU
from flatplank_validation.blind.noise import NOISES, RELATIVE, covariance
from flatplank_validation.blind.plan import runs_of
from flatplank_validation.blind.worlds import WORLDS, Scatter

COLUMNS = 100
"""number of tested effects, by which the significance level is divided"""
NEEDED = float((norm.isf(0.05 / COLUMNS / 2.0) + norm.isf(0.2)) ** 2)
PLACES = np.arange(0.02, 4.1, 0.04)
CHANNELS = ("fx", "fy", "fz")
ROUNDS, CLOSE = 12, 0.02
"""largest number of iterations for the detectable size, and their relative tolerance"""
VISIBLE, SHIFTS = 0.03, 2
"""smallest part of the change (without a constant force) that a fit of the tire must not imitate;
number of forces that may have a constant offset"""
REST, CREST, SHARES, CREST_PLACES = 0.3, 1.0, (0.0012, 0.002), 5
"""a force outside the library is of consequence above these multiples of the noise floor, for its
mean over all runs and for its peak, and above these shares of the largest force
(docs/explanation/diagnosis.md); grid points of a peak"""
NO_PART = (
    "page.py", "tables.py", "points.py", "journal.py", "rivals.py", "rival_scores.py",
    "markdown.py", "nulls.py", "fingerprint.py", "plain_size.py", "kept.py",
)  # fmt: skip
"""files of the kit that do not affect the campaigns"""
SHARED = tuple(Path(str(m.__file__)) for m in (conditions, menu))
"""modules of sealed challenges that the kit uses"""


def _blocks(runs: list[Columns]) -> np.ndarray:
    """Forces at plank positions, shape (runs, channels, positions); the load without its mean per
    run."""
    out = []
    for c in runs:
        rows = [np.interp(PLACES, c["plank_position"], c[name]) for name in CHANNELS]
        rows[2] = rows[2] - rows[2].mean()
        out.append(rows)
    return np.array(out)


class NoiseFree:
    """Noise-free campaign of a world and a design, with the changes that a fit of its tire can
    imitate."""

    def __init__(self, world: str, design: str) -> None:
        self.world, self.runs = WORLDS[world](None), runs_of(design, np.random.default_rng(5))
        self.columns = self.run({})
        self.plain = _blocks(self.columns)
        columns = [
            _blocks(self.run({}, self.world.changed(change))) - self.plain
            for change in self.world.nuisances()
        ]
        self.base = np.array(columns + self._laws() + self._shifts())

    def run(self, sizes, world=None, scatter=None) -> list[Columns]:
        scatter = scatter or Scatter.none(len(self.runs))
        return (world or self.world).run(self.runs, sizes, np.random.default_rng(11), scatter)

    def change(self, name: str, size: float) -> np.ndarray:
        """Change of the forces by the effect alone; the reference has its side conditions, too."""
        return _blocks(self.run({name: size})) - _blocks(self.run({name: 0.0}))

    def pushed(self, force: Force) -> np.ndarray:
        """Change by an added longitudinal force."""
        moved = [
            c | {"fx": c["fx"] + force(c, run)}
            for c, run in zip(self.columns, self.runs, strict=True)
        ]
        return _blocks(moved) - self.plain

    def scattered(self) -> np.ndarray:
        """Change by one per cent of grip and tread stiffness in every run."""
        gain = Scatter.none(len(self.runs))
        more = Scatter(gain.gain + 0.01, gain.delay, gain.bumps)
        return _blocks(self.run({}, scatter=more)) - self.plain

    def _shifts(self) -> list[np.ndarray]:
        """A constant offset in each force."""
        out = []
        for channel in range(SHIFTS):
            one = np.zeros_like(self.plain)
            one[:, channel] = 1.0
            out.append(one)
        return out

    def _laws(self) -> list[np.ndarray]:
        """A change of the force at one amount of slip and side slip, the same for both signs: a
        force law may have any symmetric form in both directions."""
        slips = np.array([abs(run.setting.kappa) for run in self.runs])
        angles = np.array([abs(run.setting.alpha_deg) for run in self.runs])
        rolling = [
            (1, slips >= 0.0, angles == angle, PLACES > 0.0)
            for angle in sorted(set(angles[angles > 0.0]))
        ]
        pairs = sorted(set(zip(slips[slips > 0.0], angles[slips > 0.0], strict=True)))
        stepping = [
            (channel, slips == slip, angles == angle, PLACES > STEP)
            for slip, angle in pairs
            for channel in range(2 if angle else 1)
        ]
        out = []
        for channel, of_slip, of_angle, places in rolling + stepping:
            one, runs = np.zeros_like(self.plain), of_slip & of_angle
            one[runs, channel] = 0.01 * self.plain[runs, channel] * places
            out.append(one)
        return out


@lru_cache(maxsize=16)
def noise_free(world: str, design: str) -> NoiseFree:
    return NoiseFree(world, design)


@lru_cache(maxsize=64)
def factors_of(world: str, design: str, noise: str, scatter: float) -> list[list]:
    """Cholesky factors of the covariance, per run and channel."""
    spacing = float(PLACES[1] - PLACES[0]) / 0.0309
    noises = covariance(NOISES[noise], PLACES / 0.0309, spacing)
    loose = noise_free(world, design).scattered() * scatter / 0.01
    return [
        [
            cho_factor(RELATIVE[name] ** 2 * noises + np.outer(g, g))
            for name, g in zip(CHANNELS, rows, strict=True)
        ]
        for rows in loose
    ]


def strength(change: np.ndarray, base: np.ndarray, factors: list[list]) -> float:
    """Noncentrality of a change, without the part that the fit of the tire takes."""
    work, scale = _products(change, base, factors)
    # a constant offset is free; of the rest, a part must remain beside the fit of the tire
    rest = _left(work[-SHIFTS - 1 :, -SHIFTS - 1 :])
    left = _left(work)
    return left * scale**2 if left > VISIBLE * rest else 0.0


def distance(change: np.ndarray, base: np.ndarray, factors: list[list]) -> float:
    """Squared length of a change in units of the noise, beside the fit of the tire."""
    work, scale = _products(change, base, factors)
    return _left(work) * scale**2


def _products(
    change: np.ndarray, base: np.ndarray, factors: list[list]
) -> tuple[np.ndarray, float]:
    """Normalised products of the columns of the base and of a change, and the latter's length."""
    columns = np.concatenate([base, change[None]])
    m = len(columns)
    products = np.zeros((m, m))
    for r, row in enumerate(factors):
        for c, factor in enumerate(row):
            s = columns[:, r, c]
            products += s @ cho_solve(factor, s.T)
    scale = np.sqrt(np.maximum(np.diag(products), 1e-30))
    return products / np.outer(scale, scale), float(scale[-1])


def _left(products: np.ndarray) -> float:
    """Part of the last column that is independent of the others, 0 .. 1."""
    inner = products[:-1, :-1] + 1e-9 * np.eye(len(products) - 1)
    taken = np.linalg.solve(inner, products[:-1, -1])
    return float(products[-1, -1] - products[-1, :-1] @ taken)


def strength_of(
    world: str, name: str, size: float, noise: str, scatter: float, design: str
) -> float:
    """Noncentrality of an effect with this size."""
    clean = noise_free(world, design)
    change = clean.change(name, size)
    return strength(change, clean.base, factors_of(world, design, noise, scatter))


def detectable_force(
    world: str, force: Force, noise: str, scatter: float, design: str = "plain"
) -> float:
    """Factor by which a force of any form must be scaled to be detectable."""
    clean = noise_free(world, design)
    found = strength(clean.pushed(force), clean.base, factors_of(world, design, noise, scatter))
    return math.sqrt(NEEDED / found) if found > 0.0 else math.inf


def consequence_of_force(
    world: str, force: Force, noise: str, scatter: float, design: str = "plain"
) -> float:
    """Factor above which a force is of consequence, relative to the floor of noise and scatter."""
    clean = noise_free(world, design)
    pushed, own = clean.pushed(force)[:, 0], clean.plain[:, 0]
    slips = np.array([run.setting.kappa for run in clean.runs])
    level = covariance(NOISES[noise], PLACES[:1], float(PLACES[1] - PLACES[0]) / 0.0309)[0, 0]
    loose = clean.scattered()[:, 0] * scatter / 0.01
    floor = math.sqrt(RELATIVE["fx"] ** 2 * level + float(np.mean(loose**2)))
    largest = float(np.abs(own).max())
    smooth = np.ones(CREST_PLACES) / CREST_PLACES
    crests = [
        float(np.abs(np.convolve(pushed[rows].mean(axis=0), smooth, "valid")).max())
        for rows in (slips > -1.0, slips > 0.0, slips < 0.0)
    ]
    mean = max(REST * floor, SHARES[0] * largest) / math.sqrt(float(np.mean(pushed**2)))
    return min(mean, math.hypot(CREST * floor, SHARES[1] * largest) / max(crests))


@lru_cache(maxsize=4096)
def detectable(
    world: str, name: str, noise: str = "usual", scatter: float = 0.01, design: str = ""
) -> float:
    """Detectable size of an effect; infinite when these runs cannot show it.

    The results are cached in a file beside the journals, since each takes seconds.
    """
    design = design or MENU[name].design
    key = f"{world}/{name}/{noise}/{scatter:g}/{design}"
    path = cache() / f"detectable-{kit_version()}.txt"
    return kept(path, key, lambda: _computed(world, name, noise, scatter, design))


def cache() -> Path:
    """Folder of the journals and of cached results."""
    return Path(os.environ.get("FLATPLANK_ROOT", ".")) / ".cache" / "blind"


@lru_cache
def kit_version(further: tuple[Path, ...] = ()) -> str:
    """Fingerprint of the code that makes the campaigns and their sizes; further: files of it."""
    parts = (Path(__file__).parent, Path(flatplank_sim.plant.__file__).parent, *SHARED, *further)
    files = (f for part in parts for f in sorted(part.rglob("*.py")) or [part])
    return fingerprint(f for f in files if f.name not in NO_PART)


def _computed(world: str, name: str, noise: str, scatter: float, design: str) -> float:
    item = MENU[name]
    size = item.typical
    if item.least == item.most:
        found = strength_of(world, name, size, noise, scatter, design)
        return size if found > NEEDED else math.inf
    for _ in range(ROUNDS):
        found = strength_of(world, name, size, noise, scatter, design)
        if found <= 0.0:
            return math.inf
        # the effect of plays is not proportional to their size: iterate
        step = math.sqrt(NEEDED / found)
        if abs(step - 1.0) < CLOSE:
            break
        size *= min(max(step, 0.2), 5.0)
        if size > 20.0 * item.most:
            return math.inf
    return size
