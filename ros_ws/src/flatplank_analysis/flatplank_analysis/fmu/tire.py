# SPDX-License-Identifier: Apache-2.0
"""A transient tire as variables, states and two C functions: start and step.

The equations are those of `models.mf_tyre`, called with expressions (`trace`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from flatplank_analysis.fmu.trace import Expression, Trace
from flatplank_analysis.models.base import SPEED
from flatplank_analysis.models.linear import relaxed
from flatplank_analysis.models.mf_tyre import (
    SMALL,
    Contact,
    Curve,
    advanced,
    longitudinal_force,
    started,
)
from flatplank_analysis.models.tire_state import TireState, tire_state
from flatplank_data.errors import FlatplankError
from flatplank_tire.magic_formula import Coefficients, OperatingPoint, operating_point, steady
from flatplank_tire.magic_formula import structure as shape
from flatplank_tire.magic_formula.state import Value
from flatplank_tire.tir import TirFile


class Variable(NamedTuple):
    """A variable of the model description."""

    name: str
    causality: str
    variability: str
    unit: str
    text: str
    start: float | None = None


@dataclass(frozen=True)
class Tire:
    """What the files of an FMU are written from."""

    variables: Sequence[Variable]
    """the value reference of a variable is its place; time is the first"""
    states: int
    start: Sequence[str]
    """C lines: `state` and `out` from `in`"""
    step: Sequence[str]
    """C lines: `state` and `out` from `in`, `state` and the size `h` of the step [s]"""


class Law(NamedTuple):
    """How the slip of the contact point follows that of the wheel."""

    title: str
    states: int
    start: Callable[[Coefficients, OperatingPoint, Value], Sequence[Value]]
    """coefficients, point without slip, start force [N] -> states"""
    step: Callable[[Coefficients, OperatingPoint, Value, Value, Sequence[Value]], Sequence[Value]]
    """coefficients, point, travel [m], slip [m], states -> states"""
    slip: Callable[[Coefficients, OperatingPoint, Sequence[Value]], Value]
    """states -> slip of the contact point [-]"""


def _start_deflection(c: Coefficients, o: OperatingPoint, force: Value) -> Sequence[Value]:
    still = steady(c, o._replace(alpha=0.0))
    return [(force - still.fx) / still.kxk * shape.relaxation_x(c, o)]


def _step_deflection(
    c: Coefficients, o: OperatingPoint, travel: Value, slip: Value, states: Sequence[Value]
) -> Sequence[Value]:
    kept, share = relaxed(travel, shape.relaxation_x(c, o))
    return [kept * states[0] + share * slip]


def _deflection_slip(c: Coefficients, o: OperatingPoint, states: Sequence[Value]) -> Value:
    return states[0] / shape.relaxation_x(c, o)


def _curve(c: Coefficients, o: OperatingPoint) -> Curve:
    force = partial(longitudinal_force, c, o)

    def of(slip: Value) -> tuple[Value, Value]:
        here = force(slip)
        return here, (force(slip + SMALL) - here) / SMALL

    return of


def _start_contact(c: Coefficients, o: OperatingPoint, force: Value) -> Sequence[Value]:
    return started(_curve(c, o), 0.0, force)


def _step_contact(
    c: Coefficients, o: OperatingPoint, travel: Value, slip: Value, states: Sequence[Value]
) -> Sequence[Value]:
    at = Contact(*states)
    return advanced(_curve(c, o), travel, slip, shape.stiffness_x(c, o), at)


def _contact_slip(_c: Coefficients, _o: OperatingPoint, states: Sequence[Value]) -> Value:
    return states[0]


LAWS: Mapping[str, Law] = {
    "mf_contact_point": Law(
        "MF-Tyre, contact point on the carcass spring", 3,
        _start_contact, _step_contact, _contact_slip,
    ),
    "mf": Law(
        "MF-Tyre, constant relaxation length", 1,
        _start_deflection, _step_deflection, _deflection_slip,
    ),
}  # fmt: skip
"""name of a transient model as in the tables of a report -> its equations"""

INPUTS = (
    ("fz", "N", "vertical force"),
    ("vx", "m/s", "velocity of the wheel over the road, in the wheel plane"),
    ("omega", "rad/s", "angular velocity of the wheel, forward rolling > 0"),
    ("alpha", "rad", "side slip angle, ISO W"),
    ("gamma", "rad", "camber angle, ISO W"),
    ("pressure", "Pa", "inflation pressure"),
)
STARTS = (
    ("start_fx", "N", "longitudinal force at the start"),
    ("start_fy", "N", "lateral force at the start"),
)
FRICTION = (
    ("LMUX", "", "scaling factor of the longitudinal friction"),
    ("LMUY", "", "scaling factor of the lateral friction"),
)
"""coefficients that can be changed while a simulation runs"""
OUTPUTS = (
    ("fx", "N", "longitudinal force, ISO W"),
    ("fy", "N", "lateral force, ISO W"),
    ("mz", "N.m", "aligning moment, ISO W"),
    ("re", "m", "effective rolling radius"),
)


def tire_of(tir: TirFile, law: str) -> Tire:
    """The FMU's content for the coefficients of a file.

    Raises FlatplankError where a coefficient that the model needs is missing.
    """
    c = tir.coefficients
    state = _checked(tir, law)
    outputs = [o for o in OUTPUTS if math.isfinite(getattr(state, o[0]))]
    nominal = {"fz": c.FNOMIN, "pressure": c.INFLPRES or c.NOMPRES}
    variables = [
        Variable("time", "independent", "continuous", "s", "time"),
        *(Variable(n, "input", "continuous", u, t, nominal.get(n, 0.0)) for n, u, t in INPUTS),
        *(Variable(n, "parameter", "fixed", u, t, 0.0) for n, u, t in STARTS),
        *(Variable(n, "parameter", "tunable", u, t, getattr(c, n)) for n, u, t in FRICTION),
        *(Variable(n, "output", "continuous", u, t) for n, u, t in outputs),
    ]
    names = [name for name, *_ in outputs]
    relaxes = math.isfinite(state.sigma_y)
    start, step = (
        _Function(c, LAWS[law], relaxes, names, variables).lines(begins)
        for begins in (True, False)
    )
    return Tire(variables, LAWS[law].states + 1, start, step)


def _checked(tir: TirFile, law: str) -> TireState:
    """State at the nominal load; an error for what the transient model cannot do without."""
    c = tir.coefficients
    state = tire_state(c, c.FNOMIN)
    lacks = {
        "PCX1, PDX1, PKX1": not math.isfinite(state.kx),
        "VERTICAL_STIFFNESS": not math.isfinite(state.re),
        "LONGITUDINAL_STIFFNESS": law == "mf_contact_point"
        and not math.isfinite(float(shape.known(c.LONGITUDINAL_STIFFNESS))),
        "LONGITUDINAL_STIFFNESS or PTX1": not math.isfinite(state.sigma_x),
    }
    missing = [name for name, lack in lacks.items() if lack]
    if missing:
        remedy = "add it, by flatplank fit --model mf --out FILE.tir"
        if missing == ["LONGITUDINAL_STIFFNESS"]:
            remedy = "add it, or use --model mf"
        raise FlatplankError(f"missing {missing[0]}", tir.path, remedy)
    return state


class _Function:
    """One of the two C functions, with inputs and states as expressions."""

    def __init__(
        self, c: Coefficients, law: Law, relaxes: bool, outputs: Sequence[str],
        variables: Sequence[Variable],
    ) -> None:  # fmt: skip
        self.trace = trace = Trace()
        given = [v.name for v in variables if v.causality in ("input", "parameter")]
        self.input = {name: trace.variable(f"in[{i}]") for i, name in enumerate(given)}
        self.c = c.replaced({name: self.input[name] for name, *_ in FRICTION})
        self.law, self.relaxes, self.outputs = law, relaxes, outputs
        at = self.input
        self.point = operating_point(
            self.c, at["fz"], 0.0, 0.0, at["gamma"], at["pressure"], SPEED
        )

    def lines(self, begins: bool) -> list[str]:
        """C lines of the start, or of a step."""
        along, across = self._start() if begins else self._step()
        o = self._side(across)
        kappa = self.law.slip(self.c, o, along)
        forces = steady(self.c, o._replace(kappa=kappa))._asdict() | {"re": self._radius()}
        targets: dict[str, Any] = {
            f"state[{i}]": value for i, value in enumerate([*along, across])
        }
        targets |= {f"out[{i}]": forces[name] for i, name in enumerate(self.outputs)}
        return self.trace.lines(targets)

    def _start(self) -> tuple[Sequence[Value], Value]:
        across: Value = 0.0
        if self.relaxes:
            still = steady(self.c, self.point)
            across = (self.input["start_fy"] - still.fy) / still.kya
            across = across * shape.relaxation_y(self.c, self.point)
        o = self._side(across)
        return self.law.start(self.c, o, self.input["start_fx"]), across

    def _step(self) -> tuple[Sequence[Value], Value]:
        states: list[Expression] = [
            self.trace.variable(f"state[{i}]") for i in range(self.law.states + 1)
        ]
        at, h = self.input, self.trace.variable("h")
        travel = np.absolute(at["vx"]) * h
        across: Value = 0.0
        if self.relaxes:
            kept, share = relaxed(travel, shape.relaxation_y(self.c, self.point))
            across = kept * states[-1] + share * (np.tan(at["alpha"]) * travel)
        slip = (self._radius() * at["omega"] - at["vx"]) * h
        o = self._side(across)
        return self.law.step(self.c, o, travel, slip, states[:-1]), across

    def _side(self, across: Value) -> OperatingPoint:
        """The point with the side slip angle of the contact; the wheel's own without a lag."""
        if not self.relaxes:
            return self.point._replace(alpha=self.input["alpha"])
        return self.point._replace(
            alpha=np.arctan(across / shape.relaxation_y(self.c, self.point))
        )

    def _radius(self) -> Value:
        o = self.point._replace(alpha=self.input["alpha"])
        return shape.effective_radius(self.c, o, self.input["omega"])
