# SPDX-License-Identifier: Apache-2.0
"""Dependence on the load that the equations of the tire file do not have."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.sweep_base import SweepEffect


@dataclass(frozen=True)
class LawOverLoad(SweepEffect):
    """Friction and slip stiffness follow the square of the load beyond the nominal one.

    Source: Pacejka, Tire and Vehicle Dynamics (2012) equations 4.E23 and 4.E25, where friction is
    linear in the load and the slip stiffness follows a sine.
    """

    identifier = "law_load"
    title = "law of another form over the load"
    kind = "tire"
    coordinate = "fz"
    generic = True
    law = True
    needs = ("fz",)
    what = "the tire is in order; its forces follow the load otherwise than the equations"
    check = "nothing to check on the bench"
    removes = "use the file between the measured loads alone, or another law"
    stiffness: float = param(
        0.0, unit="1", bounds=(-2.0, 2.0), screen=0.02, matters=0.01,
        title="slip stiffness over load squared", symbol="q_K",
        note="Relative change of the slip stiffness over the square of that of the load.",
    )  # fmt: skip
    grip: float = param(
        0.0, unit="1", bounds=(-1.0, 1.0), screen=0.02, matters=0.01,
        title="friction over load squared", symbol="q_μ",
        note="Relative change of the friction over the square of that of the load.",
    )  # fmt: skip

    def tire(self, s: Any) -> None:
        more = (s.fz / s.nominal.FNOMIN - 1.0) ** 2
        s.stiffness = s.stiffness * (1.0 + self.stiffness * more)
        s.grip = s.grip * (1.0 + self.grip * more)
