# SPDX-License-Identifier: Apache-2.0
"""Parasitic force of the preloaded shaft."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.effects.base import Signal, Tire
from flatplank_analysis.effects.turning_force import TurningForce
from flatplank_analysis.effects.waves import wave


@dataclass(frozen=True)
class ParasiticForce(TurningForce):
    """Once per turn of the wheel, the same at every slip and load, in the forces that the hub
    shows.
    """

    identifier = "parasitic_force"
    title = "Parasitic force of the preloaded shaft"
    kind = "machine"
    source = "thesis Appendix C: about 300 N before, 15-25 N after the correction"
    what = (
        "The shaft is bent or the flexplates are preloaded: the hub feels a force that turns "
        "with the wheel, even when the wheel is lifted."
    )
    check = "Turn the unloaded wheel three times and look at the forces."
    removes = "The parasitic filter with a fresh three-turn run; a longer flexplate drum."

    def tire(self, tire: Tire) -> None:
        # the load channel shows a force that the tire does not feel
        tire.load -= wave(tire.data.wheel_turn, 1, self.fz_cos, self.fz_sin)

    def signal(self, signal: Signal) -> None:
        angle = signal.data.wheel_turn
        signal.fx = signal.fx + wave(angle, 1, self.fx_cos, self.fx_sin)
        signal.fz = signal.fz + wave(angle, 1, self.fz_cos, self.fz_sin)
