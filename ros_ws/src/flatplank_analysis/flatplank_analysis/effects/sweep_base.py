# SPDX-License-Identifier: Apache-2.0
"""What sweeps may show beside the tire file. An effect is one file of `slip_sweeps/effects`."""

from __future__ import annotations

from typing import Any, ClassVar

from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.runs import RunSet


class SweepEffect(Effect):
    """An effect in sweeps: `tire` acts before the tire file, `bench` on its force.

    The state `s` has what the file is given (`fz`, `kappa`, `alpha`, `gamma`, `pressure`,
    `speed`), the factors `grip` and `stiffness`, where the sweeps have them `time`, `distance`,
    `temperature` and `rate`, and in `bench` the `force` [N]. Shapes (runs, nodes), SI, ISO W.
    `s.above(name)` has the values of one of them from the middle of the sweeps on, so that the
    base keeps that middle.
    """

    needs: ClassVar[tuple[str, ...]] = ()
    """coordinates that must vary in the sweeps: the kind of data in which it can show"""
    in_file: ClassVar[bool] = False
    """True when the equations of a tire file have it, or imitate it: a file that was fitted to the
    sweeps has taken it in"""

    def tire(self, s: Any) -> None:
        """Change what the file is given, or its factors."""

    def bench(self, s: Any) -> None:
        """Change what is measured."""

    @classmethod
    def can_show(cls, runs: RunSet) -> bool:
        """Whether these sweeps have what the effect needs."""
        return all(name in runs.coordinates for name in cls.needs)
