# SPDX-License-Identifier: Apache-2.0
"""The third tire as a world of the blind kit: effects that it can hide, and its campaigns."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from flatplank_sim.sealed.conditions import Run
from flatplank_validation.blind.third import RADIUS, Columns, ThirdMachine, ThirdTire, measure

if TYPE_CHECKING:
    from flatplank_validation.blind.worlds import Scatter

Hide = Callable[[float, np.random.Generator], Mapping[str, Any]]


def _patch(size: float, random: np.random.Generator) -> Mapping[str, Any]:
    low = float(random.uniform(1.9, 3.3))
    return {"patch": (low, low + float(random.uniform(0.15, 0.35)), size)}


HIDES: dict[str, Hide] = {
    "road_play": lambda s, r: {"road_play": s, "road_rest": float(r.uniform(-1.0, 1.0))},
    "steering_play": lambda s, r: {"steering_play": s},
    "load_loss_braking": lambda s, r: {"loss": s},
    "worn_patch": _patch,
    "parasitic_force": lambda s, r: {"parasitic": (s, 0.7 * s)},
    "carcass_load": lambda s, r: {"carcass_load": s},
}
"""effect of the library -> function from its size to fields of the machine"""


@dataclass(frozen=True)
class ThirdWorld:
    """World of the third tire; see third_kernel.py."""

    tire: ThirdTire = field(default_factory=ThirdTire)
    radius: float = RADIUS

    @classmethod
    def drawn(cls, random: np.random.Generator | None = None) -> ThirdWorld:
        """The nominal tire, or a random one like it."""
        return cls() if random is None else cls(ThirdTire().drawn(random))

    def has(self, name: str) -> bool:
        return name in HIDES

    def run(
        self,
        runs: Sequence[Run],
        sizes: Mapping[str, float],
        random: np.random.Generator,
        scatter: Scatter,
    ) -> list[Columns]:
        """Make all runs without sensor noise, with effects of these sizes."""
        fields: dict[str, Any] = {}
        for name, size in sizes.items():
            fields |= HIDES[name](size, random)
        machine = ThirdMachine(**fields)
        return [
            measure(
                self.tire, machine, run, float(scatter.gain[run.index]),
                float(scatter.delay[run.index]), scatter.bumps,
            )
            for run in runs
        ]  # fmt: skip

    def nuisances(self) -> tuple[Mapping[str, float], ...]:
        """Small changes of the tire that a fit of the tire can absorb."""
        t = self.tire
        part = {n: 0.01 * getattr(t, n) for n in ("thread_x", "thread_y", "share", "grip_x")}
        part |= {n: 0.03 * getattr(t, n) for n in ("carcass_x", "carcass_y", "vertical")}
        part |= {"grip_y": 0.01, "lost": 0.02, "slow": 5e-4, "forward": 0.03, "thin": 0.02}
        part |= {"rolling": 1e-3, "offset": 2e-4}
        return tuple({name: step} for name, step in part.items())

    def changed(self, change: Mapping[str, float]) -> ThirdWorld:
        """The same world with a changed tire."""
        new = {name: getattr(self.tire, name) + step for name, step in change.items()}
        return ThirdWorld(replace(self.tire, **new), self.radius)
