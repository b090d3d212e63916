# SPDX-License-Identifier: Apache-2.0
"""Whether a run is worth keeping, told from its own samples; one function per question."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import NamedTuple

import numpy as np

from flatplank_control.runner.measurement import Measurement

SPEED = 0.03092
"""commanded speed of the road [m/s], thesis 4.3"""
GRID = np.arange(0.0, 4.15, 0.05)
"""where runs are compared [m]"""
Columns = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Limits:
    """What is still good; a plan may set its own under `quality`."""

    settling: float = 120.0
    """change of Fx over the last 0.2 m before the step [N]"""
    load_error: float = 0.06
    """mean Fz against the wanted load, before the step"""
    load_drift: float = 0.06
    """Fz at the end against Fz at the beginning"""
    speed_error: float = 0.01
    """mean speed of the plank against 0.03092 m/s"""
    once_per_turn: float = 150.0
    """amplitude of Fz over a turn of the wheel [N]"""
    plateau: float = 0.25
    """road without an answer after the step [m]"""
    repeatability: float = 200.0
    """rms of Fx against the mean of earlier runs of the condition [N]"""
    force_error: float = 0.05
    """free rolling: mean Fx over the last 1.5 m against 50 N"""


class Finding(NamedTuple):
    """One answer."""

    name: str
    value: float
    limit: float

    @property
    def ok(self) -> bool:
        return abs(self.value) <= self.limit


@dataclass(frozen=True)
class Verdict:
    """What is thought of a run."""

    findings: tuple[Finding, ...]

    @property
    def ok(self) -> bool:
        return all(f.ok for f in self.findings)

    def text(self) -> str:
        """One line: good, or what is wrong."""
        bad = [f"{f.name} {f.value:.3g} (limit {f.limit:g})" for f in self.findings if not f.ok]
        return "good" if self.ok else "; ".join(bad)

    def plain(self) -> dict[str, float]:
        """For the journal."""
        return {f.name: round(float(f.value), 6) for f in self.findings}


def _between(c: Columns, name: str, low: float, high: float) -> np.ndarray:
    x = c["plank_position"]
    return c[name][(x >= low) & (x < high)]


def _mean(values: np.ndarray) -> float:
    return float(values.mean()) if values.size else math.nan


def settling(c: Columns, m: Measurement) -> float:
    """Fx must not be on its way any more when the step comes."""
    late = _mean(_between(c, "fx", m.step_position - 0.05, m.step_position))
    return late - _mean(_between(c, "fx", m.step_position - 0.25, m.step_position - 0.2))


def load_error(c: Columns, m: Measurement) -> float:
    """A set load that was not there."""
    first = m.step_position if m.measurement == "slip" else m.end_position
    return _mean(_between(c, "fz", 0.02, first)) / m.fz - 1.0


def load_drift(c: Columns, m: Measurement) -> float:
    """The axle sinks, or the tire loses air."""
    end = _mean(_between(c, "fz", m.end_position - 0.5, m.end_position))
    return end / _mean(_between(c, "fz", 0.02, 0.52)) - 1.0


def speed_error(c: Columns, m: Measurement) -> float:
    """The switch stood wrong, or the plank's drive slips."""
    return _mean(_between(c, "plank_velocity", 0.3, m.end_position)) / SPEED - 1.0


def once_per_turn(c: Columns, m: Measurement) -> float:
    """Amplitude of Fz over the wheel angle: preloaded shaft, run-out."""
    first = m.step_position + 0.3 if m.measurement == "slip" else 0.3
    x = _between(c, "plank_position", first, m.end_position)
    angle = _between(c, "wheel_angle", first, m.end_position)
    fz = _between(c, "fz", first, m.end_position)
    if angle.size < 10 or np.ptp(angle) < 1.2 * math.pi:
        return 0.0
    basis = np.column_stack([np.ones_like(x), x - x.mean(), np.sin(angle), np.cos(angle)])
    a = np.linalg.lstsq(basis, fz, rcond=None)[0]
    return float(math.hypot(a[2], a[3]))


def plateau(c: Columns, m: Measurement) -> float:
    """Road behind the step until Fx has gone a tenth of its way."""
    if abs(m.kappa) < 1e-6 or m.waveform != "step":
        return 0.0
    before = _mean(_between(c, "fx", m.step_position - 0.05, m.step_position))
    after = _mean(_between(c, "fx", m.end_position - 0.3, m.end_position))
    x = _between(c, "plank_position", m.step_position, m.end_position)
    fx = _between(c, "fx", m.step_position, m.end_position)
    gone = np.flatnonzero((fx - before) / (after - before) > 0.1) if after != before else []
    return float(x[gone[0]] - m.step_position) if len(gone) else math.inf


def force_error(c: Columns, m: Measurement) -> float:
    """The controller did not hold its 50 N."""
    return _mean(_between(c, "fx", m.end_position - 1.5, m.end_position)) / 50.0 - 1.0


Question = Callable[[Columns, Measurement], float]
_ALWAYS: tuple[Question, ...] = (load_error, load_drift, speed_error, once_per_turn)
QUESTIONS: dict[str, tuple[Question, ...]] = {
    "slip": (settling, *_ALWAYS, plateau),
    "free_rolling": (*_ALWAYS, force_error),
}
"""kind of measurement -> what is asked; others are not judged"""


def profile(c: Columns) -> list[float]:
    """Fx on the grid [N], small enough for the journal."""
    x, fx = c["plank_position"], c["fx"]
    edges = np.append(GRID, GRID[-1] + 0.05) - 0.025
    number, _ = np.histogram(x, edges)
    total, _ = np.histogram(x, edges, weights=fx)
    means = np.divide(total, number, out=np.full(GRID.size, np.nan), where=number > 0)
    return [round(float(v), 1) for v in means]


def repeatability(own: Sequence[float], earlier: Sequence[Sequence[float]]) -> float:
    """rms difference [N] from the mean of earlier runs, over the road that all have seen."""
    others = np.array(earlier, float)
    mean = np.where(np.isnan(others).any(axis=0), np.nan, others.sum(axis=0) / len(others))
    difference = np.array(own, float) - mean
    seen = difference[np.isfinite(difference)]
    return float(np.sqrt(np.mean(seen**2))) if seen.size else 0.0


def judge(
    columns: Columns, m: Measurement, limits: Limits, earlier: Sequence[Sequence[float]] = ()
) -> Verdict:
    """The verdict on one run; `earlier`: profiles of runs of the same condition."""
    bounds = asdict(limits)
    asked = QUESTIONS.get(m.measurement, ())
    findings = [Finding(q.__name__, q(columns, m), bounds[q.__name__]) for q in asked]
    if earlier:
        findings.append(
            Finding(
                "repeatability", repeatability(profile(columns), earlier), limits.repeatability
            )
        )
    return Verdict(tuple(findings))
