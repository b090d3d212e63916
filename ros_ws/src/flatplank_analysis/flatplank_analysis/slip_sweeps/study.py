# SPDX-License-Identifier: Apache-2.0
"""Evaluation of a sweep file: axes, conditions, curves, and where a tire file fails."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flatplank_analysis.identify.results import to_plain
from flatplank_analysis.slip_sweeps import axes, file
from flatplank_analysis.slip_sweeps.conditions import (
    FORCE,
    HELD,
    SweepCondition,
    not_held,
    split_into_conditions,
)
from flatplank_analysis.slip_sweeps.curves import (
    Curve,
    Failure,
    curve_of,
    failures,
)
from flatplank_analysis.slip_sweeps.formula import Formula, fit_formula
from flatplank_analysis.slip_sweeps.moment import MOMENT, with_usable_moment
from flatplank_analysis.slip_sweeps.tir_signs import READ, convention, errors_of, likelier
from flatplank_data.errors import FlatplankError
from flatplank_tire.tir import TirFile

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Study:
    """Content of a sweep file, in ISO W and SI."""

    path: str
    columns: Mapping[str, np.ndarray]
    further: tuple[str, ...]
    """unknown columns of the file, kept unchanged"""
    said: tuple[str, ...]
    """remarks on axes, units and omitted data, one line each"""
    conditions: tuple[SweepCondition, ...]
    curves: tuple[Curve, ...]

    @cached_property
    def formulas(self) -> tuple[Formula | None, ...]:
        """B, C, D, E of each condition."""
        return tuple(fit_formula(curve) for curve in self.curves)

    @cached_property
    def moments(self) -> dict[int, Curve]:
        """Number of a condition -> its aligning moment, where it was measured."""
        side = [k for k, c in enumerate(self.conditions) if c.swept == "alpha"]
        if MOMENT not in self.columns:
            return {}
        found = {k: curve_of(self.columns, self.conditions[k], MOMENT) for k in side}
        return {k: curve for k, curve in found.items() if np.isfinite(curve.force).any()}

    def moment_failures(self, tir: TirFile, signs: str = READ) -> dict[int, Failure]:
        """Number of a condition -> error of Mz [Nm]; {} for a file without Mz."""
        if not tir.coefficients.has_moment:
            return {}
        numbers, curves = list(self.moments), list(self.moments.values())
        conditions = [self.conditions[k] for k in numbers]
        found = failures(self.columns, conditions, curves, tir, convention(signs), MOMENT)
        return dict(zip(numbers, found, strict=True))

    def failures(self, tir: TirFile, signs: str = READ) -> list[Failure]:
        """Errors of the tire file, condition by condition; signs: one of `CONVENTIONS`."""
        return failures(self.columns, self.conditions, self.curves, tir, convention(signs))

    def errors_by_signs(self, tir: TirFile) -> dict[str, float]:
        """Error of the side force [N] under each convention of signs of the tire file; {} without
        sweeps of the slip angle."""
        pairs = zip(self.conditions, self.curves, strict=True)
        side = [(c, curve) for c, curve in pairs if FORCE[c.swept] == "fy"]
        if not side:
            return {}
        conditions, curves = [c for c, _ in side], [curve for _, curve in side]
        return errors_of(
            lambda signs: [f.error for f in failures(self.columns, conditions, curves, tir, signs)]
        )

    def lacking(self) -> list[str]:
        """Missing measurements for a complete tire model, one line each."""
        return lacking(self.conditions)

    def plot(self, tir: TirFile | None = None, signs: str = READ) -> Figure:
        """Measured and modelled curves, see `figure.figure_of_sweeps`."""
        from flatplank_analysis.slip_sweeps.figure import figure_of_sweeps

        return figure_of_sweeps(self, tir, signs)

    def to_json(self, tir: TirFile | None = None, signs: str = READ) -> dict[str, Any]:
        """For programs: SI, ISO W; null where a number is not known."""
        found = self.failures(tir, signs) if tir else [None] * len(self.conditions)
        rows = zip(self.conditions, self.curves, self.formulas, found, strict=True)
        turned = self.moment_failures(tir, signs) if tir else {}
        moments = [_moment(self.moments.get(k), turned.get(k)) for k in range(len(found))]
        head = {"file": self.path, "said": list(self.said), "further_columns": list(self.further)}
        errors = self.errors_by_signs(tir) if tir else {}
        if errors:
            known = {"errors": errors, "likelier": likelier(errors, signs)}
            head["tir_signs"] = to_plain({"used": signs, **known})
        conditions = [_json(*row) | more for row, more in zip(rows, moments, strict=True)]
        return head | {"lacking": self.lacking(), "conditions": conditions}


def study(
    path: str | Path,
    system: str | None = None,
    turn: Sequence[str] = (),
    names: Mapping[str, str] | None = None,
) -> Study:
    """Read a sweep file and divide it into conditions.

    system: iso, sae or adapted; None: determined by the signs of the data. turn: channels that the
    file counts the other way. names: channel -> column of the file.

    Raises:
        FlatplankError: the file cannot be used, or the axis system or a channel is unknown.
    """
    recording = file.read(path, names)
    if system is not None and system not in axes.SYSTEMS:
        known = ", ".join(axes.SYSTEMS)
        raise FlatplankError(f"no axis system '{system}'", "--axes", f"known: {known}")
    columns, told = axes.in_iso(recording.columns, system, turn, str(path))
    columns, doubt = with_usable_moment(columns)
    jumps = not_held(columns)
    if jumps:
        raise FlatplankError(
            f"the {jumps.title} changes from row to row: the rows are not in order of time",
            str(path), "sort the rows by time, or add a column with their stamps",
        )  # fmt: skip
    conditions = tuple(split_into_conditions(columns))
    if not conditions:
        raise FlatplankError(
            "no sweep: neither the slip angle nor the slip ranges over enough "
            "while load, camber and pressure are held", str(path),
            "give a recording with sweeps",
        )  # fmt: skip
    curves = tuple(curve_of(columns, c) for c in conditions)
    said = (told, *doubt, *recording.said)
    return Study(str(path), columns, recording.further, said, conditions, curves)


def lacking(conditions: Sequence[SweepCondition]) -> list[str]:
    """Measurements that a complete tire model needs beside these, one line each."""
    swept = {c.swept for c in conditions}
    out = []
    if "alpha" not in swept:
        out.append("for Fy and Mz you still need: sweeps of the slip angle")
    if "kappa" not in swept:
        out.append("for Fx you still need: sweeps of the slip, driven and braked")
    angles = {round(c.held["alpha"], 2) for c in conditions if "alpha" in c.held}
    if len(angles) < 2:
        out.append("for combined slip you still need: sweeps of the slip at side slip angles")
    return out


def by_level(conditions: Sequence[SweepCondition], found: Sequence[Failure]) -> Iterator[str]:
    """Dependence of the error on each channel with several levels, one line each."""
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
            yield f"by {held.title}: {each}"


def _json(c: SweepCondition, curve: Curve, formula: Formula | None, found: Failure | None):
    out: dict[str, Any] = {
        "label": c.label,
        "swept": c.swept,
        "force": FORCE[c.swept],
        "held": dict(c.held),
        "samples": len(c.samples),
        "visits": c.visits,
        "floor": curve.floor,
        "floor_from": curve.floor_from,
        "formula": None,
    }
    if formula:
        numbers = {"stiffness": formula.stiffness, "rms": formula.rms}
        spread = {"interval_90": dict(formula.spread)}
        out["formula"] = {"values": dict(formula.values)} | spread | numbers
    return to_plain(out | _error(found))


def _moment(curve: Curve | None, found: Failure | None) -> dict[str, Any]:
    """Floor [Nm] of Mz and the error of the tire file, where it was measured."""
    if curve is None:
        return {}
    floor = {"floor": curve.floor, "floor_from": curve.floor_from}
    return {"mz": to_plain(floor | _error(found))}


def _error(found: Failure | None) -> dict[str, float]:
    if found is None:
        return {}
    worst = {"worst": found.worst, "worst_slip": found.worst_slip, "chance": found.chance}
    return {"error": found.error, "error_share": found.share} | worst
