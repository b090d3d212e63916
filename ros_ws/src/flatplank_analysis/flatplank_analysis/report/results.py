# SPDX-License-Identifier: Apache-2.0
"""Results of the analysis of a campaign; small enough for thousands of runs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from flatplank_analysis.identify.carcass import CarcassFit
from flatplank_analysis.identify.linear import LinearFit
from flatplank_analysis.identify.mf.fit import MFFit
from flatplank_analysis.identify.mf.points import SteadyPoints
from flatplank_analysis.identify.results import to_plain
from flatplank_analysis.models.tire_record import TireRecord
from flatplank_analysis.post.motion import StepFacts
from flatplank_analysis.report.tire import Geometry
from flatplank_analysis.steady.rolling_radius import RadiusRun
from flatplank_analysis.steady.transmission import DriveState
from flatplank_data.condition import Condition
from flatplank_data.problem import Problem


@dataclass(frozen=True)
class ConditionResult:
    """One slip level of one operating point: mean of its runs, low-passed, on a thinned grid."""

    condition: Condition
    names: Sequence[str]
    facts: StepFacts
    """means over the runs"""
    step_position: float
    """[m]"""
    position: np.ndarray
    """road displacement [m], shape (n,)"""
    measured: Mapping[str, np.ndarray]
    """fx, fy, fz [N], plank_velocity [m/s], each of shape (n,)"""
    scatter: np.ndarray | None
    """standard deviation of Fx over the runs [N], shape (n,); None for one run"""
    same_start: bool
    """True when the scatter is over repeats from one start angle"""
    linear: LinearFit
    """fit of the mean response, as in section 7.1"""
    run_fits: Mapping[str, LinearFit]
    """fit of every run"""
    lateral_steady: float
    """mean Fy over the last half metre [N]"""
    cycles_lost: int = 0
    """bus cycles without a sample, summed over the runs"""
    run_floor: float = math.nan
    """floor of the condition in the transient part [N]: scatter of a single run without what turns
    with the wheel, see `floors`; NaN for one run"""
    share_in_mean: float = 1.0
    """error of the mean of the starts, relative to the scatter of a single run"""

    @property
    def since_step(self) -> np.ndarray:
        """Road displacement since the step [m]."""
        return self.position - self.step_position

    def max_scatter(self) -> float:
        """Largest standard deviation after the step [N]."""
        if self.scatter is None:
            return math.nan
        after = self.scatter[(self.since_step >= 0) & np.isfinite(self.scatter)]
        return float(after.max()) if after.size else math.nan

    def floor(self) -> float:
        """Error of the mean itself in the transient part [N]: the floor for models of the mean."""
        return self.run_floor * self.share_in_mean

    def to_json(self) -> dict[str, Any]:
        """Numbers only."""
        return {
            "condition": to_plain(self.condition._asdict()),
            "runs": list(self.names),
            "facts": to_plain(self.facts) | {"load_change": to_plain(self.facts.load_change)},
            "step_position": self.step_position,
            "max_scatter": to_plain(self.max_scatter()),
            "cycles_lost": self.cycles_lost,
            "floor": to_plain(self.floor()),
            "run_floor": to_plain(self.run_floor),
            "linear": self.linear.to_json(),
            "run_fits": {name: fit.to_json() for name, fit in self.run_fits.items()},
        }


@dataclass(frozen=True)
class LateralResult:
    """Start of rolling at a slip angle, mean of the runs of an operating point."""

    fit: LinearFit
    """fit of -Fy over tan(alpha): sigma_y [m], cornering stiffness at this angle [N]"""
    std_error: Sequence[float]
    """errors of sigma and force from the scatter of the runs, NaN for one run"""
    runs: int
    distance: np.ndarray
    """road since the start [m]"""
    force: np.ndarray
    """Fy [N]"""


@dataclass(frozen=True)
class DriveRun:
    """Torque of the wheel drive at the end of a run."""

    condition: Condition
    state: DriveState
    start: int = 1
    """1, 2, 3: wheel started at 0, 120, 240 deg"""


@dataclass(frozen=True)
class RestRun:
    """Stiffness of the standing tire before a run."""

    value: float
    """C_x [N/m]"""
    start: int = 1
    """1, 2, 3: wheel started at 0, 120, 240 deg"""


@dataclass(frozen=True)
class FurtherResults:
    """Further results of the slip runs of one operating point, beside the slip response."""

    rest_stiffness: Sequence[RestRun] = ()
    """C_x of the standing tire per run"""
    drive: Sequence[DriveRun] = ()
    lateral: LateralResult | None = None


@dataclass(frozen=True)
class ModelCurves:
    """A model compared with the measurement: force over `since_step` and errors, by condition."""

    name: str
    title: str
    curves: Mapping[Condition, tuple[np.ndarray, np.ndarray]]
    """condition -> (distance since the step [m], force [N])"""
    rmse: Mapping[Condition, float]
    """error in the transient part [N]"""


@dataclass(frozen=True)
class PointResult:
    """All slip levels of one operating point, with the carcass stiffness fitted to them."""

    point: Condition
    conditions: Sequence[ConditionResult]
    radii: Sequence[RadiusRun]
    carcass: CarcassFit | None
    why_no_carcass: str = ""
    models: Mapping[str, ModelCurves] = field(default_factory=dict)
    problems: Sequence[Problem] = ()
    steady: SteadyPoints | None = None
    """steady forces of its runs"""
    further: FurtherResults = field(default_factory=FurtherResults)
    """stiffness at rest, drive torque, side force"""


@dataclass(frozen=True)
class CampaignResult:
    """The whole campaign."""

    path: str
    tire: str
    points: Sequence[PointResult]
    problems: Sequence[Problem]
    extras: Mapping[str, Any] = field(default_factory=dict)
    """results of other measurements by name: vertical_stiffness, contact_length, ..."""
    magic: MFFit | None = None
    why_no_magic: str = ""
    geometry: Geometry = field(default_factory=Geometry)
    record: TireRecord | None = None
    about: str = ""
    """where the runs come from, in words"""

    @property
    def conditions(self) -> list[ConditionResult]:
        """All conditions, by operating point and slip."""
        return [c for point in self.points for c in point.conditions]

    @property
    def radii(self) -> list[RadiusRun]:
        """r_e of every run that rolls freely."""
        return [r for point in self.points for r in point.radii]

    def nominal(self) -> PointResult | None:
        """The point without angles, with the most slip levels, at the middle load and pressure."""
        points = [p for p in self.points if p.conditions]
        if not points:
            return None
        # the middle level; the upper one of two
        levels = [sorted({getattr(p.point, n) for p in points}) for n in ("fz", "pressure")]
        load, pressure = (values[len(values) // 2] for values in levels)
        return max(
            points,
            key=lambda p: (
                -abs(p.point.alpha_deg) - abs(p.point.gamma_deg),
                len(p.conditions),
                -abs(p.point.fz - load),
                -abs(p.point.pressure - pressure),
            ),
        )

    def to_json(self) -> dict[str, Any]:
        """Numbers only, ready for json.dumps."""
        return {
            "format": "flatplank-report/1",
            "campaign": self.path,
            "tire": self.tire,
            "tire_record": to_plain(self.record) if self.record else None,
            "points": [
                {
                    "point": to_plain(p.point._asdict()),
                    "conditions": [c.to_json() for c in p.conditions],
                    "carcass": p.carcass.to_json() if p.carcass else None,
                    "why_no_carcass": p.why_no_carcass,
                    "beside": to_plain(p.further),
                    "rmse": {
                        name: {f"{c.kappa:g}": to_plain(v) for c, v in m.rmse.items()}
                        for name, m in p.models.items()
                    },
                }
                for p in self.points
            ],
            "radii": [to_plain(r) for r in self.radii],
            "extras": to_plain(dict(self.extras)),
            "mf": self.magic.to_json() if self.magic else None,
            "why_no_mf": self.why_no_magic,
            "problems": [str(p) for p in self.problems],
        }
