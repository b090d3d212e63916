# SPDX-License-Identifier: Apache-2.0
"""Evaluates the samples of a run: its quality, and stiffness and friction of a standing tire."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np

from flatplank_control.calibration.fits import turning_amplitude
from flatplank_control.free_rolling import FreeRollingParameters
from flatplank_control.runner.measurement import Measurement

BRAKING = 0.02
"""braking distance of a plank that was stopped by hand [m]"""
BEGINS = 0.3
"""plank position from which the tire rolls freely [m]"""
LEAST_TURN = 0.6
"""smallest wheel angle for an amplitude [turns]"""
LOADED = 300.0
"""a tire is loaded above this Fz, which exceeds the spurious force of an unloaded wheel [N]"""
GRID = np.arange(0.0, 4.15, 0.05)
"""plank positions at which runs are compared [m]"""
Columns = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Limits:
    """Quality limits of a run; a plan may set its own under `quality`."""

    settling: float = 120.0
    """change of Fx over the last 0.2 m before the step [N]"""
    load_error: float = 0.06
    """mean Fz before the step against the set load, relative [-]"""
    load_drift: float = 0.06
    """Fz at the end against Fz at the beginning, relative [-]"""
    speed_error: float = 0.01
    """mean speed of the plank against that of the plan, relative [-]"""
    once_per_turn: float = 150.0
    """once-per-turn amplitude of Fz [N]"""
    plateau: float = 0.25
    """road after the step without a response of Fx [m]"""
    repeatability: float = 200.0
    """rms difference of Fx from the mean of earlier runs of the condition [N]"""
    force_error: float = 0.05
    """free rolling: mean Fx over the last 1.5 m (or less) against the reference, relative [-]"""


class Finding(NamedTuple):
    """Value of one quality criterion, with its limit."""

    name: str
    value: float
    limit: float

    @property
    def ok(self) -> bool:
        return abs(self.value) <= self.limit


@dataclass(frozen=True)
class Verdict:
    """Quality verdict on a run."""

    findings: tuple[Finding, ...]
    ended: float = math.nan
    """position where the operator ended the run [m]; NaN: complete run"""
    left_out: tuple[str, ...] = ()
    """criteria that need more road than the run has"""
    stopped: str = ""
    """why the bench stopped on the way; such a run is no result"""

    @property
    def ok(self) -> bool:
        return not self.stopped and all(f.ok for f in self.findings)

    def text(self) -> str:
        """One line: good or what is wrong, and the criteria that could not be evaluated."""
        if self.stopped:
            return f"stopped: {self.stopped}"
        bad = [f"{f.name} {f.value:.3g} (limit {f.limit:g})" for f in self.findings if not f.ok]
        parts = bad or ["good"]
        if self.ended == self.ended:
            parts.append(f"ended at {self.ended:.2f} m")
        if self.left_out:
            parts.append(f"not evaluated: road too short for {', '.join(self.left_out)}")
        return "; ".join(parts)

    def plain(self) -> dict[str, Any]:
        """Plain values for the journal."""
        found = {f.name: round(float(f.value), 6) for f in self.findings}
        ended = {"ended": round(self.ended, 3)} if self.ended == self.ended else {}
        stopped = {"stopped": self.stopped} if self.stopped else {}
        return {"findings": found, "not_asked": list(self.left_out), **ended, **stopped}


def _between(c: Columns, name: str, low: float, high: float) -> np.ndarray:
    x = c["plank_position"]
    return c[name][(x >= low) & (x < high)]


def _mean(values: np.ndarray) -> float:
    return float(values.mean()) if values.size else math.nan


class Judged(NamedTuple):
    """Measurement, end of the road and reference force by which samples are judged."""

    m: Measurement
    end: float
    """end of the measured road [m]"""
    reference: float
    """force that the free-rolling controller was to hold [N]"""


def settling(c: Columns, run: Judged) -> float:
    """Change of Fx over the last 0.2 m before the step [N]."""
    step = run.m.step_position
    late = _mean(_between(c, "fx", step - 0.05, step))
    return late - _mean(_between(c, "fx", step - 0.25, step - 0.2))


def load_error(c: Columns, run: Judged) -> float:
    """Deviation of the mean Fz from the set load, relative [-]."""
    first = min(run.m.step_position, run.end) if run.m.measurement == "slip" else run.end
    return _mean(_between(c, "fz", 0.02, first)) / run.m.fz - 1.0


def load_drift(c: Columns, run: Judged) -> float:
    """Change of Fz over the run, relative [-]: the axle sinks, or the tire loses air."""
    late = _mean(_between(c, "fz", run.end - 0.5, run.end))
    return late / _mean(_between(c, "fz", 0.02, 0.52)) - 1.0


def speed_error(c: Columns, run: Judged) -> float:
    """Deviation of the plank speed, relative [-]: wrong switch position, or a slipping drive."""
    return _mean(_between(c, "plank_velocity", BEGINS, run.end)) / run.m.speed - 1.0


def _turns_from(m: Measurement) -> float:
    return m.step_position + BEGINS if m.measurement == "slip" else BEGINS


def once_per_turn(c: Columns, run: Judged) -> float:
    """Once-per-turn amplitude of Fz [N]: shaft preload, run-out."""
    begin, names = _turns_from(run.m), ("plank_position", "wheel_angle", "fz")
    x, angle, fz = (_between(c, name, begin, run.end) for name in names)
    return float(turning_amplitude(angle, fz, drift=x))


def plateau(c: Columns, run: Judged) -> float:
    """Road after the step until Fx has reached a tenth of its change [m]."""
    if abs(run.m.kappa) < 1e-6 or run.m.waveform != "step":
        return 0.0
    step, end = run.m.step_position, run.end
    before = _mean(_between(c, "fx", step - 0.05, step))
    after = _mean(_between(c, "fx", end - 0.3, end))
    x = _between(c, "plank_position", step, end)
    fx = _between(c, "fx", step, end)
    gone = np.flatnonzero((fx - before) / (after - before) > 0.1) if after != before else []
    return float(x[gone[0]] - step) if len(gone) else math.inf


def force_error(c: Columns, run: Judged) -> float:
    """Deviation of Fx from the reference of the free-rolling controller, relative [-]."""
    late = _mean(_between(c, "fx", max(BEGINS, run.end - 1.5), run.end))
    return late / run.reference - 1.0 if run.reference else math.inf


def _a_turn(m: Measurement) -> float:
    turn = 2.0 * math.pi * m.effective_rolling_radius / (1.0 + m.kappa)
    return _turns_from(m) + LEAST_TURN * turn


class Criterion(NamedTuple):
    """A quality criterion, and the plank position that a run must reach for it."""

    evaluate: Callable[[Columns, Judged], float]
    needs: Callable[[Measurement], float]
    """measurement -> required position of the plank [m]"""

    @property
    def name(self) -> str:
        return self.evaluate.__name__


_ALWAYS = (
    Criterion(load_error, lambda _m: 0.1),
    Criterion(load_drift, lambda _m: 1.02),
    Criterion(speed_error, lambda _m: BEGINS + 0.05),
    Criterion(once_per_turn, _a_turn),
)
CRITERIA: dict[str, tuple[Criterion, ...]] = {
    "slip": (
        Criterion(settling, lambda m: m.step_position),
        *_ALWAYS,
        Criterion(plateau, lambda m: m.step_position + 0.6),
    ),
    "free_rolling": (*_ALWAYS, Criterion(force_error, lambda _m: BEGINS + 0.5)),
}
"""kind of measurement -> criteria; other kinds are not judged"""


def force_profile(c: Columns) -> list[float]:
    """Mean Fx around each point of `GRID` [N]; NaN where there is no sample."""
    x, fx = c["plank_position"], c["fx"]
    edges = np.append(GRID, GRID[-1] + 0.05) - 0.025
    number, _ = np.histogram(x, edges)
    total, _ = np.histogram(x, edges, weights=fx)
    means = np.divide(total, number, out=np.full(GRID.size, np.nan), where=number > 0)
    return [round(float(v), 1) for v in means]


def loaded_travel(c: Columns) -> float:
    """Road that the loaded tire has rolled [m]."""
    under_load = c["plank_position"][c["fz"] > LOADED]
    return float(np.ptp(under_load)) if under_load.size else 0.0


def repeatability(own: Sequence[float], earlier: Sequence[Sequence[float]]) -> float:
    """rms difference [N] from the mean of earlier runs, over the road common to all."""
    others = np.array(earlier, float)
    mean = np.where(np.isnan(others).any(axis=0), np.nan, others.sum(axis=0) / len(others))
    difference = np.array(own, float) - mean
    seen = difference[np.isfinite(difference)]
    return float(np.sqrt(np.mean(seen**2))) if seen.size else 0.0


def judge_run(
    columns: Columns,
    m: Measurement,
    limits: Limits,
    earlier: Sequence[Sequence[float]] = (),
    enough: bool = False,
    reference: float = FreeRollingParameters.reference,
) -> Verdict:
    """The verdict on one run. `earlier`: Fx profiles of runs of the same condition; `enough`: the
    operator ended the run, so it is judged up to its end; `reference`: force that the free-rolling
    controller was to hold [N]."""
    bounds = asdict(limits)
    criteria = CRITERIA.get(m.measurement, ())
    farthest = float(columns["plank_position"].max()) if enough else math.nan
    end = min(m.end_position, farthest - BRAKING) if enough else m.end_position
    left_out = tuple(c.name for c in criteria if c.needs(m) > end)
    run = Judged(m, end, reference)
    findings = [
        Finding(c.name, c.evaluate(columns, run), bounds[c.name])
        for c in criteria
        if c.needs(m) <= end
    ]
    if earlier:
        scatter = repeatability(force_profile(columns), earlier)
        findings.append(Finding("repeatability", scatter, limits.repeatability))
    return Verdict(tuple(findings), farthest, left_out)


SHARE = (0.05, 0.2)
"""range of tangential force over Fz in which the tire is linear [-]"""
VERTICAL = (0.35, 0.95)
"""range of Fz over its maximum, above the play of the supports (thesis G.2) [-]"""
SLID = 0.5
"""part of the travel after which a locked wheel slides [-]"""


def slope(x: np.ndarray, y: np.ndarray) -> float:
    """dy/dx by least squares; NaN when x does not change."""
    if x.size < 5 or np.ptp(x) <= 0.0:
        return math.nan
    return float(np.polyfit(x - x.mean(), y, 1)[0])


def vertical(c: Columns, _m: Measurement) -> dict[str, float]:
    """C_z [N/m], the mean of loading and unloading, and their difference."""
    radius, fz = c["loaded_radius"], c["fz"]
    top = int(np.argmax(fz))
    largest = float(fz[top])
    found = []
    for part in (slice(None, top + 1), slice(top, None)):
        r, f = radius[part], fz[part]
        inside = (f > VERTICAL[0] * largest) & (f < VERTICAL[1] * largest)
        found.append(-slope(r[inside], f[inside]))
    return {"stiffness": sum(found) / 2.0, "hysteresis": found[0] - found[1]}


def _tangential(c: Columns, force: np.ndarray, sense: float) -> float:
    """Slope [N/m] of a force over the road's travel times `sense`, in the linear range."""
    size = np.hypot(c["fx"], c["fy"])
    fz = float(np.mean(c["fz"]))
    rest = c["plank_velocity"] == 0.0
    size = size - float(np.mean(size[rest])) if rest.any() else size
    beyond = np.flatnonzero(size > SHARE[1] * fz)
    last = int(beyond[0]) if beyond.size else size.size
    inside = np.flatnonzero(size[:last] > SHARE[0] * fz)
    if not inside.size:
        return math.nan
    part = slice(int(inside[0]), last)
    return -slope(c["plank_position"][part] * sense, force[part])


def longitudinal(c: Columns, m: Measurement) -> dict[str, float]:
    """C_x [N/m]: the road moves forward under a held wheel, so the force is a braking one."""
    return {"stiffness": _tangential(c, c["fx"], math.cos(math.radians(m.alpha_deg)))}


def lateral(c: Columns, m: Measurement) -> dict[str, float]:
    """C_y [N/m] from the travel across the steered wheel."""
    return {"stiffness": _tangential(c, c["fy"], math.sin(math.radians(m.alpha_deg)))}


def friction(c: Columns, _m: Measurement) -> dict[str, float]:
    """Mean friction coefficient of the sliding locked wheel, and the peak of the whole run."""
    x = c["plank_position"]
    mu = np.hypot(c["fx"], c["fy"]) / c["fz"]
    sliding = x > x[0] + SLID * (x[-1] - x[0])
    return {"friction": float(mu[sliding].mean()), "peak_friction": float(mu.max())}


EVALUATIONS: dict[str, Callable[[Columns, Measurement], dict[str, float]]] = {
    "stiffness_vertical": vertical,
    "stiffness_longitudinal": longitudinal,
    "stiffness_lateral": lateral,
    "locked_wheel": friction,
}
"""kind of measurement -> evaluation of its run [SI]"""
