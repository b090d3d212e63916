# SPDX-License-Identifier: Apache-2.0
"""A free correction of the steady force over the contact slip, driving and braking apart."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Tire, TireEffect

LEVELS = (
    "brake_10", "brake_5", "brake_2", "brake_1", "drive_1", "drive_2", "drive_5", "drive_10",
)  # fmt: skip


@dataclass(frozen=True)
class FreeLaw(TireEffect):
    """A free correction of the steady force over the contact slip, driving and braking apart."""

    identifier = "tire_law"
    title = "The force law is of another form"
    kind = "tire"
    coordinate = "slip level"
    law = True
    source = "thesis 7.2: look-up table of the steady force"
    what = (
        "The machine is fine; the symmetric force law of the base is not the law of this "
        "tire. A table of the steady force may swallow a drive/brake asymmetry, so it is the "
        "last name to be given."
    )
    check = "Nothing to check on the machine."
    removes = "A table of the steady force, or another law."
    generic = True

    brake_10: float = param(0.0, unit="1", bounds=(-0.4, 0.4), screen=0.02, matters=0.01)
    brake_5: float = param(0.0, unit="1", bounds=(-0.4, 0.4), screen=0.02)
    brake_2: float = param(0.0, unit="1", bounds=(-0.4, 0.4), screen=0.02)
    brake_1: float = param(0.0, unit="1", bounds=(-0.4, 0.4), screen=0.02)
    drive_1: float = param(0.0, unit="1", bounds=(-0.4, 0.4), screen=0.02)
    drive_2: float = param(0.0, unit="1", bounds=(-0.4, 0.4), screen=0.02)
    drive_5: float = param(0.0, unit="1", bounds=(-0.4, 0.4), screen=0.02)
    drive_10: float = param(0.0, unit="1", bounds=(-0.4, 0.4), screen=0.02)

    @classmethod
    def size(cls, values: dict[str, float]) -> float:
        return max(values.values(), key=abs)

    def tire(self, tire: Tire) -> None:
        for i, name in enumerate(LEVELS):
            block = f"law_{i}"
            setattr(tire.x, block, getattr(tire.x, block) + getattr(self.per_run, name))
