# SPDX-License-Identifier: Apache-2.0
"""A tire file as the base of the search on sweeps.

The base scales the file's friction and slip stiffness; everything else of the file is held. An
effect changes what the file is given, its scale factors, or what the bench shows.
"""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from flatplank_analysis.discovery.model import FormError, ParameterSet
from flatplank_analysis.discovery.parameters import Parameter
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.slip_sweeps.runs import AXES, runs_of
from flatplank_analysis.slip_sweeps.study import Study
from flatplank_analysis.slip_sweeps.tir_signs import READ, TirSigns, convention
from flatplank_tire.magic_formula import operating_point, steady
from flatplank_tire.tir import TirFile

SCALES = {"fy": ("LMUY", "LKY"), "fx": ("LMUX", "LKX")}
"""force -> scale factors of its friction and slip stiffness"""


class SweepModel:
    """The force of a tire file in the bins of sweeps."""

    def __init__(self, runs: RunSet, tir: TirFile, signs: TirSigns, law: float) -> None:
        """signs: under which the file was fitted; law: error of the Magic Formula itself, as a
        share of the largest force."""
        self.runs, self.tir, self.signs = runs, tir, signs
        self.channel = runs.channels[0]
        self.form = FormError(mean=law)
        self.parameters = tuple(
            Parameter(name, null=1.0, lower=0.3, upper=2.0, screen=0.02)
            for name in SCALES[self.channel]
        )

    def scatter_directions(self, base: np.ndarray) -> tuple[dict[str, float], ...]:
        """Nothing of a tire file scatters from visit to visit."""
        return ()

    def predict(self, sets: Sequence[ParameterSet]) -> np.ndarray:
        """Force (sets, 1, runs, nodes) [N]."""
        return np.stack([self._one(one)[None] for one in sets])

    def _one(self, one: ParameterSet) -> np.ndarray:
        s = self.state()
        s.grip, s.stiffness = (float(v) for v in one.base)
        effects = [_with(effect, values) for effect, values in one.effects]
        for effect in effects:
            effect.tire(s)
        c = self.tir.coefficients
        scale = zip(SCALES[self.channel], (s.grip, s.stiffness), strict=True)
        c = c.replaced({name: getattr(c, name) * by for name, by in scale})
        alpha, gamma = self.signs.alpha * s.alpha, self.signs.gamma * s.gamma
        point = operating_point(c, s.fz, s.kappa, alpha, gamma, s.pressure, s.speed)
        force = getattr(steady(c, point), self.channel) * getattr(self.signs, self.channel, 1)
        s.force = np.broadcast_to(force, s.fz.shape)
        for effect in effects:
            effect.bench(s)
        return s.force

    def state(self) -> Any:
        """What the file is given, by name, and every coordinate of the sweeps."""
        of = {k.removeprefix("of "): v for k, v in self.runs.facts.items()}
        c = self.tir.coefficients
        usual = {"pressure": c.NOMPRES, "speed": 1.0}
        for name in AXES:
            if name not in of:
                of[name] = np.full(of["fz"].shape, usual.get(name, 0.0))
        of["speed"] = np.maximum(np.abs(of["speed"]), 0.01)
        return SimpleNamespace(**of, nominal=c)


def sweep_model(
    studies: Sequence[Study], tir: TirFile, signs: str = READ, swept: str = "alpha"
) -> SweepModel:
    """The model of all sweeps of a slip. The error of the Magic Formula itself is what B, C, D, E
    of each condition by itself leave (median of the conditions).

    Raises:
        FlatplankError: the slip was not swept, or there is no such convention of signs.
    """
    runs = runs_of(studies, swept)
    left = [
        formula.rms for one in studies
        for condition, formula in zip(one.conditions, one.formulas, strict=True)
        if condition.swept == swept and formula
    ]  # fmt: skip
    law = float(np.median(left)) / float(runs.largest[0]) if left else 0.0
    return SweepModel(runs, tir, convention(signs), law)


def _with(effect: Any, values: np.ndarray) -> Any:
    names = [parameter.name for parameter in effect.parameters()]
    return effect(**dict(zip(names, (float(v) for v in values), strict=True)))
