# SPDX-License-Identifier: Apache-2.0
"""A file of sweeps from end to end: axes, conditions, curves, and where a tire file fails."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from flatplank_analysis.models.tir import TirFile
from flatplank_analysis.slip_sweeps import axes, file
from flatplank_analysis.slip_sweeps.conditions import FORCE, Condition, cut
from flatplank_analysis.slip_sweeps.curves import Curve, Formula, curve_of, fit_formula
from flatplank_analysis.slip_sweeps.failing import Failure, failures
from flatplank_analysis.slip_sweeps.levels import HELD
from flatplank_data.errors import FlatplankError

FAILS = 1.5
"""floors above which a file fails in a condition"""


@dataclass(frozen=True)
class Study:
    """What a file of sweeps holds, in ISO W and SI."""

    path: str
    columns: Mapping[str, np.ndarray]
    further: tuple[str, ...]
    """columns of the file whose meaning is not known; kept"""
    said: tuple[str, ...]
    """axes, units and what was left out, one line each"""
    conditions: tuple[Condition, ...]
    curves: tuple[Curve, ...]

    @cached_property
    def formulas(self) -> tuple[Formula | None, ...]:
        """B, C, D, E of each condition."""
        return tuple(fit_formula(curve) for curve in self.curves)

    def failures(self, tir: TirFile) -> list[Failure]:
        """Where the tire file fails, condition by condition."""
        return failures(self.columns, self.conditions, self.curves, tir)

    def lacking(self) -> list[str]:
        """What must still be measured for the rest of a tire model, one line each."""
        swept = {c.swept for c in self.conditions}
        out = []
        if "alpha" not in swept:
            out.append("for Fy and Mz you still need: sweeps of the slip angle")
        if "kappa" not in swept:
            out.append("for Fx you still need: sweeps of the slip, driven and braked")
        angles = {round(c.held["alpha"], 2) for c in self.conditions if "alpha" in c.held}
        if len(angles) < 2:
            out.append("for combined slip you still need: sweeps of the slip at side slip angles")
        return out

    def to_json(self, tir: TirFile | None = None) -> dict[str, Any]:
        """For programs: SI, ISO W; null where a number is not known."""
        found = self.failures(tir) if tir else [None] * len(self.conditions)
        rows = zip(self.conditions, self.curves, self.formulas, found, strict=True)
        return {
            "file": self.path,
            "said": list(self.said),
            "further_columns": list(self.further),
            "lacking": self.lacking(),
            "conditions": [_json(*row) for row in rows],
        }


def study(path: str | Path, system: str | None = None) -> Study:
    """Read a file of sweeps and cut it.

    system: iso, sae or adapted, where the signs of the data are not to decide.

    Raises:
        FlatplankError: what is wrong with the file, and what to do.
    """
    recording = file.read(path)
    if system is not None and system not in axes.SYSTEMS:
        known = ", ".join(axes.SYSTEMS)
        raise FlatplankError(f"no axis system '{system}'", "--axes", f"known: {known}")
    found = axes.in_iso(recording.columns, system, str(path))
    conditions = tuple(cut(found.columns))
    if not conditions:
        raise FlatplankError(
            "no sweep: neither the slip angle nor the slip ranges over enough "
            "while load, camber and pressure are held", str(path),
            "give a recording with sweeps",
        )  # fmt: skip
    curves = tuple(curve_of(found.columns, c) for c in conditions)
    said = (found.said, *recording.said)
    return Study(str(path), found.columns, recording.further, said, conditions, curves)


def by_level(conditions: Sequence[Condition], found: Sequence[Failure]) -> Iterator[str]:
    """How the error goes with each channel that was held at several levels, a line each."""
    for held in HELD:
        shares: dict[str, list[float]] = {}
        for condition, failure in zip(conditions, found, strict=True):
            if held.name in condition.held:
                level = held.word(condition.held[held.name])
                shares.setdefault(level, []).append(failure.share)
        if len(shares) > 1:
            each = ", ".join(
                f"{100.0 * float(np.mean(v)):.0f} % at {level}"
                for level, v in sorted(shares.items(), key=lambda s: float(s[0].split()[0]))
            )
            yield f"by {TITLES[held.name]}: {each}"


TITLES = {
    "fz": "load",
    "gamma": "camber",
    "pressure": "pressure",
    "speed": "speed",
    "alpha": "slip angle",
    "kappa": "slip",
}


def _json(c: Condition, curve: Curve, formula: Formula | None, found: Failure | None):
    out: dict[str, Any] = {
        "label": c.label,
        "swept": c.swept,
        "force": FORCE[c.swept],
        "held": dict(c.held),
        "samples": len(c.samples),
        "visits": c.visits,
        "floor": _number(curve.floor),
        "floor_from": curve.floor_from,
        "formula": None,
    }
    if formula:
        out["formula"] = {
            "values": dict(formula.values),
            "interval_90": {k: _number(v) for k, v in formula.spread.items()},
            "stiffness": formula.stiffness,
            "rms": formula.rms,
        }
    if found:
        out |= {
            "error": found.error,
            "error_share": found.share,
            "worst": found.worst,
            "worst_slip": found.worst_slip,
        }
    return out


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
