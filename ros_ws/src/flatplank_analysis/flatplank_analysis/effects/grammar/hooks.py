# SPDX-License-Identifier: Apache-2.0
"""Quantities on which a proposed effect of the flat plank may act, each in one hook method of
`TireEffect`; those in sweeps are in `sweep_hooks`.

The function of a hook applies a change: the value of the shape, in `unit`, (sets, runs, samples).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.effects.base import Motion, Signal, Tire
from flatplank_analysis.effects.force_channel import shifted
from flatplank_analysis.effects.grammar.proposed import Proposed
from flatplank_analysis.effects.grammar.shapes.base import ANGLE, LEVEL, PLACE, SIGNAL

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
    apply: Callable[[Any, np.ndarray], None]
    """changes the argument of the method, given the values of the shape"""
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
    steady: bool = False
    """True where a setting may make repeats differ through it; each power of the setting is
    removed separately, because repeats have few degrees of freedom"""
    base: type[Effect] = Proposed
    """class of its effects, which has the method"""


def _to_fx(signal: Signal, change: np.ndarray) -> None:
    signal.fx = signal.fx + change


def _to_fy(signal: Signal, change: np.ndarray) -> None:
    signal.fy = signal.fy + change


def _to_gain(signal: Signal, change: np.ndarray) -> None:
    signal.fx = signal.fx + change * signal.true_fx


def _to_delay(signal: Signal, change: np.ndarray) -> None:
    signal.fx = shifted(signal.fx, signal.data.runs.time, change)


def _to_slip(motion: Motion, change: np.ndarray) -> None:
    motion.rolled = motion.rolled * (1.0 + change)


def _to_travel(motion: Motion, change: np.ndarray) -> None:
    motion.travel = motion.travel + np.diff(change, axis=-1, prepend=change[..., :1])


def _to_friction(tire: Tire, change: np.ndarray) -> None:
    tire.friction = tire.friction * (1.0 + change)


def _to_stiffness(tire: Tire, change: np.ndarray) -> None:
    tire.x.stiff = tire.x.stiff * (1.0 + change.mean(axis=-1))


def _to_carcass(tire: Tire, change: np.ndarray) -> None:
    tire.x.carcass = tire.x.carcass * (1.0 + change.mean(axis=-1))


def _to_load(tire: Tire, change: np.ndarray) -> None:
    tire.load = tire.load + change


FX = "Hang weights or a calibrated spring on the wheel and compare Fx with them"
_MOTION = "A second encoder on the plank itself, or a dial gauge against the wheel"

HOOKS: tuple[Hook, ...] = (
    Hook("fx", "signal", "signal", _to_fx, "N", 10.0, 5.0, 2000.0,
         "machine", "a force in Fx", "Look for what pulls at plank or wheel",
         ("", "driving", "braking", "slipping", "sign of slip", "slip", "size of slip",
          "little slip", "load", "speed"), steady=True),
    Hook("fy", "signal", "signal", _to_fy, "N", 10.0, 5.0, 2000.0,
         "machine", "a force in Fy", "Look for what pushes plank or wheel sideways",
         needs="fy"),
    Hook("gain", "gain", "signal", _to_gain, "1", 0.01,
         0.005, 0.5, "sensor", "a factor on Fx", FX, SIDES, steady=True),
    Hook("slip", "motion", "motion", _to_slip, "1", 1e-3,
         2e-4, 0.05, "machine", "a slip that the encoders do not see", _MOTION, SIDES,
         (NONE, LEVEL, PLACE, ANGLE, SIGNAL), shown=True, steady=True),
    Hook("travel", "motion", "motion",
         _to_travel,
         "m", 1e-4, 2e-5, 5e-3, "machine", "a travel of the plank that the encoders do not see",
         _MOTION, SIDES, (PLACE, ANGLE, SIGNAL), shown=True),
    Hook("friction", "friction", "tire", _to_friction, "1",
         0.02, 0.01, 0.5, "tire", "a factor on the friction between tire and road",
         "Look at the road surface and at the tread; clean it, and measure again", SIDES,
         steady=True),
    Hook("stiffness", "stiffness", "tire",
         _to_stiffness, "1", 0.02, 0.01, 0.5,
         "tire", "a factor on the slip stiffness",
         "Measure the slip stiffness at both ends of the range, in random order",
         kinds=(LEVEL,)),
    Hook("carcass", "stiffness", "tire",
         _to_carcass, "1", 0.05, 0.01, 0.8,
         "tire", "a factor on the stiffness of the carcass",
         "Measure the static stiffness at both ends of the range", kinds=(LEVEL,)),
    Hook("load", "load", "tire", _to_load, "N", 20.0, 10.0, 2000.0,
         "machine", "a load on the tire that the load channel does not show",
         "Put a second load cell under the wheel", shown=True),
    Hook("delay", "delay", "signal",
         _to_delay, "s", 0.02, 0.01, 1.0, "sensor",
         "a delay of Fx against the motion",
         "Tap the wheel while force and motion are recorded, early and late",
         kinds=(PLACE, LEVEL, SIGNAL), order=90),
)  # fmt: skip
