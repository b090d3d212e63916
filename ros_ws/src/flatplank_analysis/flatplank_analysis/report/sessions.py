# SPDX-License-Identifier: Apache-2.0
"""The reference tire over the sessions: control charts, repeatability and reproducibility.

The same tire is measured at the beginning of every session, each session in a folder of its own.
Control limits are those of an individuals chart, mean +- 3 x mean moving range / 1.128 (ISO
7870-2). The split of the variance is that of a one-way random-effects analysis (gauge R&R):
repeatability within a session, reproducibility between sessions.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flatplank_analysis.report.results import CampaignResult
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError

LEAST_SESSIONS = 4
"""least number of sessions for control limits"""
SAME_SIDE = 8
"""number of sessions in a row on one side of the mean that counts as a shift"""
RANGE_TO_SIGMA = 1.128
"""mean range of two values, relative to their standard deviation"""
SMALL_SLIP = 0.021
"""largest slip of runs that determine the slip stiffness [-]"""


@dataclass(frozen=True)
class Quantity:
    """A monitored quantity: title, display unit, factor from SI, values of a session's runs."""

    title: str
    unit: str
    factor: float
    read: Callable[[CampaignResult], list[float]]


@dataclass(frozen=True)
class Session:
    """One session: its date and per quantity the values of its runs, in the display unit."""

    name: str
    date: str
    values: Mapping[str, Sequence[float]]
    bench: str = ""


@dataclass(frozen=True)
class ControlChart:
    """One quantity over the sessions of one bench; arrays of shape (sessions,)."""

    name: str
    title: str
    unit: str
    labels: Sequence[str]
    means: np.ndarray
    runs: np.ndarray
    centre: float
    reach: float
    """half width of the control limits; NaN with too few sessions"""
    repeatability: float
    """standard deviation within a session; NaN without repeats"""
    reproducibility: float
    """standard deviation between sessions beyond what repeats explain"""
    remarks: Sequence[str]
    bench: str = ""


def _radii(result: CampaignResult) -> list[float]:
    stiffness = [v for v in _slip_stiffness(result) if math.isfinite(v)]
    mean = float(np.mean(stiffness)) if stiffness else math.inf
    return [r.corrected(mean) for r in result.radii]


def _slip_stiffness(result: CampaignResult) -> list[float]:
    fits = [
        fit.slip_stiffness
        for c in result.conditions
        if 0.0 < abs(c.condition.kappa) <= SMALL_SLIP
        for fit in c.run_fits.values()
    ]
    return [e.value for e in fits if e.determined]


def _vertical(result: CampaignResult) -> list[float]:
    return [r["mean"] for r in result.extras.get("vertical_stiffness", [])]


def _floor(result: CampaignResult) -> list[float]:
    """Floor of Fx: scatter of single runs, without what turns with the wheel."""
    found = [c.run_floor for c in result.conditions if math.isfinite(c.run_floor)]
    return [float(np.sqrt(np.mean(np.square(found))))] if found else []


QUANTITIES: dict[str, Quantity] = {
    "r_e": Quantity("effective rolling radius at Fx = 0", "mm", 1e3, _radii),
    "C_z": Quantity("vertical stiffness", "kN/m", 1e-3, _vertical),
    "C_Fk": Quantity("slip stiffness of small steps", "kN", 1e-3, _slip_stiffness),
    "floor": Quantity("scatter of Fx between repeats", "N", 1.0, _floor),
}
"""name -> quantity that is monitored over the sessions"""


def session_of(campaign: Campaign, result: CampaignResult) -> Session:
    """Values of the reference tire in one session, on the bench of its first run."""
    records = campaign.records()
    known = sorted(day for record in records if (day := record.day))
    values = {
        name: [q.factor * v for v in q.read(result) if math.isfinite(v)]
        for name, q in QUANTITIES.items()
    }
    bench = records[0].bench
    return Session(Path(campaign.path).name, known[0] if known else "", values, bench)


def charts_of(sessions: Sequence[Session]) -> list[ControlChart]:
    """A chart per quantity and bench with at least two sessions, in the order of their dates.

    Without a date in every session the order is that in which they were given.
    """
    if all(s.date for s in sessions):
        sessions = sorted(sessions, key=lambda s: s.date)
    benches = sorted({s.bench for s in sessions})
    out = []
    for name, quantity in QUANTITIES.items():
        having = [s for s in sessions if len(s.values.get(name, ()))]
        for bench in benches:
            there = [s for s in having if s.bench == bench]
            if len(there) > 1:
                out.append(_chart(name, quantity, there))
    if not out:
        raise FlatplankError(
            "no quantity was measured in two sessions of one bench",
            ", ".join(s.name for s in sessions),
            "measure the plan reference_tire at the beginning of each session",
        )
    return out


def _chart(name: str, quantity: Quantity, sessions: Sequence[Session]) -> ControlChart:
    values = [np.asarray(s.values[name], float) for s in sessions]
    means = np.array([v.mean() for v in values])
    labels = [f"{s.date} {s.name}".strip() for s in sessions]
    centre = float(means.mean())
    reach = math.nan
    remarks = []
    if len(sessions) < LEAST_SESSIONS:
        remarks.append(f"no limits: {len(sessions)} of at least {LEAST_SESSIONS} sessions")
    else:
        reach = 3.0 * float(np.mean(np.abs(np.diff(means)))) / RANGE_TO_SIGMA
        beyond = np.flatnonzero(np.abs(means - centre) > reach)
        remarks += [f"{labels[k]} is beyond the limits" for k in beyond]
        remarks += _shifts(means - centre, labels)
    within, between = variance_parts(values)
    return ControlChart(
        name, quantity.title, quantity.unit, labels, means, np.array([v.size for v in values]),
        centre, reach, within, between, tuple(remarks), sessions[0].bench,
    )  # fmt: skip


def _shifts(away: np.ndarray, labels: Sequence[str]) -> list[str]:
    side, count = 0.0, 0
    for value, label in zip(away, labels, strict=True):
        count = count + 1 if np.sign(value) == side else 1
        side = np.sign(value)
        if count == SAME_SIDE and side:
            word = "above" if side > 0 else "below"
            return [f"shift: {SAME_SIDE} sessions in a row {word} the mean, up to {label}"]
    return []


def variance_parts(values: Sequence[np.ndarray]) -> tuple[float, float]:
    """Standard deviations within and between groups of a one-way random-effects analysis.

    Repeatability is NaN without a group of two; reproducibility then is that of the means.
    """
    sizes = np.array([len(v) for v in values], float)
    total, groups = float(sizes.sum()), len(values)
    means = np.array([v.mean() for v in values])
    if total == groups:
        return math.nan, float(means.std(ddof=1))
    grand = float(np.concatenate(list(values)).mean())
    inside = sum(float(np.sum((v - v.mean()) ** 2)) for v in values) / (total - groups)
    outside = float(np.sum(sizes * (means - grand) ** 2)) / (groups - 1)
    typical = (total - float(np.sum(sizes**2)) / total) / (groups - 1)
    return math.sqrt(inside), math.sqrt(max(outside - inside, 0.0) / typical)
