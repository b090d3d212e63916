# SPDX-License-Identifier: Apache-2.0
"""Work on sweeps as the verbs do it on a campaign: compare, diagnose, add and remove effects."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery import verdict
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.modelfile import ModelFile
from flatplank_analysis.discovery.opening import opened
from flatplank_analysis.discovery.sources import FOUND, source_of
from flatplank_analysis.discovery.verdict import Diagnosis
from flatplank_analysis.effects.grammar.hooks import Hook
from flatplank_analysis.effects.grammar.sweep_hooks import SWEEP_HOOKS
from flatplank_analysis.effects.registry import load_files
from flatplank_analysis.effects.sweep_base import SweepEffect
from flatplank_analysis.pages.provenance import provenance
from flatplank_analysis.slip_sweeps.channels_of_runs import SweepChannels
from flatplank_analysis.slip_sweeps.conditions import FORCE
from flatplank_analysis.slip_sweeps.missing import missing_sweep
from flatplank_analysis.slip_sweeps.model import sweep_model
from flatplank_analysis.slip_sweeps.study import Study, study
from flatplank_analysis.slip_sweeps.tir_signs import READ
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError
from flatplank_data.names import nearest_hint
from flatplank_data.progress import Progress
from flatplank_tire.tir import read_tir

SETTINGS = ("columns", "axes", "turn", "signs")
"""keys of a mapping file for sweeps: as the options of `flatplank sweeps`"""


@dataclass
class SweepSession(Session):
    """Sweeps of one slip with a tire file as their base, and the effects that they can show."""

    tir: str = ""
    """path of the tire file"""
    more: tuple[str, ...] = ()
    """further files of the same tire"""
    reading: Mapping[str, Any] | None = None
    """settings by which the files were read, see `SETTINGS`"""

    @classmethod
    def of_file(
        cls,
        file: str,
        tir: str,
        swept: str | None = None,
        reading: Mapping[str, Any] | None = None,
        files: Sequence[str] = (),
        more: Sequence[str] = (),
    ) -> SweepSession:
        """The session of a file with sweeps, and of more files of the same tire in the order in
        which they were measured; reading: see `SETTINGS`, the others as in `of_studies`.

        Raises:
            FlatplankError: a file cannot be used, or there is no sweep of the slip.
        """
        given = dict(reading or {})
        if unknown := [name for name in given if name not in SETTINGS]:
            hint = nearest_hint(unknown[0], SETTINGS)
            what = f"unknown key '{unknown[0]}'{hint}"
            raise FlatplankError(what, "mapping of sweeps", f"known: {', '.join(SETTINGS)}")
        settings = given.get("axes"), given.get("turn", ()), given.get("columns")
        read = [study(path, *settings) for path in (file, *more)]
        made = cls.of_studies(read, tir, swept, given.get("signs", READ), files)
        return replace(made, reading=given)

    @classmethod
    def of_studies(
        cls, studies: Sequence[Study], tir: str, swept: str | None = None, signs: str = READ,
        files: Sequence[str] = (),
    ) -> SweepSession:  # fmt: skip
        """The session of sweeps that are read.

        tir: path of the tire file; swept: alpha or kappa, by default the slip that was swept, of
        both alpha; signs: of the tire file; files: of proposals.
        """
        slips = {c.swept for one in studies for c in one.conditions}
        swept = swept or next(slip for slip in FORCE if slip in slips)
        whole = sweep_model(studies, read_tir(tir), signs, swept)
        model: Any = opened(whole)
        data: Any = SweepChannels(model.runs)
        effects: dict[str, type[Effect]] = {e.identifier: e for e in whole.effects}
        effects |= proposals_in(files)
        first, *others = (one.path for one in studies)
        made = cls(Campaign(first, []), data, model, effects, tuple(files), tir=tir)
        return replace(made, more=tuple(others))

    @property
    def hooks(self) -> Sequence[Hook]:
        """Quantities on which a proposal may act."""
        return SWEEP_HOOKS

    @property
    def may_imitate(self) -> bool:
        """False: the Magic Formula leaves more than an effect differs from its imitation."""
        return False

    @property
    def unfit_for_proposals(self) -> str:
        """Why nothing can be proposed, whatever is left; empty: it can."""
        source = source_of(self.model.runs)
        if source.at_most == FOUND:
            return ""
        return f"the floor is from {source.title}: sweep each condition twice"

    def level_settings(self) -> list[np.ndarray]:
        """The load and camber of each run, as the number of their law (runs,)."""
        return [self.model.runs.facts["law"]]

    @property
    def about(self) -> str:
        """Where the sweeps come from, for the foot of a page."""
        runs = self.model.runs
        count = f"{len(runs.names)} sweeps" if len(runs.names) != 1 else "1 sweep"
        names = ", ".join(Path(path).name for path in (self.campaign.path, *self.more))
        return provenance((), f"{count} of {names}")

    def beside(self, folder: str, mapping: Any = None) -> SweepSession:
        """The session of other sweeps, with the same tire file."""
        own = (Path(path).read_bytes() for path in (self.campaign.path, *self.more))
        if Path(folder).read_bytes() in own:
            raise FlatplankError("is the file of the search", folder, "measure new sweeps")
        slip = next(s for s, force in FORCE.items() if force == self.model.runs.channels[0])
        return SweepSession.of_file(folder, self.tir, slip, mapping or self.reading, self.files)

    def start(self, model: ModelFile) -> dict[str, float]:
        """Base parameters of a model file."""
        where = model.path or "model file"
        if model.path and not _same_file(model.base, self.tir):
            what = f"its base is {model.base}, not {self.tir}"
            raise FlatplankError(what, where, f"give --tir {model.base}, or another --model")
        known = [p.name for p in self.model.parameters]
        if unknown := [name for name in model.parameters if name not in known]:
            what = f"the base has no parameter '{unknown[0]}'"
            raise FlatplankError(what, where, f"known: {', '.join(known)}")
        return dict(model.parameters)

    def effect_of(self, name: str, numbers: Any, where: str, file: str = "") -> type[Effect]:
        """An effect by name; FlatplankError when these sweeps cannot show it."""
        if file and name not in self.effects:
            self.effects |= proposals_in([file])
        if name not in self.effects:
            what = f"no effect '{name}' that these sweeps can show"
            what += nearest_hint(name, self.effects)
            raise FlatplankError(what, where, f"known: {', '.join(self.effects)}")
        return super().effect_of(name, numbers, where, file)

    def file_of(self, model: ModelFile, fit: Any) -> ModelFile:
        """The model file with the parameters and effects of a fit, and the tire file as base."""
        made = replace(super().file_of(model, fit), base=self.tir)
        # a name would stand for one of the files alone
        return replace(made, campaign="") if self.more else made

    def diagnose(
        self,
        model: ModelFile | None = None,
        progress: Progress | None = None,
        measured: Mapping[str, Mapping[str, float]] | None = None,
    ) -> Diagnosis:
        """Search for missing effects; measured: effect -> parameter -> start value [SI]."""
        began = time.perf_counter()
        result = verdict.diagnose(self.searched(model, progress, measured))
        result = replace(result, next_run=missing_sweep(result), campaign=False)
        return replace(result, seconds=time.perf_counter() - began)


def proposals_in(files: Sequence[str]) -> dict[str, type[Effect]]:
    """Effects of the files of proposals; FlatplankError for one that is not of sweeps."""
    found = {effect.identifier: effect for effect in load_files(files)}
    for effect in found.values():
        if not issubclass(effect, SweepEffect):
            raise FlatplankError("is not of sweeps", effect.file, "name a proposal for sweeps")
    return found


def _same_file(one: str, other: str) -> bool:
    return os.path.exists(one) and os.path.exists(other) and os.path.samefile(one, other)
