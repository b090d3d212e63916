# SPDX-License-Identifier: Apache-2.0
"""Sweeps of another test bench, as tables."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import pandas as pd

from flatplank_analysis.api.explained import Explained, explain
from flatplank_analysis.api.runs import page
from flatplank_analysis.slip_sweeps.channels import BY_NAME
from flatplank_analysis.slip_sweeps.fit import SweepFit, fit_sweeps
from flatplank_analysis.slip_sweeps.missing import missing_sweep
from flatplank_analysis.slip_sweeps.model import sweep_model
from flatplank_analysis.slip_sweeps.study import Study, study
from flatplank_analysis.slip_sweeps.tir_signs import READ
from flatplank_tire.tir import TirFile, read_tir

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def sweeps(
    path: str | os.PathLike[str],
    axes: str | None = None,
    turn: Sequence[str] = (),
    columns: Mapping[str, str] | None = None,
) -> Sweeps:
    """Read sweeps from a text, TYDEX or `.mat` file; `flatplank sweeps` does the same.

    axes: iso, sae or adapted; None: determined by the signs of the data. turn: channels that the
    file counts the other way, as `["alpha"]`. columns: channel -> column of the file, where it has
    another name.

    Raises:
        FlatplankError: what is wrong with the file, and what to do.
    """
    return Sweeps(study(os.fspath(path), axes, turn, columns))


class Sweeps:
    """Conditions of a sweep file; ISO W, SI."""

    def __init__(self, study: Study) -> None:
        self.study = study

    @cached_property
    def table(self) -> pd.DataFrame:
        """The samples; units are in `table.attrs["units"]`; unknown columns are unchanged."""
        table = pd.DataFrame(dict(self.study.columns))
        table.attrs["units"] = {n: BY_NAME[n].unit for n in table.columns if n in BY_NAME}
        return table

    @cached_property
    def conditions(self) -> pd.DataFrame:
        """One row per condition: held levels, floor [N], B, C, D, E, Sh, Sv, stiffness."""
        return pd.json_normalize(self._rows(None)).rename(columns=_short)

    def compare(self, tir: str | os.PathLike[str], signs: str = READ) -> pd.DataFrame:
        """Conditions with the error of a tire file [N] and where it is largest; worst first.

        signs: under which the file was fitted, as `mirrored`; `attrs["tir_signs"]` has the error
        of the side force under each convention, and those that halve it.
        """
        told = self.study.to_json(read_tir(os.fspath(tir)), signs)
        rows = pd.json_normalize(told["conditions"]).rename(columns=_short)
        rows.attrs["tir_signs"] = told.get("tir_signs")
        return rows.sort_values("error_share", ascending=False, ignore_index=True)

    def fit(
        self,
        start: str | os.PathLike[str] | None = None,
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
        return fit_sweeps([self.study], tir, radius, version=version)

    def diagnose(
        self, tir: str | os.PathLike[str], signs: str = READ, swept: str = "alpha"
    ) -> Explained:
        """What the sweeps have and the tire file does not: effects, with verdict and floor.

        `add(name)` of the result is the diagnosis with one of them in the model. swept: `alpha`
        for the side force, `kappa` for the longitudinal force; signs: as in `compare`.

        Raises:
            FlatplankError: no sweep of this slip, or nothing that gives a floor.
        """
        model = sweep_model([self.study], read_tir(os.fspath(tir)), signs, swept)
        return explain(model, model.effects, missing_sweep)

    def plot(self, tir: str | os.PathLike[str] | None = None, signs: str = READ) -> Figure:
        """Force over slip, a panel per condition; signs: as in `compare`."""
        return self.study.plot(read_tir(os.fspath(tir)) if tir else None, signs)

    def _rows(self, tir: TirFile | None) -> list[dict]:
        return self.study.to_json(tir)["conditions"]

    def __repr__(self) -> str:
        lines = [self.study.path, *self.study.said, *(c.label for c in self.study.conditions)]
        return "\n".join([*lines, *self.study.lacking()])

    def _repr_html_(self) -> str:
        return page(repr(self), [self.conditions], [self.plot()])


def _short(name: str) -> str:
    return name.removeprefix("formula.values.").removeprefix("held.").removeprefix("formula.")
