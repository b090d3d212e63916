# SPDX-License-Identifier: Apache-2.0
"""Quantities on which a proposed effect may act, each in one hook method of `TireEffect`.

`line` is the code in the effect's file; `change` in it is the value of the shape, in `unit`.
"""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.proposal.shapes.base import ANGLE, LEVEL, PLACE, SIGNAL

NONE = "none"
"""no coordinate: only the modulator makes the effect vary"""
ALL = (NONE, PLACE, ANGLE, LEVEL, SIGNAL)
SIDES = ("", "driving", "braking")


@dataclass(frozen=True)
class Hook:
    """One quantity on which an effect may act."""

    name: str
    family: str
    """one of signal, gain, motion, friction, stiffness, load, delay"""
    method: str
    line: str
    unit: str
    screen: float
    matters: float
    most: float
    """largest size"""
    kind: str
    words: str
    check: str
    modulators: tuple[str, ...] = ("",)
    kinds: tuple[str, ...] = ALL
    """kinds of coordinates over which it is tried"""
    order: int = 0
    needs: str | None = None
    """channel that the runs must have, and that cannot be its coordinate"""
    shown: bool = False
    """True where a measured channel would show the effect itself"""


FX = "Hang weights or a calibrated spring on the wheel and compare Fx with them"
_MOTION = "A second encoder on the plank itself, or a dial gauge against the wheel"

HOOKS: tuple[Hook, ...] = (
    Hook("fx", "signal", "signal", "signal.fx = signal.fx + change", "N", 10.0, 5.0, 2000.0,
         "machine", "a force in Fx", "Look for what pulls at plank or wheel",
         ("", "driving", "braking", "slipping", "sign of slip", "slip", "size of slip",
          "little slip", "load", "speed")),
    Hook("fy", "signal", "signal", "signal.fy = signal.fy + change", "N", 10.0, 5.0, 2000.0,
         "machine", "a force in Fy", "Look for what pushes plank or wheel sideways",
         needs="fy"),
    Hook("gain", "gain", "signal", "signal.fx = signal.fx + change * signal.true_fx", "1", 0.01,
         0.005, 0.5, "sensor", "a factor on Fx", FX, SIDES),
    Hook("slip", "motion", "motion", "motion.rolled = motion.rolled * (1.0 + change)", "1", 1e-3,
         2e-4, 0.05, "machine", "a slip that the encoders do not see", _MOTION, SIDES,
         (NONE, LEVEL, PLACE, ANGLE, SIGNAL), shown=True),
    Hook("travel", "motion", "motion",
         "motion.travel = motion.travel + np.diff(change, axis=-1, prepend=change[..., :1])",
         "m", 1e-4, 2e-5, 5e-3, "machine", "a travel of the plank that the encoders do not see",
         _MOTION, SIDES, (PLACE, ANGLE, SIGNAL), shown=True),
    Hook("friction", "friction", "tire", "tire.friction = tire.friction * (1.0 + change)", "1",
         0.02, 0.01, 0.5, "tire", "a factor on the friction between tire and road",
         "Look at the road surface and at the tread; clean it, and measure again", SIDES),
    Hook("stiffness", "stiffness", "tire",
         "tire.x.stiff = tire.x.stiff * (1.0 + change.mean(axis=-1))", "1", 0.02, 0.01, 0.5,
         "tire", "a factor on the slip stiffness",
         "Measure the slip stiffness at both ends of the range, in random order",
         kinds=(LEVEL,)),
    Hook("carcass", "stiffness", "tire",
         "tire.x.carcass = tire.x.carcass * (1.0 + change.mean(axis=-1))", "1", 0.05, 0.01, 0.8,
         "tire", "a factor on the stiffness of the carcass",
         "Measure the static stiffness at both ends of the range", kinds=(LEVEL,)),
    Hook("load", "load", "tire", "tire.load = tire.load + change", "N", 20.0, 10.0, 2000.0,
         "machine", "a load on the tire that the load channel does not show",
         "Put a second load cell under the wheel", shown=True),
    Hook("delay", "delay", "signal",
         "signal.fx = shifted(signal.fx, data.runs.time, change)", "s", 0.02, 0.01, 1.0, "sensor",
         "a delay of Fx against the motion",
         "Tap the wheel while force and motion are recorded, early and late",
         kinds=(PLACE, LEVEL, SIGNAL), order=90),
)  # fmt: skip
