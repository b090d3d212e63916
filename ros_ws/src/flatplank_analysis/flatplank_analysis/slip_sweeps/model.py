# SPDX-License-Identifier: Apache-2.0
"""A tire file as the base of the search on sweeps.

The base fits the file's friction, slip stiffness and form of the curve again, and how they follow
the load where there are several; everything else of the file is held. An effect changes what the
file is given, its scale factors, or what the bench shows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from flatplank_analysis.discovery.model import FormError, ParameterSet
from flatplank_analysis.discovery.parameters import Parameter
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.slip_sweeps.channels_of_runs import SweepChannels, channels_of
from flatplank_analysis.slip_sweeps.effects import that_can_show
from flatplank_analysis.slip_sweeps.origin import is_fitted_to
from flatplank_analysis.slip_sweeps.runs import AXES, runs_of
from flatplank_analysis.slip_sweeps.study import Study
from flatplank_analysis.slip_sweeps.tir_signs import READ, TirSigns, convention
from flatplank_tire.magic_formula import operating_point, steady
from flatplank_tire.tir import TirFile

FORM = (
    Parameter("shape", null=1.0, lower=0.6, upper=1.4, screen=0.02, prior=0.1),
    Parameter("curvature", null=0.0, lower=-2.0, upper=2.0, screen=0.1, prior=0.5),
)
"""factor on C, and change of E: what these sweeps do not determine stays near the file"""
OVER_LOAD = (
    Parameter("grip_load", null=0.0, lower=-0.5, upper=0.5, screen=0.02, prior=0.1),
    Parameter("stiffness_load", null=0.0, lower=-1.5, upper=1.5, screen=0.02, prior=0.3),
    Parameter("curvature_load", null=0.0, lower=-2.0, upper=2.0, screen=0.1, prior=0.5),
)
"""change for each nominal load beyond the nominal one: of the factors, and of E"""
BEYOND = 1.25
"""allowed error of the base relative to what free B, C, D, E leave of each condition, chosen by
hand. `bench-sweeps --forms` prints the ratio for ten tires of other forms, nothing hidden: at most
1.08 for seven of them, 1.6 to 5 for three, which the base does not describe"""


class SweepModel:
    """The force of a tire file in the bins of sweeps."""

    def __init__(
        self, runs: RunSet, tir: TirFile, signs: TirSigns, form: float, own: bool = False
    ) -> None:
        """signs: under which the file was fitted; form: error of the Magic Formula itself, as a
        share of the largest force; own: the file was fitted to these sweeps, so that the base
        fits again what the equations have."""
        self.runs, self.tir, self.signs = runs, tir, signs
        self.channel = runs.channels[0]
        self.form = FormError(mean=form)
        self.laws = runs.facts["law"].tolist()
        self.middle = {name: float(np.median(values)) for name, values in channels_of(runs)}
        """of every coordinate of the sweeps [SI]"""
        shown = that_can_show(runs)
        self.inside = [e for e in shown if own and e.in_file]
        """effects that the base fits"""
        self.effects = [e for e in shown if e not in self.inside]
        """effects that may be missing"""
        mains = ((e.identifier, e.main_parameter()) for e in self.inside)
        again = (replace(p, name=name, matters=0.0) for name, p in mains)
        self.parameters = (*_base("fz" in runs.coordinates), *again)

    def scatter_directions(self, base: np.ndarray) -> tuple[dict[str, float], ...]:
        """Nothing of a tire file scatters from visit to visit."""
        return ()

    def take_references(self, other: SweepModel) -> None:
        """Take the base of other sweeps, and their middle as the reference of effects."""
        self.inside, self.effects, self.parameters = other.inside, other.effects, other.parameters
        self.middle |= {k: v for k, v in other.middle.items() if k in self.middle}

    def predict(self, sets: Sequence[ParameterSet]) -> np.ndarray:
        """Force (sets, 1, runs, nodes) [N]."""
        return np.stack([self._one(one)[None] for one in sets])

    def _one(self, one: ParameterSet) -> np.ndarray:
        s = self.state()
        base = {p.name: v for p, v in zip(self.parameters, one.base, strict=True)}
        inside = ((effect, base[effect.identifier]) for effect in self.inside)
        effects = [_with(effect, [value]) for effect, value in inside]
        effects += [_with(effect, values) for effect, values in one.effects]
        for effect in effects:
            effect.tire(s)
        c = self.tir.coefficients.replaced(self._coefficients(base, s))
        alpha, gamma = self.signs.alpha * s.alpha, self.signs.gamma * s.gamma
        point = operating_point(c, s.fz, s.kappa, alpha, gamma, s.pressure, s.speed)
        force = getattr(steady(c, point), self.channel) * getattr(self.signs, self.channel, 1)
        s.force = np.broadcast_to(force, s.fz.shape)
        for effect in effects:
            effect.bench(s)
        return s.force

    def _coefficients(self, base: dict[str, float], s: Any) -> dict[str, Any]:
        """Coefficients of the file that base and effects change; a scale factor may differ from
        sample to sample."""
        c, axis, more = self.tir.coefficients, self.channel[1].upper(), s.fz / s.nominal.FNOMIN - 1
        bend = 1.0 + base.get("grip_load", 0.0) * more
        stiffer = 1.0 + base.get("stiffness_load", 0.0) * more
        factors = {
            f"LMU{axis}": base["grip"] * bend * s.grip,
            f"LK{axis}": base["stiffness"] * stiffer * s.stiffness,
            f"LC{axis}": base["shape"],
        }
        out = {name: getattr(c, name) * factor for name, factor in factors.items()}
        curvature = base["curvature"] + base.get("curvature_load", 0.0) * more
        return out | {f"PE{axis}1": getattr(c, f"PE{axis}1") + curvature}

    def state(self) -> Any:
        """What the file is given, by name, every coordinate of the sweeps, and the factors of
        friction and stiffness, both 1."""
        of = dict(channels_of(self.runs))
        c = self.tir.coefficients
        usual = {"pressure": c.NOMPRES, "speed": 1.0}
        for name in AXES:
            if name not in of:
                of[name] = np.full(of["fz"].shape, usual.get(name, 0.0))
        of["speed"] = np.maximum(np.abs(of["speed"]), 0.01)

        def above(name: str) -> np.ndarray:
            return of[name] - self.middle[name]

        factors = {"grip": 1.0, "stiffness": 1.0}
        data = SweepChannels(self.runs)
        return SimpleNamespace(**of, **factors, above=above, nominal=c, data=data)


def _base(among_loads: bool) -> tuple[Parameter, ...]:
    """What the base fits: factors on friction and slip stiffness, form of the curve (C and E), and
    with several loads how these follow the load."""
    free = [
        Parameter(name, null=1.0, lower=0.3, upper=2.0, screen=0.02)
        for name in ("grip", "stiffness")
    ]
    return (*free, *FORM, *(OVER_LOAD if among_loads else ()))


def sweep_model(
    studies: Sequence[Study], tir: TirFile, signs: str = READ, swept: str = "alpha"
) -> SweepModel:
    """The model of all sweeps of a slip.

    Raises:
        FlatplankError: the slip was not swept, or there is no such convention of signs.
    """
    runs = runs_of(studies, swept)
    form = BEYOND * _form_error(studies, swept) / float(runs.largest[0])
    own = is_fitted_to(tir, [one.path for one in studies])
    return SweepModel(runs, tir, convention(signs), form, own)


def _form_error(studies: Sequence[Study], swept: str) -> float:
    """Error of the Magic Formula itself [N]: the share of the largest force that free B, C, D, E
    leave of a condition (median), of the largest forces of all."""
    known = [
        (formula.rms, float(np.nanmax(np.abs(curve.force)))) for one in studies
        for condition, curve, formula in zip(
            one.conditions, one.curves, one.formulas, strict=True
        )
        if condition.swept == swept and formula
    ]  # fmt: skip
    if not known:
        return 0.0
    left, largest = np.array(known).T
    return float(np.median(left / largest) * np.sqrt(np.mean(largest**2)))


def _with(effect: Any, values: Sequence[float] | np.ndarray) -> Any:
    names = [parameter.name for parameter in effect.parameters()]
    return effect(**dict(zip(names, (float(v) for v in values), strict=True)))
