# SPDX-License-Identifier: Apache-2.0
"""Campaigns without a hidden effect: how many diagnoses are at the noise floor at each noise
level, and how far the base model differs from tires of another form."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from flatplank_analysis.contact_patch.grid import SPEED
from flatplank_analysis.contact_patch.model import (
    LAW_AMONG_SETTINGS,
    STRETCH_WITH_SIDE_SLIP,
    TireModel,
)
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery import where
from flatplank_analysis.discovery.dispersion import scores_of
from flatplank_analysis.discovery.fit import Fit, Term, effect_contribution
from flatplank_analysis.discovery.gram import solve
from flatplank_analysis.discovery.model import form_error_of, same_law
from flatplank_analysis.discovery.state import State
from flatplank_analysis.discovery.verdict import AT_FLOOR, Diagnosis
from flatplank_analysis.effects.force_channel import TimeSkew
from flatplank_analysis.effects.force_law import DriveBrakeAsymmetry, DriveBrakeStiffness
from flatplank_analysis.effects.load import LoadLossBraking
from flatplank_data.table import MeasurementTable
from flatplank_validation.blind.cases import measured_table
from flatplank_validation.blind.noise import NOISES, RELATIVE, noise
from flatplank_validation.blind.plan import runs_of, runs_once
from flatplank_validation.blind.worlds import COMBINED, WORLDS, Scatter

LEVELS = (1.0, 3.0, 7.5, 15.0, 30.0)
"""standard deviation of the noise of Fx [N]"""
SCATTERS = (0.0, 0.01)
"""scatter of the tire from run to run, used in turn [-]"""
QUIET = 1.0
"""noise at which the form error of the base model is visible [N]"""
STRAIGHT = ("plant", "second", "third")
"""worlds that measure the error of the force law without side slip"""
SCATTERED, STILL = (7.5, 0.02), (QUIET, 0.0)
"""noise [N] and scatter: scatter hides an error in the size of a force, but not in its rise after
a step, nor in the direction of both forces; an error in how it follows the settings shows most
without scatter"""
LAW_WORLDS = {
    "plain": (STRAIGHT, (SCATTERED,)), "pressures": (STRAIGHT, (SCATTERED, STILL)),
    "combined": (COMBINED, (SCATTERED,)), "loads": (STRAIGHT, (SCATTERED, STILL)),
}  # fmt: skip
"""design -> worlds that measure the error of the force law there, and their noises"""
LIKE_A_LAW = (DriveBrakeAsymmetry, LoadLossBraking, DriveBrakeStiffness)
"""effects that look like another force law"""


RESTING = tuple(world for world in WORLDS if world != "plant")
"""worlds whose records begin at rest; their noise at rest gives a floor without repeats"""
SIDEWAYS = tuple((world, design) for design in ("combined", "angles") for world in
                 ("plant", *COMBINED))  # fmt: skip
"""campaigns with side slip, of tires with one friction limit for both directions"""


@dataclass(frozen=True)
class FormError:
    """Error of the base model for a tire without effects, relative to the largest force."""

    world: str
    seed: int
    mean: float
    """root mean square of the mean residual"""
    stretch: float
    """largest mean residual within 5 cm"""
    shift: float
    """distance by which the forces rise later than in the model [m]"""
    pattern: str
    """text about a bump or a wave beyond the band"""


def nothing_hidden(
    world: str, seed: int, level: float, scatter: float = 0.0, design: str = "plain",
    once: bool = False,
) -> list[MeasurementTable]:  # fmt: skip
    """Make a campaign of a drawn tire with noise `level` [N] of Fx; once: without repeats."""
    random = np.random.default_rng(seed)
    tire = WORLDS[world](random)
    runs = (runs_once if once else runs_of)(design, random)
    columns = tire.run(runs, {}, random, Scatter.drawn(len(runs), scatter, random))
    kind = NOISES["usual"]
    share = level / float(np.hypot(kind.white, kind.slow))
    for c in columns:
        dt = float(c["time"][1] - c["time"][0])
        for name, part in RELATIVE.items():
            c[name] = c[name] + noise(kind, len(c["time"]), dt, random, part * share)
    return [measured_table(c, run, tire.radius) for c, run in zip(columns, runs, strict=True)]


def diagnosed(
    count: int, seed: int = 1, worlds: Sequence[str] = ("plant",), once: bool = False
) -> Iterator[tuple[float, Diagnosis]]:
    """Diagnose `count` campaigns at each noise level, the worlds in turn; yields level and
    diagnosis."""
    for level in LEVELS:
        for number in range(count):
            scatter = SCATTERS[number % len(SCATTERS)]
            world, drawn = worlds[number % len(worlds)], seed + 1000 * number + int(level)
            tables = nothing_hidden(world, drawn, level, scatter, once=once)
            yield level, Session.of_tables(tables).diagnose()


def form_errors(count: int, seed: int = 1) -> Iterator[FormError]:
    """Form errors of `count` tires of each world, with little noise."""
    for world in WORLDS:
        for number in range(seed, seed + count):
            state = Session.of_tables(nothing_hidden(world, number, QUIET)).fit(None).state
            runs, largest = state.runs, float(state.runs.largest[0])
            beyond = float(np.sqrt(np.mean(runs.mean(state.residual[0]) ** 2)))
            stretch = _largest_stretch(state)
            band = form_error_of(state.model)
            pattern = state.patterns.strongest(band.bump * largest, band.wave * largest)
            told = f"{pattern.words()}, {abs(pattern.size) / largest:.2%}" if pattern else ""
            skewed = state.with_term(Term(TimeSkew, TimeSkew.vector({"skew": 1e-3})), most=12)
            shift = skewed.fit.terms[-1].size * SPEED
            yield FormError(world, number, beyond / largest, stretch / largest, shift, told)


def _largest_stretch(state: State) -> float:
    """Largest mean residual within 5 cm [N] that exceeds the scatter of its own repeats, however
    small."""
    unexpected = np.zeros_like(state.expected_errors)
    events = where.events(state.runs, state.residual[0], 0.0, unexpected)
    return max((e.level for e in events), default=0.0)


def lines_of_nulls(count: int) -> Iterator[str]:
    """Lines with every diagnosis, and counts at each level."""
    good: dict[float, int] = dict.fromkeys(LEVELS, 0)
    for level, result in diagnosed(count):
        good[level] += result.verdict == AT_FLOOR
        yield f"  {level:g} N: {result.verdict} ({result.reason})"
    for level, right in good.items():
        yield f"noise {level:4.1f} N: {right} of {count} at the floor"
    yield f"all: {sum(good.values())} of {count * len(LEVELS)} at the floor"


def lines_of_unrepeated(count: int) -> Iterator[str]:
    """Lines with every diagnosis of campaigns without repeats, and the share with an effect."""
    wrong: dict[float, int] = dict.fromkeys(LEVELS, 0)
    for level, result in diagnosed(count, worlds=RESTING, once=True):
        named = [f.decision.term.effect.identifier for f in result.found]
        wrong[level] += bool(named)
        yield (f"  {level:g} N: {', '.join(named) or 'nothing'} named, {result.verdict} "
               f"({result.reason})")  # fmt: skip
    for level, names in wrong.items():
        yield f"noise {level:4.1f} N: an effect named in {names} of {count}"
    yield f"all: an effect named in {sum(wrong.values())} of {count * len(LEVELS)}"


def side_errors(count: int, seed: int = 1) -> Iterator[tuple[str, int, float, float]]:
    """Errors with side slip, relative to the largest force: (world and design, seed, largest rms
    of the mean residual in a channel other than Fx, largest within 5 cm in Fx)."""
    for world, design in SIDEWAYS:
        for number in range(seed, seed + count):
            tables = nothing_hidden(world, number, QUIET, design=design)
            state = Session.of_tables(tables).fit(None).state
            runs, left = state.runs, state.residual[1:]
            means = np.sqrt(np.mean(runs.mean(left) ** 2, axis=(1, 2)))
            side = float(np.max(means / runs.largest[1:]))
            yield f"{world} {design}", number, side, _largest_stretch(state) / runs.largest[0]


def law_errors(
    count: int, design: str = "combined", seed: int = 1
) -> Iterator[tuple[str, int, str, float]]:
    """Error of the force law of the base, as a share of the force, from the size of effects that
    are not there: (world, seed, effect, error). design: see `LAW_WORLDS`."""
    worlds, noises = LAW_WORLDS[design]
    for (level, scatter), world in product(noises, worlds):
        for number in range(seed, seed + count):
            tables = nothing_hidden(world, number, level, scatter, design=design)
            session = Session.of_tables(tables)
            state = session.fit(None).state
            for effect in LIKE_A_LAW:
                start = Term(effect, effect.vector({effect.main_parameter().name: 0.01}))
                share = _like_a_law(state, state.with_term(start, most=12).fit)
                if share > 0.0:
                    yield world, number, effect.identifier, share


def _like_a_law(state: State, fit: Fit) -> float:
    """Relative error of the law, independent in each channel and among runs of another law, that
    would make the size of the last effect of a fit; 0 where no such error makes any."""
    own = len(fit.terms) - 1
    base = [i for i in fit.loose() if fit.free[i][0] != own]
    signals = np.eye(len(fit.predicted))[:, :, None, None] * fit.predicted
    gram = state.sums(fit, base, effect_contribution(fit, own)[None], signals)
    products, scores, _ = gram.total()
    n = len(base)
    mix = solve(products[:n, :n], scores[:n])[1] @ products[:n, n]
    along = gram.products[:, n + 1 :, n] - gram.products[:, n + 1 :, :n] @ mix
    of_law = [along[rows].sum(axis=0) for rows in same_law(state.model).values()]
    information = float(scores_of(gram, n)[1].sum())
    made = float(np.sqrt(np.sum(np.square(of_law))))
    return information / made if made > 0.0 else 0.0


def lines_of_form(count: int) -> Iterator[str]:
    """Lines with every tire, and the largest error beside the form error that the decision
    assumes."""
    found, band = [], TireModel.form
    for one in form_errors(count):
        found.append(one)
        more = f"; {one.pattern}" if one.pattern else ""
        yield (
            f"{one.world} {one.seed}: {one.mean:.3%} in the mean, {one.stretch:.2%} within 5 cm, "
            f"{1e3 * one.shift:.3f} mm later{more}"
        )
    sideways, turned = [], []
    for campaign, seed, share, stretch in side_errors(count):
        sideways.append(share)
        turned.append(stretch)
        yield f"{campaign} {seed}: {share:.3%} in Fy, {stretch:.2%} within 5 cm in Fx"
    laws: dict[str, list[float]] = {design: [] for design in LAW_WORLDS}
    for design, shares in laws.items():
        for world, seed, name, share in law_errors(count, design):
            shares.append(share)
            yield f"{world} {design} {seed}: {share:.2%} in the law, from {name}"
    most = {
        "in the mean": (max(f.mean for f in found), band.mean),
        "within 5 cm": (max(f.stretch for f in found), band.stretch),
        "in Fy": (max(sideways), band.side),
        "within 5 cm with side slip": (max(turned), STRETCH_WITH_SIDE_SLIP),
    }
    for what, (share, limit) in most.items():
        yield f"most {what}: {share:.3%}, band {limit:.3%}"
    later = float(np.sqrt(np.mean([f.shift**2 for f in found])))
    wide = LAW_AMONG_SETTINGS
    bands = {"plain": band.law, "pressures": wide, "combined": wide, "loads": wide}
    for design, shares in laws.items():
        law = float(np.sqrt(np.mean(np.square(shares))))
        yield f"law, {design} runs, rms: {law:.2%}, band {bands[design]:.2%}"
    yield f"later, rms: {1e3 * later:.3f} mm, band {1e3 * band.shift:.3f} mm"
    yield (
        f"bumps and waves beyond the band ({band.bump:.2%}, {band.wave:.2%}): "
        f"{sum(bool(f.pattern) for f in found)} of {len(found)}"
    )
