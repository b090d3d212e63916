# SPDX-License-Identifier: Apache-2.0
"""Sweeps of another test bench, as tables."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeAlias

import pandas as pd

from flatplank_analysis.api.explained import Explained, explain
from flatplank_analysis.api.runs import page
from flatplank_analysis.slip_sweeps.channels import BY_NAME
from flatplank_analysis.slip_sweeps.fit import SweepFit, fit_sweeps
from flatplank_analysis.slip_sweeps.missing import missing_sweep
from flatplank_analysis.slip_sweeps.model import sweep_model
from flatplank_analysis.slip_sweeps.study import Study, lacking, study
from flatplank_analysis.slip_sweeps.tir_signs import READ
from flatplank_data.errors import FlatplankError
from flatplank_tire.tir import read_tir

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FilePath: TypeAlias = "str | os.PathLike[str]"


def sweeps(
    path: FilePath | Sequence[FilePath],
    axes: str | None = None,
    turn: Sequence[str] = (),
    columns: Mapping[str, str] | None = None,
) -> Sweeps:
    """Read sweeps from a text, TYDEX or `.mat` file; `flatplank sweeps` does the same.

    path: a file, or several of one tire in the order of measurement.
    axes: iso, sae or adapted; None: determined by the signs of the data. turn: channels that the
    file counts the other way, as `["alpha"]`. columns: channel -> column of the file, where it has
    another name.

    Raises:
        FlatplankError: what is wrong with the file, and what to do.
    """
    files = [path] if isinstance(path, (str, os.PathLike)) else path
    return Sweeps([study(os.fspath(file), axes, turn, columns) for file in files])


class Sweeps:
    """Conditions of the sweeps of a tire; ISO W, SI."""

    def __init__(self, studies: Sequence[Study]) -> None:
        if not studies:
            raise FlatplankError("names no file", "sweeps", "name one or more")
        self.studies = tuple(studies)

    @cached_property
    def table(self) -> pd.DataFrame:
        """The samples of all files, one after the other; units are in `table.attrs["units"]`;
        unknown columns are unchanged."""
        table = pd.concat([pd.DataFrame(dict(one.columns)) for one in self.studies])
        table = table.reset_index(drop=True)
        table.attrs["units"] = {n: BY_NAME[n].unit for n in table.columns if n in BY_NAME}
        return table

    @cached_property
    def conditions(self) -> pd.DataFrame:
        """One row per condition: held levels, floor [N], B, C, D, E, Sh, Sv, stiffness."""
        return self._rows([one.to_json() for one in self.studies])

    def compare(self, tir: FilePath, signs: str = READ) -> pd.DataFrame:
        """Conditions with the error of a tire file [N] and where it is largest; worst first.

        signs: under which the file was fitted, as `mirrored`; `attrs["tir_signs"]` has the error
        of the side force under each convention, and those that halve it.
        """
        file = read_tir(os.fspath(tir))
        told = [one.to_json(file, signs) for one in self.studies]
        rows = self._rows(told)
        rows.attrs["tir_signs"] = next((t["tir_signs"] for t in told if "tir_signs" in t), None)
        return rows.sort_values("error_share", ascending=False, ignore_index=True)

    def fit(
        self,
        start: FilePath | None = None,
        radius: float | None = None,
        version: str | None = None,
    ) -> SweepFit:
        """A tire file of the Magic Formula fitted to these sweeps: a `SweepFit` with `file`,
        `fit.estimates`, `held_out`. start: `.tir` with the values of what is not determined;
        radius: of the free tire [m]; version: 5.2, 6.1 (the default) or 6.2.

        Raises:
            FlatplankError: neither Fx nor Fy is in the sweeps.
        """
        tir = read_tir(os.fspath(start)) if start else None
        return fit_sweeps(self.studies, tir, radius, version=version)

    def diagnose(self, tir: FilePath, signs: str = READ, swept: str = "alpha") -> Explained:
        """What the sweeps have and the tire file does not: effects, with verdict and floor.

        `add(name)` of the result is the diagnosis with one of them in the model. swept: `alpha`
        for the side force, `kappa` for the longitudinal force; signs: as in `compare`.

        Raises:
            FlatplankError: no sweep of this slip, or nothing that gives a floor.
        """
        model = sweep_model(self.studies, read_tir(os.fspath(tir)), signs, swept)
        return explain(model, model.effects, missing_sweep)

    def plot(self, tir: FilePath | None = None, signs: str = READ, file: int = 0) -> Figure:
        """Force over slip, a panel per condition of one of the files, the first by default;
        signs: as in `compare`."""
        return self.studies[file].plot(read_tir(os.fspath(tir)) if tir else None, signs)

    def _rows(self, told: Sequence[Mapping[str, Any]]) -> pd.DataFrame:
        """The conditions of all files; of several each with its file."""
        rows = [row for one in told for row in one["conditions"]]
        table = pd.json_normalize(rows).rename(columns=_short)
        if len(told) > 1:
            table.insert(0, "file", [t["file"] for t in told for _ in t["conditions"]])
        return table

    def __repr__(self) -> str:
        heads = ([one.path, *one.said, *(c.label for c in one.conditions)] for one in self.studies)
        lines = [line for head in heads for line in head]
        return "\n".join([*lines, *lacking([c for one in self.studies for c in one.conditions])])

    def _repr_html_(self) -> str:
        figures = [self.plot(file=number) for number in range(len(self.studies))]
        return page(repr(self), [self.conditions], figures)


def _short(name: str) -> str:
    return name.removeprefix("formula.values.").removeprefix("held.").removeprefix("formula.")
