# SPDX-License-Identifier: Apache-2.0
"""Force and motion are stamped by clocks that differ by a constant."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Signal, TireEffect
from flatplank_analysis.effects.delays import shifted


@dataclass(frozen=True)
class TimeSkew(TireEffect):
    """Force and motion are stamped by clocks that differ by a constant."""

    identifier = "time_skew"
    title = "Skew between force and motion recording"
    kind = "sensor"
    coordinate = "time"
    source = "thesis 3.2: two computers log force and motion"
    what = (
        "Forces and motions are recorded by two computers; one stamps late. All forces move "
        "together against the motion."
    )
    check = (
        "Tap the wheel while both record; compare the start of the force with the start of "
        "the plank."
    )
    removes = "One clock, one trigger for both recorders; or the found skew in the import."
    order = 90

    skew: float = param(
        0.0,
        unit="s",
        bounds=(-1.0, 1.0),
        screen=0.05,
        matters=0.02,
        note="the force comes later by this",
    )

    def signal(self, signal: Signal) -> None:
        time = signal.data.runs.time
        for name in ("fx", "fy"):
            setattr(signal, name, shifted(getattr(signal, name), time, self.skew))
