# SPDX-License-Identifier: Apache-2.0
"""Possible runs: a slip step at a condition, and the candidates around the existing ones."""

from __future__ import annotations

import math
import statistics
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from flatplank_analysis.contact_patch.plans import LOADS, STARTS, STEPS
from flatplank_analysis.discovery.runs import RunSet

SLIPS = (0.0, 0.01, -0.01, 0.02, -0.02, 0.05, -0.05, 0.1, -0.1)
SEED_SLIPS = (0.02, -0.05, 0.05)
"""slips of the first six runs of an investigation without data, each from two wheel angles"""
PRESSURES = (-0.4,)
"""further pressures, relative to the usual one [bar]"""
ANGLES = (2.0,)
"""further side slip angles [deg]"""
TWICE = 2
"""runs of a new condition: a single one has no floor"""


@dataclass(frozen=True, order=True)
class Setting:
    """One run: a slip step."""

    kappa: float
    start: int
    """number of the start angle of the wheel, 1 to 3, 120 deg apart"""
    step_position: float
    """[m]"""
    fz: float
    """[N]"""
    pressure: float
    """[bar]"""
    alpha_deg: float = 0.0

    @property
    def condition(self) -> tuple[float, float, float]:
        """Load, pressure, side slip: the condition of one rolling radius."""
        return self.fz, self.pressure, self.alpha_deg

    @property
    def shared_by_repeats(self) -> tuple[float, ...]:
        """Settings that repeats have in common."""
        return self.kappa, self.step_position, *self.condition

    def to_dict(self) -> dict[str, Any]:
        return asdict(self)

    def planned(self) -> dict[str, Any]:
        return self.to_dict() | {"alpha": math.radians(self.alpha_deg)}


@dataclass(frozen=True)
class Candidate:
    """Runs that are made together, all of one condition."""

    text: str
    settings: tuple[Setting, ...]


def settings_of(runs: RunSet) -> list[Setting]:
    """Settings of the runs of a campaign."""
    f = runs.facts
    rows = zip(
        f["kappa"], f["start"], f["step"], f["nominal"], f["pressure"], np.degrees(f["alpha"]),
        strict=True,
    )  # fmt: skip
    return [
        Setting(
            round(float(k), 6), round(math.degrees(float(start)) / 120.0) % 3 + 1,
            round(float(step), 3), round(float(fz)), round(float(bar), 3), round(float(alpha), 3),
        )
        for k, start, step, fz, bar, alpha in rows
    ]  # fmt: skip


def seed_of(fz: float, pressure: float, step: float = 1.5) -> Candidate:
    """The first six runs: three slips, two wheel angles each."""
    runs = [Setting(k, s, step, fz, pressure) for k in SEED_SLIPS for s in STARTS[:TWICE]]
    return Candidate("six runs to begin with: three slips, each from two wheel angles",
                     tuple(runs))  # fmt: skip


def candidates(
    made: Sequence[Setting], handed_back: Mapping[Setting, int] | None = None
) -> list[Candidate]:
    """Runs around the existing ones, without those that were handed back twice, or refused."""
    refused = handed_back or {}
    found: dict[tuple[Setting, ...], Candidate] = {}
    for c in _candidates_around(made):
        if all(refused.get(s, 0) < TWICE for s in c.settings):
            found.setdefault(c.settings, c)
    return list(found.values())


def _candidates_around(made: Sequence[Setting]) -> Iterator[Candidate]:
    usual = _usual(made)
    for s in dict.fromkeys(replace(s, start=1) for s in made):
        yield _one_more_run(made, s, f"slip {100 * s.kappa:+g} % once more{_where(s, usual)}")
    for kappa in SLIPS:
        yield _one_more_run(
            made, replace(usual, kappa=kappa), f"slip {100 * kappa:+g} %, a new level"
        )
    for kappa in _extreme_slips(s.kappa for s in made):
        base, text = replace(usual, kappa=kappa), f"slip {100 * kappa:+g} %"
        others = [
            *(replace(base, step_position=round(usual.step_position + d, 3)) for d in STEPS),
            *(replace(base, fz=round(share * usual.fz)) for share in LOADS),
            *(replace(base, pressure=round(usual.pressure + d, 3)) for d in PRESSURES),
            *(replace(base, alpha_deg=usual.alpha_deg + d) for d in ANGLES),
        ]
        for other in others:
            yield _one_more_run(made, other, text + _where(other, usual))


def _usual(made: Sequence[Setting]) -> Setting:
    def middle(values: Iterable[float]) -> float:
        known = [v for v in values if v == v]
        return statistics.median_low(known) if known else 1.5

    return Setting(
        0.0, 1, middle(s.step_position for s in made), middle(s.fz for s in made),
        middle(s.pressure for s in made), middle(s.alpha_deg for s in made),
    )  # fmt: skip


def _where(s: Setting, usual: Setting) -> str:
    differs = {
        f" with the step at {s.step_position:g} m": s.step_position != usual.step_position,
        f" at {s.fz:g} N": s.fz != usual.fz,
        f" at {s.pressure:g} bar": s.pressure != usual.pressure,
        f" at {s.alpha_deg:g} deg of side slip": s.alpha_deg != usual.alpha_deg,
    }
    return "".join(text for text, yes in differs.items() if yes)


def _extreme_slips(kappas: Iterable[float]) -> list[float]:
    """The smallest and the largest slip of either sign: small ones show play, large ones
    friction."""
    known = sorted(set(kappas), key=abs)
    out = []
    for sign in (1.0, -1.0):
        own = [k for k in known if k * sign > 0.0]
        out += [own[0], own[-1]] if own else []
    return list(dict.fromkeys(out))


def _one_more_run(made: Sequence[Setting], s: Setting, text: str) -> Candidate:
    """One more run of an existing condition, from its least used wheel angle; two of a new
    condition."""
    count = Counter(m.start for m in made if m.shared_by_repeats == s.shared_by_repeats)
    starts = sorted(STARTS, key=lambda start: (count[start], start))
    wanted = starts[: max(TWICE - count.total(), 1)]
    return Candidate(text, tuple(replace(s, start=start) for start in wanted))
